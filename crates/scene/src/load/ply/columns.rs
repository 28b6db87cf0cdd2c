//! The properties of vertices by their meaning, and decoding of blocks of rows.

use super::{
    header::{Element, Encoding, Type},
    names::plain,
    rows::{array, decode_column, decode_rests},
};
use crate::load::far::FAR;
use rotund_image::{linear_from_srgb, linear_from_srgb_table};

/// The columns of vertex data, each with all names in use. Sizes across count half.
const NAMES: [&[&str]; COUNT] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["u", "s", "texture_u"],
    &["v", "t", "texture_v"],
    &["red", "r", "diffuse_red", "cd_r", "f_dc_0"],
    &["green", "g", "diffuse_green", "cd_g", "f_dc_1"],
    &["blue", "b", "diffuse_blue", "cd_b", "f_dc_2"],
    &["alpha", "a", "diffuse_alpha"],
    &["radius", "pscale", "width", "size", "diameter"],
    &["scale_0"],
    &["scale_1"],
    &["scale_2"],
];
pub(super) const COUNT: usize = 16;
pub(super) const POSITION: usize = 0;
pub(super) const NORMAL: usize = 3;
pub(super) const TEXCOORD: usize = 6;
pub(super) const COLOR: usize = 8;
pub(super) const ALPHA: usize = 11;
pub(super) const RADIUS: usize = 12;
/// The logarithms of the half axes of a Gaussian splat.
pub(super) const SCALE: usize = 13;
/// What positions lose if they become single.
pub(super) const REST: usize = COUNT;

/// A block of rows by column; columns that the file does not have are empty.
pub(super) type Columns = [Vec<f32>; COUNT + 3];

/// The columns of the file and their order.
pub(super) struct Layout {
    encoding: Encoding,
    /// The type of each property, and its column.
    items: Vec<Type>,
    pub columns: Vec<Option<usize>>,
    /// The type of each column.
    pub types: [Option<Type>; COUNT],
    /// Offset in a row of x, y and z, if they are adjacent and have the layout of the array, so
    /// that they are copied without columns.
    pub positions_at: Option<usize>,
    /// True if positions have more digits than single precision.
    pub is_fine: bool,
    /// The type of a property that packs the channels of a colour into the bits of one number,
    /// alpha first, as PCL writes it; green and blue have no property then.
    packed: Option<Type>,
    /// Whether a brightness stands for all channels.
    pub is_grey: bool,
    /// Whether the colours are the constant terms of spherical harmonics.
    is_splat: bool,
    /// The radius for a size of 1.
    radius_of_size: f32,
}

impl Layout {
    pub(super) fn new(element: &Element, encoding: Encoding) -> Self {
        let mut types = [None; COUNT];
        let mut columns = Vec::new();
        let (mut is_splat, mut radius_of_size) = (false, 1.0);
        for property in &element.properties {
            let name = plain(&property.name);
            let named = NAMES.iter().position(|names| names.contains(&name.as_str()));
            // Of properties with the same meaning, the first counts.
            let column = named.filter(|&i| property.count.is_none() && types[i].is_none());
            if let Some(i) = column {
                types[i] = Some(property.item);
                is_splat |= name.starts_with("f_dc_");
                if ["width", "size", "diameter"].contains(&name.as_str()) {
                    radius_of_size = 0.5;
                }
            }
            columns.push(column);
        }
        let items: Vec<Type> = element.properties.iter().map(|property| property.item).collect();
        let together = |first: usize| {
            let place = first..first + 3;
            columns.get(place.clone()) == Some(&[0, 1, 2].map(|axis| Some(POSITION + axis)))
                && items[place].iter().all(|item| *item == Type::F32)
        };
        let first = (0..columns.len()).find(|&first| together(first));
        let positions_at = first
            .filter(|_| encoding == Encoding::LittleEndian)
            .map(|first| items[..first].iter().map(|item| item.size()).sum());
        let is_fine = encoding == Encoding::Ascii
            || types[..NORMAL].iter().flatten().any(|item| item.is_finer_than_single());
        let mut layout = Self {
            encoding,
            items,
            columns,
            types,
            positions_at,
            is_fine,
            packed: None,
            is_grey: false,
            is_splat,
            radius_of_size,
        };
        layout.drop_incomplete();
        layout.take_single_color(element);
        layout
    }

