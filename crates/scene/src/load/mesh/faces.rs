//! Faces as they are collected from a file.

use crate::validate::first_outside;
use glam::Vec4;

/// Faces: triangles until the first quad.
#[derive(Debug, Default)]
pub(crate) struct Faces {
    pub elements: FaceElements,
    /// The polygons of more than four corners: the first of the triangles around their first
    /// corner, and the number of triangles.
    pub polygons: Vec<[u32; 2]>,
    /// The colour of each element; empty if no face has one.
    pub colors: Vec<Vec4>,
    /// The material of each element, an index into [`super::Mesh::materials`] or [`NO_MATERIAL`];
    /// empty if no face has one.
    pub materials: Vec<u32>,
    /// Faces of two vertices, which are edges in files without other faces.
    pub pairs: Vec<[u32; 2]>,
    /// The number of faces of fewer vertices.
    pub short_count: usize,
}

#[derive(Debug)]
pub(crate) enum FaceElements {
    Triangles(Vec<[u32; 3]>),
    Quads(Vec<[u32; 4]>),
}

impl Default for FaceElements {
    fn default() -> Self {
        Self::Triangles(Vec::new())
    }
}

/// The material of faces without one.
pub(crate) const NO_MATERIAL: u32 = u32::MAX;

/// What a file says about a face beside its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    pub color: Vec4,
    pub material: u32,
}

impl Default for Look {
    fn default() -> Self {
        Self { color: Vec4::ONE, material: NO_MATERIAL }
    }
}

impl Faces {
    /// Adds a polygon. The first quad converts all triangles to quads that repeat their last
    /// vertex. Larger polygons become a fan of triangles, until it is known
    /// which are concave.
    pub(crate) fn push_polygon(&mut self, polygon: &[u32], look: Look) {
        let first = self.len();
        match *polygon {
            [a, b, c] => self.push_triangle(a, b, c),
            [a, b, c, d] => self.push_quad([a, b, c, d]),
            [a, b] => self.pairs.push([a, b]),
            [] | [_] => self.short_count += 1,
            [center, ref rest @ ..] => {
                self.polygons.push([first as u32, rest.len() as u32 - 1]);
                for pair in rest.windows(2) {
                    self.push_triangle(center, pair[0], pair[1]);
                }
            }
        }
        let count = self.len();
        note(&mut self.colors, first..count, look.color, Vec4::ONE);
        note(&mut self.materials, first..count, look.material, NO_MATERIAL);
    }

    fn push_triangle(&mut self, a: u32, b: u32, c: u32) {
        match &mut self.elements {
            FaceElements::Triangles(triangles) => triangles.push([a, b, c]),
            FaceElements::Quads(quads) => quads.push([a, b, c, c]),
        }
    }

    fn push_quad(&mut self, quad: [u32; 4]) {
        if let FaceElements::Triangles(triangles) = &mut self.elements {
            let quads = triangles.drain(..).map(|[a, b, c]| [a, b, c, c]).collect();
            self.elements = FaceElements::Quads(quads);
        }
        if let FaceElements::Quads(quads) = &mut self.elements {
            quads.push(quad);
        }
    }

    pub(crate) fn len(&self) -> usize {
        match &self.elements {
            FaceElements::Triangles(triangles) => triangles.len(),
            FaceElements::Quads(quads) => quads.len(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn is_triangles(&self) -> bool {
        matches!(self.elements, FaceElements::Triangles(_))
    }

    /// Returns the first face that names a vertex beyond `count`, and the vertex.
    pub(crate) fn first_outside(&self, count: usize) -> Option<(usize, u32)> {
        match &self.elements {
            FaceElements::Triangles(triangles) => first_outside(triangles, count),
            FaceElements::Quads(quads) => first_outside(quads, count),
        }
    }

    /// Keeps the faces whose vertices are all kept; returns how many are left out.
    pub(crate) fn retain(&mut self, kept: &[bool]) -> usize {
        let stays = |face: &[u32]| face.iter().all(|&vertex| kept[vertex as usize]);
        let which: Vec<bool> = match &self.elements {
            FaceElements::Triangles(triangles) => triangles.iter().map(|f| stays(f)).collect(),
            FaceElements::Quads(quads) => quads.iter().map(|f| stays(f)).collect(),
        };
        fn pick<T>(array: &mut Vec<T>, which: &[bool]) {
            let mut which = which.iter();
            array.retain(|_| which.next().copied().unwrap_or(true));
        }
        match &mut self.elements {
            FaceElements::Triangles(triangles) => pick(triangles, &which),
            FaceElements::Quads(quads) => pick(quads, &which),
        }
        pick(&mut self.colors, &which);
        pick(&mut self.materials, &which);
        self.polygons.clear();
        which.iter().filter(|stays| !**stays).count()
    }

    /// Calls `each` with each vertex of each face.
    pub(crate) fn for_each_vertex(&mut self, mut each: impl FnMut(&mut u32)) {
        match &mut self.elements {
            FaceElements::Triangles(triangles) => triangles.as_flattened_mut().iter_mut(),
            FaceElements::Quads(quads) => quads.as_flattened_mut().iter_mut(),
        }
        .for_each(&mut each);
    }
}

/// Sets the items of an array that stays empty while all items have the usual value.
fn note<T: Copy + PartialEq>(
    array: &mut Vec<T>,
    range: std::ops::Range<usize>,
    value: T,
    usual: T,
) {
    if array.is_empty() && value == usual {
        return;
    }
    array.resize(range.start, usual);
    array.resize(range.end, value);
}
