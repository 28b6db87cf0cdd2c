//! Decoding of the elements of a PLY file, row by row.

use super::{
    header::{Element, Encoding, Property, Type},
    input::Input,
};
use crate::load::error::LoadProblem;
use std::io::BufRead;

/// The rows of one kind of element, to be read.
pub(super) struct Rows<'a, R> {
    pub input: &'a mut Input<R>,
    pub element: &'a Element,
    pub encoding: Encoding,
    /// The number of vertices by the header.
    pub vertices: u64,
    word: String,
    bytes: Vec<u8>,
}

/// The properties of an element with a list of vertices that are read, by their indices.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wanted {
    pub vertices: usize,
    /// Two numbers for each corner.
    pub texcoords: Option<usize>,
    pub numbers: [Option<usize>; NUMBERS],
    /// Whether -1 ends a strip and is no vertex.
    pub with_ends_of_strips: bool,
}

/// The most numbers of a row beside its lists.
pub(super) const NUMBERS: usize = 5;

/// A row of an element with a list of vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct ListRow<'r> {
    pub vertices: &'r [u32],
    pub texcoords: &'r [f32],
    /// As in [`Wanted::numbers`]; zero for those that the element does not have.
    pub numbers: &'r [f64; NUMBERS],
}

/// The vertex that stands for -1 in a strip.
pub(super) const STRIP_END: u32 = u32::MAX;

/// Returns a vertex by its number in a file; `None` for fractions and numbers out of range.
pub(super) fn vertex_index(value: f64) -> Option<u32> {
    let fits = value.fract() == 0.0 && (0.0..f64::from(STRIP_END)).contains(&value);
    fits.then_some(value as u32)
}

/// The number of rows in a block, which fits into the cache.
pub(super) const ROWS: usize = 1 << 12;

/// Calls a macro with the Rust type of a number.
macro_rules! for_type {
    ($item:expr, $call:ident) => {
        match $item {
            Type::I8 => $call!(i8),
            Type::U8 => $call!(u8),
            Type::I16 => $call!(i16),
            Type::U16 => $call!(u16),
            Type::I32 => $call!(i32),
            Type::U32 => $call!(u32),
            Type::I64 => $call!(i64),
            Type::U64 => $call!(u64),
            Type::F32 => $call!(f32),
            Type::F64 => $call!(f64),
        }
    };
}

impl<'a, R: BufRead> Rows<'a, R> {
    pub(super) fn new(
        input: &'a mut Input<R>,
        element: &'a Element,
        encoding: Encoding,
        vertices: u64,
    ) -> Self {
        Self { input, element, encoding, vertices, word: String::new(), bytes: Vec::new() }
    }

    /// Skips all rows.
    pub(super) fn skip(&mut self) -> Result<(), LoadProblem> {
        match self.row_size() {
            Some(_) => self.blocks().try_for_each(|block| block.map(drop)),
            None => self.for_each_row::<0>(&vec![None; self.element.properties.len()], |_| {}),
        }
    }

    /// Returns the size of a row in bytes; `None` if rows differ.
    pub(super) fn row_size(&self) -> Option<usize> {
        let properties = &self.element.properties;
        let fixed = properties.iter().all(|property| property.count.is_none());
        (fixed && self.encoding != Encoding::Ascii)
            .then(|| properties.iter().map(|property| property.item.size()).sum())
    }

    /// Reads all rows in blocks of [`ROWS`]; yields nothing unless rows have the same size.
    pub(super) fn blocks(&mut self) -> impl Iterator<Item = Result<Vec<u8>, LoadProblem>> {
        let size = self.row_size().unwrap_or(0);
        let count = if size == 0 { 0 } else { self.element.count };
        (0..count).step_by(ROWS).map(move |first| {
            let rows = (count - first).min(ROWS as u64);
            let mut block = vec![0; size * rows as usize];
            if self.input.bytes(&mut block)? { Ok(block) } else { Err(self.truncated(first)) }
        })
    }

