//! Surfaces of grids of quads.

use crate::{Elements, Shape};
use glam::{Vec2, Vec3};

/// A vertex of a surface.
pub(super) struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    /// Texture coordinate; `v` runs down the image.
    pub texcoord: Vec2,
}

/// The orientation of quads, seen with `u` to the right and `v` up.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Winding {
    CounterClockwise,
    Clockwise,
}

/// Returns a shape without elements, to which grids are added.
pub(super) fn surface() -> Shape {
    Shape { elements: Elements::Quads(Vec::new()), ..Shape::default() }
}

/// Adds `columns` by `rows` quads over the unit square, row by row from `v = 0` up.
pub(super) fn add_grid(
    shape: &mut Shape,
    [columns, rows]: [u32; 2],
    winding: Winding,
    vertex: impl Fn(Vec2) -> Vertex,
) {
    let first = shape.positions.len() as u32;
    for j in 0..=rows {
        for i in 0..=columns {
            let uv = Vec2::new(i as f32 / columns as f32, j as f32 / rows as f32);
            let Vertex { position, normal, texcoord } = vertex(uv);
            shape.positions.push(position);
            shape.normals.push(normal);
            shape.texcoords.push(texcoord);
        }
    }
    let Elements::Quads(quads) = &mut shape.elements else { return };
    for j in 0..rows {
        for i in 0..columns {
            let a = first + j * (columns + 1) + i;
            let [b, c, d] = [a + 1, a + columns + 2, a + columns + 1];
            quads.push(match winding {
                Winding::CounterClockwise => [a, b, c, d],
                Winding::Clockwise => [a, d, c, b],
            });
        }
    }
}
