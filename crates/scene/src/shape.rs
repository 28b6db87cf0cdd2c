//! Elements over vertices.

use glam::{Vec2, Vec3, Vec4};
use rotund_geometry::Method;

/// The kinds of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ElementKind {
    /// Spheres, or discs that face the ray.
    Points,
    /// Rounded cones, or ribbons that face the ray.
    Lines,
    /// Triangles with either method.
    Triangles,
    /// Bilinear patches, or pairs of triangles.
    Quads,
}

/// Vertex indices of each element; a shape has elements of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Elements {
    /// How many: point `i` is vertex `i`, so that a cloud stores no indices.
    Points(u32),
    /// From the first vertex to the second.
    Lines(Vec<[u32; 2]>),
    /// Three corners, counter-clockwise seen from the front.
    Triangles(Vec<[u32; 3]>),
    /// Four corners in order around the quad; a triangle repeats its last vertex.
    Quads(Vec<[u32; 4]>),
}

impl Elements {
    /// Which kind.
    #[must_use]
    pub fn kind(&self) -> ElementKind {
        match self {
            Self::Points(_) => ElementKind::Points,
            Self::Lines(_) => ElementKind::Lines,
            Self::Triangles(_) => ElementKind::Triangles,
            Self::Quads(_) => ElementKind::Quads,
        }
    }

    /// How many.
    #[must_use]
    pub fn count(&self) -> usize {
        match self {
            Self::Points(count) => *count as usize,
            Self::Lines(lines) => lines.len(),
            Self::Triangles(triangles) => triangles.len(),
            Self::Quads(quads) => quads.len(),
        }
    }
}

/// Geometry in object space. An array of vertex data is empty or as long as `positions`.
#[derive(Clone, Debug)]
pub struct Shape {
    /// For messages.
    pub name: String,
    /// How its elements are met by rays.
    pub method: Method,
    /// Which vertices make an element.
    pub elements: Elements,
    /// Meters.
    pub positions: Vec<Vec3>,
    /// Unit length; tangents along the line for lines.
    pub normals: Vec<Vec3>,
    /// `v` runs down the image.
    pub texcoords: Vec<Vec2>,
    /// Linear red, green, blue and opacity: they scale colour, emission and opacity.
    pub colors: Vec<Vec4>,
    /// Of points and lines, in meters; never empty for them.
    pub radii: Vec<f32>,
}

impl Shape {
    /// Memory of all arrays.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let elements = match &self.elements {
            Elements::Points(_) => 0,
            Elements::Lines(lines) => size_of_val(lines.as_slice()),
            Elements::Triangles(triangles) => size_of_val(triangles.as_slice()),
            Elements::Quads(quads) => size_of_val(quads.as_slice()),
        };
        elements
            + size_of_val(self.positions.as_slice())
            + size_of_val(self.normals.as_slice())
            + size_of_val(self.texcoords.as_slice())
            + size_of_val(self.colors.as_slice())
            + size_of_val(self.radii.as_slice())
    }
}