    /// Drops columns that say nothing without others, so that they count as not used.
    fn drop_incomplete(&mut self) {
        let mut unused = Vec::new();
        for (first, count) in [(NORMAL, 3), (TEXCOORD, 2), (COLOR, 3)] {
            if !self.has(first, count) {
                unused.extend(first..first + count);
            }
        }
        if unused.contains(&COLOR) {
            unused.push(ALPHA);
        }
        if self.types[RADIUS].is_some() {
            unused.extend(SCALE..SCALE + 3);
        }
        for column in unused {
            self.types[column] = None;
            for of_property in self.columns.iter_mut().filter(|c| **c == Some(column)) {
                *of_property = None;
            }
        }
    }

    /// Takes the colours from a single property if there are no channels.
    fn take_single_color(&mut self, element: &Element) {
        const GREYS: [&str; 6] =
            ["intensity", "reflectance", "reflectivity", "amplitude", "grey", "gray"];
        if self.has(COLOR, 3) {
            return;
        }
        let find = |fits: &dyn Fn(&str, Type) -> bool| {
            element.properties.iter().position(|property| {
                property.count.is_none() && fits(&plain(&property.name), property.item)
            })
        };
        let has_bits = |item| matches!(item, Type::F32 | Type::U32 | Type::I32);
        let packed = find(&|name, item| ["rgb", "rgba"].contains(&name) && has_bits(item));
        let grey = || find(&|name, _| GREYS.contains(&name));
        let Some(i) = packed.or_else(grey) else { return };
        self.columns[i] = Some(COLOR);
        if packed.is_some() {
            self.packed = Some(self.items[i]);
            self.types[COLOR..ALPHA].fill(Some(Type::U8));
            if plain(&element.properties[i].name) == "rgba" {
                self.types[ALPHA] = Some(Type::U8);
            }
        } else {
            self.is_grey = true;
            self.types[COLOR..ALPHA].fill(Some(Type::F32));
        }
    }

    /// Adds the channels of a colour that is packed into the bits of a number.
    fn push_packed(&self, bits: u32, columns: &mut Columns) {
        let [a, r, g, b] = bits.to_be_bytes();
        for (column, channel) in columns[COLOR..].iter_mut().zip([r, g, b]) {
            column.push(channel.into());
        }
        if self.types[ALPHA].is_some() {
            columns[ALPHA].push(a.into());
        }
    }

    pub(super) fn has(&self, first: usize, count: usize) -> bool {
        self.types[first..first + count].iter().all(Option::is_some)
    }

    /// Returns whether there are radii, or scales to compute them from.
    pub(super) fn has_radii(&self) -> bool {
        self.types[RADIUS..].iter().any(Option::is_some)
    }

    /// Returns whether colours are in floating point and linear, unless they are from 0 to 255.
    pub(super) fn has_float_colors(&self) -> bool {
        let is_float = |item: Option<Type>| item.is_some_and(|item| !item.is_integer());
        !self.is_splat
            && !self.is_grey
            && self.types[COLOR..ALPHA].iter().all(|item| is_float(*item))
    }

