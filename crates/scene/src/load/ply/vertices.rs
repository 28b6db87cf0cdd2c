//! Decoding of the vertices of a PLY file into the arrays of a mesh.

use super::{
    columns::{COLOR, COUNT, Columns, Layout, NORMAL, POSITION, TEXCOORD},
    names,
    rows::{ROWS, Rows, array},
};
use crate::{
    load::{
        colors::{Scale, greys},
        error::LoadProblem,
        far,
        mesh::Mesh,
    },
    validate::{is_color, is_radius},
};
use bytemuck::zeroed_vec;
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;
use std::{
    io::BufRead,
    slice::ChunksMut,
    sync::{Mutex, PoisonError},
};

/// Reads positions and the other columns that are present; skips other properties, with a warning.
///
/// Colours in integers are sRGB as in images, and the largest integer represents 1; colours in
/// floating point are linear, unless they are from 0 to 255. Without colours, an intensity is
/// shown as grey, as in points as text.
///
/// Rows of fixed size are read block by block and decoded on all threads directly into the arrays.
pub(super) fn read<R: BufRead + Send>(
    rows: &mut Rows<'_, R>,
    mesh: &mut Mesh,
) -> Result<(), LoadProblem> {
    let layout = Layout::new(rows.element, rows.encoding);
    if !layout.has(POSITION, 3) {
        let names: Vec<&str> = rows.element.properties.iter().map(|p| p.name.as_str()).collect();
        let names = crate::load::mesh::listed(&names);
        return Err(LoadProblem::PlyHeader {
            line: 1,
            problem: format!(
                "the vertices have no properties x, y and z, only: {names}; export it again, \
                 uncompressed"
            ),
        });
    }
    mesh.warnings.extend(names::not_used(rows.element, |i| layout.columns[i].is_some()));
    make_room(&layout, mesh, rows.element.count as usize);
    // Untouched unless positions are far from the origin.
    let mut rests = zeroed_vec(if layout.is_fine { mesh.positions.len() } else { 0 });
    let seen = decode(rows, &layout, Chunks::new(mesh, &mut rests))?;
    mesh.sound = seen.is_sound;
    if seen.is_far {
        mesh.offset = far::move_near(&mut mesh.positions, &rests);
    }
    if layout.is_grey {
        let brightness: Vec<f32> = mesh.colors.iter().map(|color| color.x).collect();
        mesh.colors = greys(&brightness);
    } else if layout.has_float_colors() {
        mesh.warnings.extend(seen.scale.settle(&mut mesh.colors));
    }
    Ok(())
}

/// What is known of the vertices that have been decoded.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// True if all values are valid.
    is_sound: bool,
    /// True if positions are far from the origin and not exact in single precision.
    is_far: bool,
    /// The scale of colours in floating point.
    scale: Scale,
}

impl Seen {
    const NOTHING: Self = Self { is_sound: true, is_far: false, scale: Scale::NOTHING };

    fn and(self, other: Self) -> Self {
        Self {
            is_sound: self.is_sound && other.is_sound,
            is_far: self.is_far || other.is_far,
            scale: self.scale.and(other.scale),
        }
    }
}

fn decode<R: BufRead + Send>(
    rows: &mut Rows<'_, R>,
    layout: &Layout,
    mut chunks: Chunks<'_>,
) -> Result<Seen, LoadProblem> {
    if let Some(size) = rows.row_size() {
        let seen = Mutex::new(Seen::NOTHING);
        rows.blocks().zip(chunks).par_bridge().try_for_each_init(
            Columns::default,
            |columns, (block, mut chunk)| {
                let block = block?;
                layout.decode(&block, size, columns);
                if let Some(offset) = layout.positions_at {
                    chunk.copy_positions(&block, size, offset);
                }
                let more = chunk.fill(layout, columns);
                let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner);
                *seen = seen.and(more);
                Ok(())
            },
        )?;
        return Ok(seen.into_inner().unwrap_or_else(PoisonError::into_inner));
    }
    let mut columns = Columns::default();
    let mut seen = Seen::NOTHING;
    let mut store = |columns: &mut Columns| {
        layout.interpret(columns);
        if let Some(mut chunk) = chunks.next() {
            seen = seen.and(chunk.fill(layout, columns));
        }
        columns.iter_mut().for_each(Vec::clear);
    };
    rows.for_each_row::<COUNT>(&layout.columns, |row| {
        layout.push(row, &mut columns);
        if columns[POSITION].len() == ROWS {
            store(&mut columns);
        }
    })?;
    store(&mut columns);
    Ok(seen)
}

