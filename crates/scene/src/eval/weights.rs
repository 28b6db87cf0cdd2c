//! Interpolation weights of the vertices of an element.

use crate::{Elements, Method, Shape, primitive::Primitive};
use glam::Vec2;
use std::ops::{Add, Mul};

/// Vertices and their weights, which sum to 1. Unused entries have weight 0 and a valid vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    vertices: [u32; 4],
    weights: [f32; 4],
}

impl Weights {
    /// Computes the weights at parameters `uv`. Lines interpolate along their axis as in yocto-gl,
    /// so a point of a rounded cone has the value of the inscribed ball that touches the surface
    /// there. Patches interpolate bilinearly, and the two triangles of a vanilla quad linearly
    /// each.
    #[inline]
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

    /// Returns the weighted sum over a vertex array; `None` if the array is empty.
    #[inline]
    pub(super) fn of<T>(&self, array: &[T]) -> Option<T>
    where
        T: Copy + Add<Output = T> + Mul<f32, Output = T>,
    {
        if array.is_empty() {
            return None;
        }
        // `map` of an array is an outlined call, whose result is read while it is still on its way
        // to memory.
        let at = |place: usize| array[self.vertices[place] as usize] * self.weights[place];
        Some(at(0) + at(1) + at(2) + at(3))
    }
}
