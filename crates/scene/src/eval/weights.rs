//! How much each vertex of an element counts at its parameters.

use crate::{Elements, Method, Shape, primitive::Primitive};
use glam::Vec2;
use std::ops::{Add, Mul};

/// Vertices and their weights, which sum to 1. Unused places have weight 0 and a vertex in range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    vertices: [u32; 4],
    weights: [f32; 4],
}

impl Weights {
    /// Tubes interpolate along their axis, as yocto-gl's lines do: every point of the surface has the
    /// value of the ball that touches it. Patches are bilinear in everything, two triangles linear in
    /// each.
    pub(super) fn new(shape: &Shape, element: u32, uv: Vec2) -> Self {
        let (u, v) = (uv.x, uv.y);
        match &shape.elements {
            Elements::Points(_) => Self { vertices: [element; 4], weights: [1.0, 0.0, 0.0, 0.0] },
            Elements::Lines(lines) => {
                let [a, b] = lines[element as usize];
                let s = match shape.primitive(element) {
                    Primitive::Cone(cone) => cone.along_axis(uv),
                    _ => u,
                };
                Self { vertices: [a, b, b, b], weights: [1.0 - s, s, 0.0, 0.0] }
            }
            Elements::Triangles(triangles) => {
                let [a, b, c] = triangles[element as usize];
                Self { vertices: [a, b, c, c], weights: [1.0 - u - v, u, v, 0.0] }
            }
            Elements::Quads(quads) => {
                let weights = if shape.method == Method::Enhanced {
                    [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v]
                } else if u + v <= 1.0 {
                    [1.0 - u - v, u, 0.0, v]
                } else {
                    [0.0, 1.0 - v, u + v - 1.0, 1.0 - u]
                };
                Self { vertices: quads[element as usize], weights }
            }
        }
    }

    /// The weighted sum over a vertex array; `None` if the shape has no such array.
    pub(super) fn of<T>(&self, array: &[T]) -> Option<T>
    where
        T: Copy + Add<Output = T> + Mul<f32, Output = T>,
    {
        if array.is_empty() {
            return None;
        }
        let [a, b, c, d] = self.vertices.map(|vertex| array[vertex as usize]);
        let [wa, wb, wc, wd] = self.weights;
        Some(a * wa + b * wb + c * wc + d * wd)
    }
}