/// Allocates the arrays as untouched zero pages, which the system maps at the first write, by the
/// thread that decodes there. The length of the file has been checked for this count.
fn make_room(layout: &Layout, mesh: &mut Mesh, count: usize) {
    let room = |present| if present { count } else { 0 };
    mesh.positions = zeroed_vec(count);
    mesh.normals = zeroed_vec(room(layout.has(NORMAL, 3)));
    mesh.texcoords = zeroed_vec(room(layout.has(TEXCOORD, 2)));
    mesh.colors = zeroed_vec(room(layout.has(COLOR, 3)));
    mesh.radii = zeroed_vec(room(layout.has_radii()));
}

/// The arrays of a mesh in chunks of [`ROWS`] vertices.
struct Chunks<'a> {
    positions: ChunksMut<'a, Vec3>,
    normals: ChunksMut<'a, Vec3>,
    texcoords: ChunksMut<'a, Vec2>,
    colors: ChunksMut<'a, Vec4>,
    radii: ChunksMut<'a, f32>,
    rests: ChunksMut<'a, Vec3>,
}

impl<'a> Chunks<'a> {
    fn new(mesh: &'a mut Mesh, rests: &'a mut [Vec3]) -> Self {
        Self {
            positions: mesh.positions.chunks_mut(ROWS),
            normals: mesh.normals.chunks_mut(ROWS),
            texcoords: mesh.texcoords.chunks_mut(ROWS),
            colors: mesh.colors.chunks_mut(ROWS),
            radii: mesh.radii.chunks_mut(ROWS),
            rests: rests.chunks_mut(ROWS),
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
    rests: &'a mut [Vec3],
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
            rests: self.rests.next().unwrap_or_default(),
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

    /// Stores columns; returns what is known of them then, while they are in the cache: a second
    /// pass would take as long as reading the file.
    fn fill(&mut self, layout: &Layout, columns: &Columns) -> Seen {
        let [x, y, z, nx, ny, nz, u, v, red, green, blue, alpha, radius, .., rx, ry, rz] = columns;
        let vectors = |to: &mut [Vec3], [x, y, z]: [&[f32]; 3]| {
            for (((to, &x), &y), &z) in to.iter_mut().zip(x).zip(y).zip(z) {
                *to = Vec3::new(x, y, z);
            }
        };
        vectors(self.positions, [x, y, z]);
        vectors(self.normals, [nx, ny, nz]);
        let is_far = self.store_rests([rx, ry, rz]);
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
        let scale = if layout.has_float_colors() {
            Scale::of_channels(red, green, blue)
        } else {
            Scale::NOTHING
        };
        Seen { is_sound: self.is_sound(), is_far, scale }
    }

    /// Stores what far positions lose if they become single; returns false if none is far.
    fn store_rests(&mut self, columns: [&Vec<f32>; 3]) -> bool {
        let is_far = |p: &Vec3| f64::from(p.abs().max_element()) >= far::FAR;
        if columns.iter().all(|column| column.is_empty()) || !self.positions.iter().any(is_far) {
            return false;
        }
        for (axis, column) in columns.into_iter().enumerate() {
            self.rests.iter_mut().zip(column).for_each(|(to, &rest)| to[axis] = rest);
        }
        true
    }
}