    /// Decodes the rows of a block, of `size` bytes each.
    pub(super) fn decode(&self, block: &[u8], size: usize, columns: &mut Columns) {
        let mut offset = 0;
        columns[REST..].iter_mut().for_each(Vec::clear);
        for (&item, &column) in self.items.iter().zip(&self.columns) {
            if column == Some(COLOR) && self.packed.is_some() {
                columns[COLOR..=ALPHA].iter_mut().for_each(Vec::clear);
                for row in block.chunks_exact(size) {
                    let bytes = array(&row[offset..]);
                    let bits = match self.encoding {
                        Encoding::BigEndian => u32::from_be_bytes(bytes),
                        _ => u32::from_le_bytes(bytes),
                    };
                    self.push_packed(bits, columns);
                }
                offset += item.size();
                continue;
            }
            let copied = |column| self.positions_at.is_some() && column < POSITION + 3;
            if let Some(column) = column.filter(|&column| !copied(column)) {
                columns[column].clear();
                let place = (size, offset, item);
                decode_column(self.encoding, block, place, &mut columns[column]);
                if column < POSITION + 3
                    && item.is_finer_than_single()
                    && columns[column].iter().any(|x| f64::from(x.abs()) >= FAR)
                {
                    decode_rests(self.encoding, block, place, &mut columns[REST + column]);
                }
            }
            offset += item.size();
        }
        self.interpret(columns);
    }

    /// Adds a row of text to the columns.
    pub(super) fn push(&self, row: &[f64; COUNT], columns: &mut Columns) {
        if let Some(item) = self.packed {
            let value = row[COLOR];
            // The cast of a negative integer wraps around, as its bits do.
            let as_integer = value as i64 as u32;
            let bits = if item == Type::F32 { (value as f32).to_bits() } else { as_integer };
            self.push_packed(bits, columns);
        }
        for (i, &value) in row.iter().enumerate() {
            let is_pushed = self.packed.is_some() && (COLOR..=ALPHA).contains(&i);
            if self.types[i].is_none() || is_pushed {
                continue;
            }
            columns[i].push(value as f32);
            if i < POSITION + 3 {
                columns[REST + i].push((value - f64::from(value as f32)) as f32);
            }
        }
    }

    /// Converts colours to linear ones and sizes to radii.
    pub(super) fn interpret(&self, columns: &mut Columns) {
        if self.is_grey {
            let (grey, others) = columns[COLOR..ALPHA].split_at_mut(1);
            others.iter_mut().for_each(|column| column.clone_from(&grey[0]));
        }
        for (i, column) in columns.iter_mut().enumerate().take(ALPHA + 1).skip(COLOR) {
            if self.is_splat && i != ALPHA {
                // The constant basis function of the spherical harmonics is 1 / (2 sqrt(pi)).
                let srgb = |f: f32| (0.5 + 0.282_094_8 * f).clamp(0.0, 1.0);
                column.iter_mut().for_each(|value| *value = linear_from_srgb(srgb(*value)));
                continue;
            }
            let Some(integer) = self.types[i].filter(|item| item.is_integer()) else { continue };
            match integer {
                _ if i == ALPHA => column.iter_mut().for_each(|value| *value /= integer.one()),
                Type::U8 => {
                    let linear = linear_from_srgb_table();
                    column.iter_mut().for_each(|value| *value = linear[*value as usize % 256]);
                }
                _ => column
                    .iter_mut()
                    .for_each(|value| *value = linear_from_srgb(*value / integer.one())),
            }
        }
        if self.types[RADIUS].is_some() {
            if self.radius_of_size != 1.0 {
                columns[RADIUS].iter_mut().for_each(|size| *size *= self.radius_of_size);
            }
        } else if self.has_radii() {
            // The ball that has the volume of the ellipsoid.
            let (before, scales) = columns.split_at_mut(SCALE);
            let count = scales[..3].iter().map(Vec::len).max().unwrap_or(0);
            let axes = scales[..3].iter().filter(|scale| !scale.is_empty()).count() as f32;
            let sum = |i: usize| scales[..3].iter().filter_map(|s| s.get(i)).sum::<f32>();
            before[RADIUS].clear();
            before[RADIUS].extend((0..count).map(|i| (sum(i) / axes).exp()));
        }
    }
}
