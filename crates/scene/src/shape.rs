//! Elements over vertices.

use crate::Overlap;
use glam::{Vec2, Vec3, Vec4};
use rotund_geometry::Method;
use std::fmt;

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

impl fmt::Display for ElementKind {
    /// The plural in lower case, as in `triangles`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Points => "points",
            Self::Lines => "lines",
            Self::Triangles => "triangles",
            Self::Quads => "quads",
        })
    }
}

/// Vertex indices of each element; a shape has elements of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Elements {
    /// The number of points: point `i` is vertex `i`, so that point clouds store no indices.
    Points(u32),
    /// The first and the second end.
    Lines(Vec<[u32; 2]>),
    /// Three corners, counter-clockwise seen from the front.
    Triangles(Vec<[u32; 3]>),
    /// Four corners in order around the quad; a triangle repeats its last vertex.
    Quads(Vec<[u32; 4]>),
}

impl Default for Elements {
    /// No points.
    fn default() -> Self {
        Self::Points(0)
    }
}

impl Elements {
    /// Returns the kind of the elements.
    #[must_use]
    pub fn kind(&self) -> ElementKind {
        match self {
            Self::Points(_) => ElementKind::Points,
            Self::Lines(_) => ElementKind::Lines,
            Self::Triangles(_) => ElementKind::Triangles,
            Self::Quads(_) => ElementKind::Quads,
        }
    }

    /// Returns the number of elements.
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
///
/// [`Shape::points`], [`Shape::lines`], [`Shape::triangles`] and [`Shape::quads`] create a shape
/// from positions and elements. Struct update syntax adds a name, normals, texture coordinates or
/// colours:
///
/// ```
/// use rotund_scene::{Shape, geometry::glam::{Vec3, Vec4}};
///
/// let colors = vec![Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0)];
/// let tube = Shape { colors, ..Shape::lines([Vec3::ZERO, Vec3::X], [0.2, 0.1], [[0, 1]]) };
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Name for messages; may be empty.
    pub name: String,
    /// Exact shapes or the usual approximations.
    pub method: Method,
    /// Whether points or lines that overlap are one body.
    pub overlap: Overlap,
    /// Vertex indices of each element.
    pub elements: Elements,
    /// Vertex positions in meters.
    pub positions: Vec<Vec3>,
    /// Normals of triangles and quads, tangents of lines; normalized on use, and zero for a vertex
    /// without one.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; `v` runs down the image.
    pub texcoords: Vec<Vec2>,
    /// Linear red, green, blue and opacity. They scale colour, emission and opacity of the
    /// material.
    pub colors: Vec<Vec4>,
    /// Radii in meters, required for points and lines.
    pub radii: Vec<f32>,
}

/// Radii of points or lines, converted from one `f32` for all positions, or from an array, slice or
/// `Vec` with one for each position.
#[derive(Clone, Debug, PartialEq)]
pub enum Radii {
    /// The same radius at each position.
    All(f32),
    /// One radius for each position.
    Each(Vec<f32>),
}

impl From<f32> for Radii {
    fn from(radius: f32) -> Self {
        Self::All(radius)
    }
}

impl From<Vec<f32>> for Radii {
    fn from(radii: Vec<f32>) -> Self {
        Self::Each(radii)
    }
}

impl From<&[f32]> for Radii {
    fn from(radii: &[f32]) -> Self {
        Self::Each(radii.to_vec())
    }
}

impl<const N: usize> From<[f32; N]> for Radii {
    fn from(radii: [f32; N]) -> Self {
        Self::Each(radii.to_vec())
    }
}

impl Radii {
    fn of(self, positions: &[Vec3]) -> Vec<f32> {
        match self {
            Self::All(radius) => vec![radius; positions.len()],
            Self::Each(radii) => radii,
        }
    }
}

impl Shape {
    /// Creates a point at each position: a sphere, or with [`Method::Vanilla`] a disc that faces
    /// the ray.
    ///
    /// `radii` is one number for all positions, or one for each. The constructors check nothing:
    /// [`crate::Scene::validate`], and so [`crate::Trees::build`], reports which value is wrong.
    #[must_use]
    pub fn points(positions: impl Into<Vec<Vec3>>, radii: impl Into<Radii>) -> Self {
        let positions = positions.into();
        // Validation refuses this many points, since no tree holds them.
        let elements = Elements::Points(u32::try_from(positions.len()).unwrap_or(u32::MAX));
        Self { radii: radii.into().of(&positions), elements, positions, ..Self::default() }
    }

    /// Creates lines between pairs of positions: rounded cones, or with [`Method::Vanilla`] ribbons
    /// that face the ray. A strand or polyline of three positions is `[[0, 1], [1, 2]]`.
    ///
    /// `radii` is one number for all positions, or one for each.
    #[must_use]
    pub fn lines(
        positions: impl Into<Vec<Vec3>>,
        radii: impl Into<Radii>,
        lines: impl Into<Vec<[u32; 2]>>,
    ) -> Self {
        let (positions, elements) = (positions.into(), Elements::Lines(lines.into()));
        Self { radii: radii.into().of(&positions), elements, positions, ..Self::default() }
    }

    /// Creates triangles of three positions each, counter-clockwise seen from the front.
    #[must_use]
    pub fn triangles(positions: impl Into<Vec<Vec3>>, triangles: impl Into<Vec<[u32; 3]>>) -> Self {
        let (positions, elements) = (positions.into(), Elements::Triangles(triangles.into()));
        Self { elements, positions, ..Self::default() }
    }

    /// Creates quads of four positions each, in order around the quad, counter-clockwise seen from
    /// the front: bilinear patches, or with [`Method::Vanilla`] pairs of triangles.
    #[must_use]
    pub fn quads(positions: impl Into<Vec<Vec3>>, quads: impl Into<Vec<[u32; 4]>>) -> Self {
        let (positions, elements) = (positions.into(), Elements::Quads(quads.into()));
        Self { elements, positions, ..Self::default() }
    }

    /// Returns the size of all arrays in bytes.
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
