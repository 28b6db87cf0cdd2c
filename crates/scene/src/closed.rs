//! Whether the surface of a shape encloses a volume.

use crate::{Elements, Method, Shape};
use glam::{DVec3, Vec3};
use std::{
    cmp::Ordering,
    hash::{DefaultHasher, Hash, Hasher},
};

impl Shape {
    /// Returns true if the surface encloses a volume and faces outwards, so that every ray from
    /// inside meets it.
    ///
    /// Exact spheres and rounded cones do, vanilla discs and ribbons do not. Triangles and quads do
    /// if each edge of a face is, in the other direction, one of another face, and the volume is
    /// positive. Vertices are compared by position, since those at seams of texture coordinates are
    /// there twice. The edges are compared by sums of hashes of 64 bits, which takes no memory; two
    /// sums are equal by chance once in 2⁶⁴.
    ///
    /// # Panics
    ///
    /// If an element has a vertex that is not there, which [`crate::Scene::validate`] refuses.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        let mut surface = Surface::default();
        let corner = |vertex: u32| self.positions[vertex as usize];
        match &self.elements {
            Elements::Points(_) | Elements::Lines(_) => return self.method == Method::Enhanced,
            Elements::Triangles(faces) => {
                faces.iter().for_each(|face| surface.add(face.map(corner)));
            }
            Elements::Quads(faces) => {
                faces.iter().for_each(|face| surface.add(face.map(corner)));
            }
        }
        surface.edges == 0 && surface.volume > 0.0
    }
}

/// Sums over the faces of a surface.
#[derive(Default)]
struct Surface {
    /// For each edge the hash of its ends, negative if it goes from the greater end to the lesser.
    edges: u64,
    /// Six times the volume.
    volume: f64,
}

impl Surface {
    /// Adds an edge of a face. One between equal corners adds nothing.
    fn add_edge(&mut self, from: Vec3, to: Vec3) {
        let (from, to) = (bits(from), bits(to));
        match from.cmp(&to) {
            Ordering::Less => self.edges = self.edges.wrapping_add(hash([from, to])),
            Ordering::Greater => self.edges = self.edges.wrapping_sub(hash([to, from])),
            Ordering::Equal => {}
        }
    }

    /// Adds a face, which may repeat a corner.
    fn add<const N: usize>(&mut self, corners: [Vec3; N]) {
        for corner in 0..N {
            self.add_edge(corners[corner], corners[(corner + 1) % N]);
        }
        let corners = corners.map(Vec3::as_dvec3);
        let of_fan = |pair: &[DVec3]| corners[0].dot(pair[0].cross(pair[1]));
        self.volume += corners[1..].windows(2).map(of_fan).sum::<f64>();
    }
}

/// Returns a hash of the ends of an edge.
fn hash(ends: [[u32; 3]; 2]) -> u64 {
    let mut hasher = DefaultHasher::new();
    u32::hash_slice(ends.as_flattened(), &mut hasher);
    hasher.finish()
}

/// The bits of a position. Zeros of both signs are the same.
fn bits(position: Vec3) -> [u32; 3] {
    (position + Vec3::ZERO).to_array().map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    #[test]
    fn a_surface_is_closed_if_each_edge_has_its_reverse_and_it_faces_outwards() {
        let inside_out = FACES.map(|[a, b, c]| [a, c, b]);
        let mut one_turned = FACES;
        one_turned[3] = [1, 3, 2];
        // Each face has corners of its own; one of them has negative zeros.
        let apart: Vec<Vec3> = FACES.iter().flatten().map(|&v| CORNERS[v as usize]).collect();
        let mut signed = apart.clone();
        signed[0] = -Vec3::ZERO;
        let mut moved = apart.clone();
        moved[5].z += f32::EPSILON;
        let own = || vec![[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]];
        let corners = || CORNERS.to_vec();
        let quads = FACES.map(|[a, b, c]| [a, b, c, c]);
        for (why, shape, closed) in [
            ("a tetrahedron", Shape::triangles(corners(), FACES), true),
            ("without a face", Shape::triangles(corners(), &FACES[..3]), false),
            ("inside out", Shape::triangles(corners(), inside_out), false),
            ("with a face turned", Shape::triangles(corners(), one_turned), false),
            ("with seams", Shape::triangles(signed, own()), true),
            ("with a gap", Shape::triangles(moved, own()), false),
            ("of quads that repeat a corner", Shape::quads(corners(), quads), true),
            ("nothing", Shape::triangles(corners(), []), false),
            ("a ball", Shape::points([Vec3::ZERO], 1.0), true),
            ("a tube", Shape::lines([Vec3::ZERO, Vec3::X], 1.0, [[0, 1]]), true),
        ] {
            assert_eq!(shape.is_closed(), closed, "{why}");
            let vanilla = Shape { method: Method::Vanilla, ..shape };
            let flat = vanilla.elements.count() == 1;
            assert_eq!(vanilla.is_closed(), closed && !flat, "{why}, vanilla");
        }
    }
}
