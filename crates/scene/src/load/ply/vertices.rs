//! Decoding of the vertices of a PLY file into the arrays of a mesh.

use super::{
    header::{Encoding, Type},
    rows::{ROWS, Rows, array, decode_column},
};
use crate::{
    load::{error::LoadProblem, mesh::Mesh},
    validate::{is_color, is_radius},
};
use bytemuck::zeroed_vec;
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;
use rotund_image::{linear_from_srgb, linear_from_srgb_table};
use std::{
    io::BufRead,
    slice::ChunksMut,
    sync::atomic::{AtomicBool, Ordering},
};

/// The columns of vertex data, each with all names in use.
const COLUMNS: [&[&str]; 13] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u"],
    &["v", "t", "texture_v"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a"],
    &["radius"],
];
const POSITION: usize = 0;
const NORMAL: usize = 3;
const TEXCOORD: usize = 6;
const COLOR: usize = 8;
const ALPHA: usize = 11;
const RADIUS: usize = 12;

/// Reads positions and the other columns that are present; skips other properties.
///
/// Colours in integers are sRGB as in images, and the largest integer represents 1; colours in
/// floating point are linear.
///
/// Rows of fixed size are read block by block and decoded on all threads directly into the arrays.
pub(super) fn read<R: BufRead + Send>(
    rows: &mut Rows<'_, R>,
    mesh: &mut Mesh,
) -> Result<(), LoadProblem> {
    let layout = Layout::new(rows);
    if !layout.has(POSITION, 3) {
        return Err(LoadProblem::PlyHeader {
            line: 1,
            problem: "the vertices have no properties x, y and z".to_owned(),
        });
    }
    layout.make_room(mesh, rows.element.count as usize);
    let chunks = Chunks::new(mesh);
    if let Some(size) = rows.row_size() {
        let odd = AtomicBool::new(false);
        rows.blocks().zip(chunks).par_bridge().try_for_each_init(
            Columns::default,
            |columns, (block, mut chunk)| {
                let block = block?;
                layout.decode(&block, size, columns);
                chunk.fill(columns);
                if let Some(offset) = layout.positions_at {
                    chunk.copy_positions(&block, size, offset);
                }
                // Check while the block is in the cache: a second pass would take as long as
                // reading the file.
                if !chunk.is_sound() {
                    odd.store(true, Ordering::Relaxed);
                }
                Ok(())
            },
        )?;
        mesh.sound = !odd.into_inner();
        return Ok(());
    }
    let mut chunks = chunks;
    let mut columns = Columns::default();
    let mut store = |columns: &mut Columns| {
        layout.make_linear(columns);
        if let Some(mut chunk) = chunks.next() {
            chunk.fill(columns);
        }
        columns.iter_mut().for_each(Vec::clear);
    };
    rows.for_each_row::<{ COLUMNS.len() }>(&layout.columns, |row| {
        for ((column, &value), item) in columns.iter_mut().zip(row).zip(layout.types) {
            column.extend(item.map(|_| value));
        }
        if columns[POSITION].len() == ROWS {
            store(&mut columns);
        }
    })?;
    store(&mut columns);
    Ok(())
}

/// A block of rows by column, as in [`COLUMNS`]; columns that the file does not have are empty.
type Columns = [Vec<f32>; COLUMNS.len()];

/// The columns of the file and their order.
struct Layout {
    encoding: Encoding,
    /// The type of each property, and its column.
    items: Vec<Type>,
    columns: Vec<Option<usize>>,
    /// The type of each column.
    types: [Option<Type>; COLUMNS.len()],
    /// Offset in a row of x, y and z, if they are adjacent and have the layout of the array, so
    /// that they are copied without columns.
    positions_at: Option<usize>,
}

impl Layout {
    fn new<R>(rows: &Rows<'_, R>) -> Self {
        let mut types = [None; COLUMNS.len()];
        let mut columns = Vec::new();
        for property in &rows.element.properties {
            let named = COLUMNS.iter().position(|names| names.contains(&property.name.as_str()));
            // Of properties with the same meaning, the first counts.
            let column = named.filter(|&i| property.count.is_none() && types[i].is_none());
            if let Some(i) = column {
                types[i] = Some(property.item);
            }
            columns.push(column);
        }
        let items: Vec<Type> =
            rows.element.properties.iter().map(|property| property.item).collect();
        let together = |first: usize| {
            let place = first..first + 3;
            columns.get(place.clone()) == Some(&[0, 1, 2].map(|axis| Some(POSITION + axis)))
                && items[place].iter().all(|item| *item == Type::F32)
        };
        let first = (0..columns.len()).find(|&first| together(first));
        let positions_at = first
            .filter(|_| rows.encoding == Encoding::LittleEndian)
            .map(|first| items[..first].iter().map(|item| item.size()).sum());
        Self { encoding: rows.encoding, items, columns, types, positions_at }
    }

    fn has(&self, first: usize, count: usize) -> bool {
        self.types[first..first + count].iter().all(Option::is_some)
    }

