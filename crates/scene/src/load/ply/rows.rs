//! The elements of a PLY file, row by row.

use super::{
    header::{Element, Encoding, Property, Type},
    input::Input,
};
use crate::LoadError;
use std::io::BufRead;

/// The rows of one element, not yet read.
pub(super) struct Rows<'a, R> {
    pub input: &'a mut Input<R>,
    pub element: &'a Element,
    encoding: Encoding,
    /// How many vertices the file claims to have: for messages.
    vertices: u64,
    word: String,
    bytes: Vec<u8>,
}

/// Bytes decoded at a time: small enough for a cache.
const BLOCK: usize = 1 << 15;

impl<'a, R: BufRead> Rows<'a, R> {
    pub(super) fn new(
        input: &'a mut Input<R>,
        element: &'a Element,
        encoding: Encoding,
        vertices: u64,
    ) -> Self {
        Self { input, element, encoding, vertices, word: String::new(), bytes: Vec::new() }
    }

    /// Passes over all rows.
    pub(super) fn skip(&mut self) -> Result<(), LoadError> {
        self.for_each_row::<0>(&vec![None; self.element.properties.len()], |_| {})
    }

    /// Calls `each` with the numbers of a row: `columns` says for each property where it goes.
    /// Lists go nowhere.
    pub(super) fn for_each_row<const N: usize>(
        &mut self,
        columns: &[Option<usize>],
        mut each: impl FnMut(&[f32; N]),
    ) -> Result<(), LoadError> {
        let element = self.element;
        let properties = &element.properties;
        if properties.is_empty() {
            // Rows of nothing, in whatever number.
            return Ok(());
        }
        let mut row = [0.0; N];
        let fixed = properties.iter().all(|property| property.count.is_none());
        if self.encoding == Encoding::Ascii || !fixed {
            for index in 0..element.count {
                for (property, column) in properties.iter().zip(columns) {
                    if property.count.is_some() {
                        self.list(property, index, |_| Ok(()))?;
                    } else {
                        let value = self.number(property, property.item, index)?;
                        if let Some(column) = *column {
                            row[column] = value as f32;
                        }
                    }
                }
                each(&row);
            }
            return Ok(());
        }
        let size: usize = properties.iter().map(|property| property.item.size()).sum();
        let mut offset = 0;
        let mut fields = Vec::new();
        for (property, column) in properties.iter().zip(columns) {
            fields.extend(column.map(|column| (offset, property.item, column)));
            offset += property.item.size();
        }
        let rows_in_block = (BLOCK / size).max(1) as u64;
        let mut block = vec![0; size * rows_in_block.min(element.count) as usize];
        let mut done = 0;
        while done < element.count {
            let rows = rows_in_block.min(element.count - done);
            let bytes = &mut block[..size * rows as usize];
            if !self.input.bytes(bytes)? {
                return Err(self.truncated(done));
            }
            for bytes in bytes.chunks_exact(size) {
                for &(offset, item, column) in &fields {
                    row[column] = match (item, self.encoding) {
                        // The common case, without the detour over f64.
                        (Type::F32, Encoding::LittleEndian) => {
                            f32::from_le_bytes(array(&bytes[offset..]))
                        }
                        (item, encoding) => decode(item, encoding, &bytes[offset..]) as f32,
                    };
                }
                each(&row);
            }
            done += rows;
        }
        Ok(())
    }

    /// Calls `each` with the list of vertices of a row, the first property with one of `names`.
    pub(super) fn for_each_list(
        &mut self,
        names: &[&str],
        mut each: impl FnMut(&[u32]),
    ) -> Result<(), LoadError> {
        let element = self.element;
        let found = element.properties.iter().position(|property| {
            property.count.is_some() && names.contains(&property.name.as_str())
        });
        let Some(found) = found else { return self.skip() };
        let mut list = Vec::new();
        let vertices = self.vertices;
        let path = self.input.path.clone();
        for index in 0..element.count {
            for (i, property) in element.properties.iter().enumerate() {
                if i == found {
                    list.clear();
                    self.list(property, index, |value| {
                        // A fraction is no index; the cast saturates, so nothing wraps round.
                        if value.fract() == 0.0 && (0.0..4_294_967_295.0).contains(&value) {
                            list.push(value as u32);
                            return Ok(());
                        }
                        Err(LoadError::VertexOutOfRange {
                            path: path.clone(),
                            element: element.name.clone(),
                            index,
                            vertex: value as i64,
                            count: vertices as usize,
                        })
                    })?;
                    each(&list);
                } else if property.count.is_some() {
                    self.list(property, index, |_| Ok(()))?;
                } else {
                    self.number(property, property.item, index)?;
                }
            }
        }
        Ok(())
    }

    /// Calls `each` with the items of a list.
    fn list(
        &mut self,
        property: &Property,
        index: u64,
        mut each: impl FnMut(f64) -> Result<(), LoadError>,
    ) -> Result<(), LoadError> {
        let count = self.number(property, property.count.unwrap_or(Type::U8), index)?;
        if !(count >= 0.0 && count.fract() == 0.0) {
            return Err(LoadError::ElementValue {
                path: self.input.path.clone(),
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

    fn number(&mut self, property: &Property, item: Type, index: u64) -> Result<f64, LoadError> {
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
        self.word.parse().map_err(|_| LoadError::ElementValue {
            path: self.input.path.clone(),
            element: self.element.name.clone(),
            index,
            property: property.name.clone(),
            value: format!("{:?}", self.word),
            expected: "a number",
        })
    }

    fn truncated(&self, index: u64) -> LoadError {
        LoadError::Truncated {
            path: self.input.path.clone(),
            element: self.element.name.clone(),
            index,
            count: self.element.count,
        }
    }
}

/// Every type fits into an `f64` without loss.
fn decode(item: Type, encoding: Encoding, bytes: &[u8]) -> f64 {
    macro_rules! decode {
        ($type:ty) => {
            f64::from(match encoding {
                Encoding::BigEndian => <$type>::from_be_bytes(array(bytes)),
                _ => <$type>::from_le_bytes(array(bytes)),
            })
        };
    }
    match item {
        Type::I8 => decode!(i8),
        Type::U8 => decode!(u8),
        Type::I16 => decode!(i16),
        Type::U16 => decode!(u16),
        Type::I32 => decode!(i32),
        Type::U32 => decode!(u32),
        Type::F32 => decode!(f32),
        Type::F64 => decode!(f64),
    }
}

/// The first bytes; zeros where the slice is shorter, which callers rule out.
fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}