    /// Calls `each` with the numbers of each row. `columns` has the index of each property in the
    /// row; lists are skipped.
    pub(super) fn for_each_row<const N: usize>(
        &mut self,
        columns: &[Option<usize>],
        mut each: impl FnMut(&[f64; N]),
    ) -> Result<(), LoadProblem> {
        let element = self.element;
        if element.properties.is_empty() {
            // The count of rows without properties may be arbitrarily large.
            return Ok(());
        }
        let mut row = [0.0; N];
        for index in 0..element.count {
            for (property, column) in element.properties.iter().zip(columns) {
                if property.count.is_some() {
                    self.list(property, index, |_| Ok(()))?;
                } else {
                    let value = self.number(property, property.item, index)?;
                    if let Some(column) = *column {
                        row[column] = value;
                    }
                }
            }
            each(&row);
        }
        Ok(())
    }

    /// Calls `each` with the wanted properties of each row.
    pub(super) fn for_each_list(
        &mut self,
        wanted: &Wanted,
        mut each: impl FnMut(ListRow<'_>),
    ) -> Result<(), LoadProblem> {
        let element = self.element;
        let vertices = self.vertices;
        // Vertices that are looked up at once must exist; others are checked in the end.
        let limit = if wanted.texcoords.is_some() { vertices as f64 } else { f64::INFINITY };
        let vertex = |index: u64, value: f64| match vertex_index(value) {
            Some(vertex) if value < limit => Ok(vertex),
            None if wanted.with_ends_of_strips && value == -1.0 => Ok(STRIP_END),
            _ => Err(LoadProblem::VertexOutOfRange {
                element: element.name.clone(),
                index,
                vertex: value as i64,
                count: vertices as usize,
            }),
        };
        let mut list = Vec::new();
        let mut texcoords = Vec::new();
        let mut numbers = [0.0; NUMBERS];
        let mut index = 0;
        while index < element.count {
            // Lists that are buffered as a whole need no check of each number.
            if let ([property], false) = (&element.properties[..], self.encoding == Encoding::Ascii)
            {
                let mut at_hand = self.input.at_hand()?;
                let before = at_hand.len();
                while index < element.count
                    && let Some((items, rest)) = whole_list(property, self.encoding, at_hand)
                {
                    list.clear();
                    for item in items.chunks_exact(property.item.size()) {
                        list.push(vertex(index, decode(property.item, self.encoding, item))?);
                    }
                    each(ListRow { vertices: &list, texcoords: &[], numbers: &numbers });
                    at_hand = rest;
                    index += 1;
                }
                let used = before - at_hand.len();
                self.input.consume(used);
                if used > 0 {
                    continue;
                }
            }
            for (i, property) in element.properties.iter().enumerate() {
                if i == wanted.vertices {
                    list.clear();
                    self.list(property, index, |value| {
                        list.push(vertex(index, value)?);
                        Ok(())
                    })?;
                } else if wanted.texcoords == Some(i) {
                    texcoords.clear();
                    self.list(property, index, |value| {
                        texcoords.push(value as f32);
                        Ok(())
                    })?;
                } else if property.count.is_some() {
                    self.list(property, index, |_| Ok(()))?;
                } else {
                    let value = self.number(property, property.item, index)?;
                    if let Some(at) = wanted.numbers.iter().position(|number| *number == Some(i)) {
                        numbers[at] = value;
                    }
                }
            }
            each(ListRow { vertices: &list, texcoords: &texcoords, numbers: &numbers });
            index += 1;
        }
        Ok(())
    }

    /// Calls `each` with the items of a list.
    fn list(
        &mut self,
        property: &Property,
        index: u64,
        mut each: impl FnMut(f64) -> Result<(), LoadProblem>,
    ) -> Result<(), LoadProblem> {
        let count = self.number(property, property.count.unwrap_or(Type::U8), index)?;
        if !(count >= 0.0 && count.fract() == 0.0) {
            return Err(LoadProblem::ElementValue {
                element: self.element.name.clone(),
                index,
                property: property.name.clone(),
                value: format!("a list of {count} items"),
                expected: "a count",
            });
        }
        let count = count as u64;
        if self.encoding == Encoding::Ascii {
            for _ in 0..count {
                each(self.number(property, property.item, index)?)?;
            }
            return Ok(());
        }
        let size = property.item.size();
        if count > self.input.remaining / size as u64 {
            return Err(self.truncated(index));
        }
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.resize(size * count as usize, 0);
        if !self.input.bytes(&mut bytes)? {
            return Err(self.truncated(index));
        }
        for item in bytes.chunks_exact(size) {
            each(decode(property.item, self.encoding, item))?;
        }
        self.bytes = bytes;
        Ok(())
    }

    fn number(&mut self, property: &Property, item: Type, index: u64) -> Result<f64, LoadProblem> {
        if self.encoding != Encoding::Ascii {
            let mut bytes = [0; 8];
            let bytes = &mut bytes[..item.size()];
            if !self.input.bytes(bytes)? {
                return Err(self.truncated(index));
            }
            return Ok(decode(item, self.encoding, bytes));
        }
        if !self.input.word(&mut self.word)? {
            return Err(self.truncated(index));
        }
        if let Ok(value) = self.word.parse() {
            return Ok(value);
        }
        // As Microsoft's library prints what is not a number.
        if ["#ind", "#inf", "#qnan", "#snan", "nan("]
            .iter()
            .any(|mark| self.word.to_ascii_lowercase().contains(mark))
        {
            return Ok(f64::NAN);
        }
        Err(LoadProblem::ElementValue {
            element: self.element.name.clone(),
            index,
            property: property.name.clone(),
            value: format!("{:?}", self.word),
            expected: "a number",
        })
    }

    fn truncated(&self, index: u64) -> LoadProblem {
        LoadProblem::Truncated {
            element: self.element.name.clone(),
            index,
            count: self.element.count,
        }
    }
}

/// Splits the list that `bytes` begin with from the rest; `None` if it is incomplete or its length
/// is invalid.
fn whole_list<'a>(
    property: &Property,
    encoding: Encoding,
    bytes: &'a [u8],
) -> Option<(&'a [u8], &'a [u8])> {
    let (count, items) = bytes.split_at_checked(property.count?.size())?;
    let count = decode(property.count?, encoding, count);
    // The cast saturates: a length that is too large exceeds the bytes.
    let size = (count >= 0.0).then(|| (count as usize).checked_mul(property.item.size()))??;
    items.split_at_checked(size)
}