    /// Allocates the arrays as untouched zero pages, which the system maps at the first write, by
    /// the thread that decodes there. The length of the file has been checked for this count.
    fn make_room(&self, mesh: &mut Mesh, count: usize) {
        let room = |first, columns| if self.has(first, columns) { count } else { 0 };
        mesh.positions = zeroed_vec(count);
        mesh.normals = zeroed_vec(room(NORMAL, 3));
        mesh.texcoords = zeroed_vec(room(TEXCOORD, 2));
        mesh.colors = zeroed_vec(room(COLOR, 3));
        mesh.radii = zeroed_vec(room(RADIUS, 1));
    }

    /// Decodes the rows of a block, of `size` bytes each.
    fn decode(&self, block: &[u8], size: usize, columns: &mut Columns) {
        let mut offset = 0;
        for (&item, &column) in self.items.iter().zip(&self.columns) {
            let copied = |column| self.positions_at.is_some() && column < POSITION + 3;
            if let Some(column) = column.filter(|&column| !copied(column)) {
                columns[column].clear();
                decode_column(self.encoding, block, (size, offset, item), &mut columns[column]);
            }
            offset += item.size();
        }
        self.make_linear(columns);
    }

    /// Scales integer colours to `0.0..=1.0` and decodes sRGB.
    fn make_linear(&self, columns: &mut Columns) {
        for (i, column) in columns.iter_mut().enumerate().take(ALPHA + 1).skip(COLOR) {
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
    }
}

/// The arrays of a mesh in chunks of [`ROWS`] vertices.
struct Chunks<'a> {
    positions: ChunksMut<'a, Vec3>,
    normals: ChunksMut<'a, Vec3>,
    texcoords: ChunksMut<'a, Vec2>,
    colors: ChunksMut<'a, Vec4>,
    radii: ChunksMut<'a, f32>,
}

impl<'a> Chunks<'a> {
    fn new(mesh: &'a mut Mesh) -> Self {
        Self {
            positions: mesh.positions.chunks_mut(ROWS),
            normals: mesh.normals.chunks_mut(ROWS),
            texcoords: mesh.texcoords.chunks_mut(ROWS),
            colors: mesh.colors.chunks_mut(ROWS),
            radii: mesh.radii.chunks_mut(ROWS),
        }
    }
}

/// A chunk of vertices; arrays that the file does not have are empty.
struct Chunk<'a> {
    positions: &'a mut [Vec3],
    normals: &'a mut [Vec3],
    texcoords: &'a mut [Vec2],
    colors: &'a mut [Vec4],
    radii: &'a mut [f32],
}

impl<'a> Iterator for Chunks<'a> {
    type Item = Chunk<'a>;

    fn next(&mut self) -> Option<Chunk<'a>> {
        Some(Chunk {
            positions: self.positions.next()?,
            normals: self.normals.next().unwrap_or_default(),
            texcoords: self.texcoords.next().unwrap_or_default(),
            colors: self.colors.next().unwrap_or_default(),
            radii: self.radii.next().unwrap_or_default(),
        })
    }
}

impl Chunk<'_> {
    /// Copies positions from rows of `size` bytes, at `offset` in each.
    fn copy_positions(&mut self, block: &[u8], size: usize, offset: usize) {
        for (to, row) in self.positions.iter_mut().zip(block.chunks_exact(size)) {
            *to = Vec3::from_array(
                [0, 4, 8].map(|at| f32::from_le_bytes(array(&row[offset + at..]))),
            );
        }
    }

    /// Returns true if all values are valid.
    fn is_sound(&self) -> bool {
        // Without early exit, so that the loops vectorize.
        let all = |sound: bool, next: bool| sound & next;
        self.positions.iter().map(|p| p.is_finite()).fold(true, all)
            & self.radii.iter().map(is_radius).fold(true, all)
            & self.normals.iter().map(|n| n.is_finite()).fold(true, all)
            & self.texcoords.iter().map(|t| t.is_finite()).fold(true, all)
            & self.colors.iter().map(is_color).fold(true, all)
    }

    fn fill(&mut self, columns: &Columns) {
        let [x, y, z, nx, ny, nz, u, v, red, green, blue, alpha, radius] = columns;
        let vectors = |to: &mut [Vec3], [x, y, z]: [&[f32]; 3]| {
            for (((to, &x), &y), &z) in to.iter_mut().zip(x).zip(y).zip(z) {
                *to = Vec3::new(x, y, z);
            }
        };
        vectors(self.positions, [x, y, z]);
        vectors(self.normals, [nx, ny, nz]);
        for ((to, &u), &v) in self.texcoords.iter_mut().zip(u).zip(v) {
            *to = Vec2::new(u, 1.0 - v);
        }
        for (i, to) in self.colors.iter_mut().enumerate() {
            let alpha = alpha.get(i).copied().unwrap_or(1.0);
            *to = Vec4::new(red[i], green[i], blue[i], alpha);
        }
        for (to, &radius) in self.radii.iter_mut().zip(radius) {
            *to = radius;
        }
    }
}
