//! The header of a PLY file: the encoding and the elements with their properties.

use super::input::Input;
use crate::load::error::LoadProblem;
use std::io::BufRead;

/// The encoding of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    /// 64-bit integers are an extension of yocto-gl.
    I64,
    U64,
    F32,
    F64,
}

impl Type {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "long" | "int64" => Self::I64,
            "ulong" | "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Returns the size in bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Returns whether there are numbers of this type that single precision rounds.
    pub(super) fn is_finer_than_single(self) -> bool {
        matches!(self, Self::I32 | Self::U32 | Self::I64 | Self::U64 | Self::F64)
    }

    /// Returns the value that represents 1 in colours of this type.
    pub(super) fn one(self) -> f32 {
        match self {
            Self::I8 => f32::from(i8::MAX),
            Self::U8 => f32::from(u8::MAX),
            Self::I16 => f32::from(i16::MAX),
            Self::U16 => f32::from(u16::MAX),
            // 2^31 - 1, 2^32 - 1, 2^63 - 1 and 2^64 - 1, rounded to f32.
            Self::I32 => i32::MAX as f32,
            Self::U32 => u32::MAX as f32,
            Self::I64 => i64::MAX as f32,
            Self::U64 => u64::MAX as f32,
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// A property: one number, or a list of numbers preceded by its length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub name: String,
    /// The type of the length if this is a list.
    pub count: Option<Type>,
    pub item: Type,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// Returns the least number of bytes of one element.
    pub(super) fn least_size(&self, encoding: Encoding) -> u64 {
        let size = |property: &Property| match encoding {
            // A digit and a separator.
            Encoding::Ascii => 2,
            _ => property.count.unwrap_or(property.item).size() as u64,
        };
        self.properties.iter().map(size).sum()
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The images that comments name, as MeshLab writes them.
    pub textures: Vec<String>,
}

/// Longer lines do not occur in headers: the file is not a PLY file.
const LONGEST_LINE: usize = 4096;

/// Reads the header including the line `end_header`.
pub(super) fn read<R: BufRead>(input: &mut Input<R>) -> Result<Header, LoadProblem> {
    let mut line_number = 0;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut textures = Vec::new();
    loop {
        line_number += 1;
        let fail = |problem: String| Err(LoadProblem::PlyHeader { line: line_number, problem });
        let Some(bytes) = input.line(LONGEST_LINE)? else {
            if line_number == 1 {
                return Err(LoadProblem::NotPly);
            }
            return fail("not found: the header has no end, so this is not a PLY file".to_owned());
        };
        let line = String::from_utf8_lossy(&bytes);
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if line_number == 1 {
            if words != ["ply"] && words != ["\u{feff}ply"] {
                return Err(LoadProblem::NotPly);
            }
            continue;
        }
        match words[..] {
            ["comment", keyword, ..] if keyword.eq_ignore_ascii_case("TextureFile") => {
                // The name may have blanks.
                let (_, name) = line.split_once(keyword).unwrap_or_default();
                textures.push(name.trim().to_owned());
            }
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _version] => {
                encoding = match name {
                    "ascii" => Some(Encoding::Ascii),
                    "binary_little_endian" => Some(Encoding::LittleEndian),
                    "binary_big_endian" => Some(Encoding::BigEndian),
                    _ => return fail(format!("unknown format {name:?}")),
                };
            }
            ["element", name, count] => match count.parse() {
                Ok(count) => {
                    elements.push(Element { name: name.to_owned(), count, properties: vec![] });
                }
                Err(_) => return fail(format!("{count:?} is not a count of elements")),
            },
            ["property", ref rest @ ..] => {
                let Some(element) = elements.last_mut() else {
                    return fail("a property before the first element".to_owned());
                };
                match property(rest) {
                    Ok(property) => element.properties.push(property),
                    Err(problem) => return fail(problem),
                }
            }
            ["end_header"] => break,
            _ => return fail(format!("cannot understand {:?}", line.trim_end())),
        }
    }
    match encoding {
        Some(encoding) => Ok(Header { encoding, elements, textures }),
        None => Err(LoadProblem::PlyHeader {
            line: line_number,
            problem: "no line states the format".to_owned(),
        }),
    }
}

fn property(words: &[&str]) -> Result<Property, String> {
    let parse = |name: &str| Type::parse(name).ok_or_else(|| format!("unknown type {name:?}"));
    match *words {
        ["list", count, item, name] => {
            let count = parse(count)?;
            if !count.is_integer() {
                return Err(format!("the length of the list {name:?} is not an integer"));
            }
            Ok(Property { name: name.to_owned(), count: Some(count), item: parse(item)? })
        }
        [item, name] => Ok(Property { name: name.to_owned(), count: None, item: parse(item)? }),
        _ => Err(format!("cannot understand the property {:?}", words.join(" "))),
    }
}