/// Appends to `column` the numbers of type `item` at `offset` bytes in each row of a block.
#[expect(clippy::cast_lossless, reason = "of all types, most lose nothing")]
pub(super) fn decode_column(
    encoding: Encoding,
    block: &[u8],
    (size, offset, item): (usize, usize, Type),
    column: &mut Vec<f32>,
) {
    // One loop for each type, so that the loop has no branch on it.
    macro_rules! each {
        ($type:ty) => {
            match encoding {
                Encoding::BigEndian => column.extend(
                    block
                        .chunks_exact(size)
                        .map(|row| <$type>::from_be_bytes(array(&row[offset..])) as f32),
                ),
                _ => column.extend(
                    block
                        .chunks_exact(size)
                        .map(|row| <$type>::from_le_bytes(array(&row[offset..])) as f32),
                ),
            }
        };
    }
    for_type!(item, each);
}

/// Appends to `column` what the numbers lose if they become single, as [`decode_column`] does.
#[expect(clippy::cast_lossless, reason = "of all types, most lose nothing")]
pub(super) fn decode_rests(
    encoding: Encoding,
    block: &[u8],
    (size, offset, item): (usize, usize, Type),
    column: &mut Vec<f32>,
) {
    macro_rules! each {
        ($type:ty) => {
            column.extend(block.chunks_exact(size).map(|row| {
                let value = match encoding {
                    Encoding::BigEndian => <$type>::from_be_bytes(array(&row[offset..])),
                    _ => <$type>::from_le_bytes(array(&row[offset..])),
                };
                (value as f64 - (value as f32) as f64) as f32
            }))
        };
    }
    for_type!(item, each);
}

/// Decodes a number. 64-bit integers are exact up to 2^53, more than any count or index of a file.
#[expect(clippy::cast_lossless, reason = "of all types, most lose nothing")]
fn decode(item: Type, encoding: Encoding, bytes: &[u8]) -> f64 {
    macro_rules! decode {
        ($type:ty) => {
            (match encoding {
                Encoding::BigEndian => <$type>::from_be_bytes(array(bytes)),
                _ => <$type>::from_le_bytes(array(bytes)),
            }) as f64
        };
    }
    for_type!(item, decode)
}

/// Returns the first `N` bytes; zeros if the slice is shorter, which callers exclude.
pub(super) fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}
