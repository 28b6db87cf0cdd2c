//! Meshes as they are in files, with elements of any kind, and their conversion to shapes.

use super::error::LoadProblem;
use crate::{
    Elements, Shape,
    validate::{first, first_outside, is_color, is_radius, listed},
};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// The arrays of a file, unchecked: indices may be out of range and values may be NaN.
#[derive(Debug, Default)]
pub(crate) struct Mesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub texcoords: Vec<Vec2>,
    pub colors: Vec<Vec4>,
    pub radii: Vec<f32>,
    pub points: Vec<u32>,
    pub lines: Vec<[u32; 2]>,
    pub faces: Faces,
    /// Texts of warnings about the file.
    pub warnings: Vec<String>,
    /// True if the vertex arrays are known to be valid.
    pub sound: bool,
}

/// Faces: triangles until the first quad.
#[derive(Debug)]
pub(crate) enum Faces {
    Triangles(Vec<[u32; 3]>),
    Quads(Vec<[u32; 4]>),
}

impl Default for Faces {
    fn default() -> Self {
        Self::Triangles(Vec::new())
    }
}

impl Faces {
    /// Adds a polygon. The first quad converts all triangles to quads that repeat their last
    /// vertex. Larger polygons are divided into a fan of triangles.
    pub(crate) fn push_polygon(&mut self, polygon: &[u32]) {
        match *polygon {
            [a, b, c] => self.push_triangle(a, b, c),
            [a, b, c, d] => self.push_quad([a, b, c, d]),
            [first, ref rest @ ..] => {
                for pair in rest.windows(2) {
                    self.push_triangle(first, pair[0], pair[1]);
                }
            }
            [] => {}
        }
    }

    fn push_triangle(&mut self, a: u32, b: u32, c: u32) {
        match self {
            Self::Triangles(triangles) => triangles.push([a, b, c]),
            Self::Quads(quads) => quads.push([a, b, c, c]),
        }
    }

    fn push_quad(&mut self, quad: [u32; 4]) {
        if let Self::Triangles(triangles) = self {
            let quads = triangles.drain(..).map(|[a, b, c]| [a, b, c, c]).collect();
            *self = Self::Quads(quads);
        }
        if let Self::Quads(quads) = self {
            quads.push(quad);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        match self {
            Self::Triangles(triangles) => triangles.is_empty(),
            Self::Quads(quads) => quads.is_empty(),
        }
    }
}

/// The radius in meters of points and lines whose file has none.
pub(crate) const DEFAULT_RADIUS: f32 = 0.001;

impl Mesh {
    /// Checks all arrays and converts the mesh; returns the shape with warnings about values that
    /// were replaced.
    pub(crate) fn into_shape(
        mut self,
        default_radius: f32,
    ) -> Result<(Shape, Vec<String>), LoadProblem> {
        self.check_kinds()?;
        let mut warnings = self.check_vertices()?;
        warnings.append(&mut self.warnings);
        let count = self.positions.len();
        let elements = if !self.faces.is_empty() {
            match std::mem::take(&mut self.faces) {
                Faces::Triangles(triangles) => {
                    check_indices("face", &triangles, count)?;
                    Elements::Triangles(triangles)
                }
                Faces::Quads(quads) => {
                    check_indices("face", &quads, count)?;
                    Elements::Quads(quads)
                }
            }
        } else if !self.lines.is_empty() {
            let lines = std::mem::take(&mut self.lines);
            check_indices("line", &lines, count)?;
            Elements::Lines(lines)
        } else {
            let points = std::mem::take(&mut self.points);
            if !points.is_empty() {
                self.gather(&points)?;
            }
            Elements::Points(u32::try_from(self.positions.len()).unwrap_or(u32::MAX))
        };
        if matches!(elements, Elements::Points(_) | Elements::Lines(_)) {
            if self.radii.is_empty() {
                self.radii = vec![default_radius; self.positions.len()];
            }
        } else {
            self.radii = Vec::new();
        }
        let shape = Shape {
            elements,
            positions: self.positions,
            normals: self.normals,
            texcoords: self.texcoords,
            colors: self.colors,
            radii: self.radii,
            ..Shape::default()
        };
        Ok((shape, warnings))
    }

    /// Refuses elements of more than one kind. Vertices without elements are a point cloud.
    fn check_kinds(&self) -> Result<(), LoadProblem> {
        let kinds = [
            (!self.points.is_empty(), "points"),
            (!self.lines.is_empty(), "lines"),
            (!self.faces.is_empty(), "faces"),
        ];
        let mut present = kinds.iter().filter(|(present, _)| *present).map(|(_, name)| *name);
        match (present.next(), present.next()) {
            (Some(first), Some(second)) => Err(LoadProblem::MixedElements { first, second }),
            (None, _) if self.positions.is_empty() => Err(LoadProblem::EmptyShape),
            _ => Ok(()),
        }
    }

    /// Refuses invalid vertex data; replaces normals and texture coordinates that are not finite,
    /// with a warning.
    fn check_vertices(&mut self) -> Result<Vec<String>, LoadProblem> {
        let count = self.positions.len() as u64;
        if count > u64::from(u32::MAX) {
            let limit = u64::from(u32::MAX);
            return Err(LoadProblem::TooMany { what: "vertices", count, limit });
        }
        let mut warnings = Vec::new();
        if self.sound {
            return Ok(warnings);
        }
        let bad = |index: usize, property: &str, value: String, expected| {
            Err(LoadProblem::ElementValue {
                element: "vertex".to_owned(),
                index: index as u64,
                property: property.to_owned(),
                value,
                expected,
            })
        };
        if let Some(i) = first(&self.positions, |p| !p.is_finite()) {
            let position = listed(self.positions[i].as_ref());
            return bad(i, "position", position, "finite coordinates");
        }
        if let Some(i) = first(&self.radii, |r| !is_radius(r)) {
            let expected = "a finite number that is not negative";
            return bad(i, "radius", self.radii[i].to_string(), expected);
        }
        if let Some(i) = first(&self.colors, |c| !is_color(c)) {
            let expected = "finite numbers that are not negative";
            return bad(i, "color", listed(self.colors[i].as_ref()), expected);
        }
        // Real files have a few of these where a mesh degenerates. Zero stands for no normal.
        let normals = self.normals.par_iter_mut().filter(|normal| !normal.is_finite());
        let texcoords = self.texcoords.par_iter_mut().filter(|texcoord| !texcoord.is_finite());
        let mended = normals.map(|normal| *normal = Vec3::ZERO).count()
            + texcoords.map(|texcoord| *texcoord = Vec2::ZERO).count();
        if mended > 0 {
            warnings.push(format!(
                "{mended} normals or texture coordinates are not finite; taken as zero"
            ));
        }
        Ok(warnings)
    }

    /// Reorders the vertices so that point `i` is vertex `i`.
    fn gather(&mut self, points: &[u32]) -> Result<(), LoadProblem> {
        let points: &[[u32; 1]] = points.as_chunks().0;
        check_indices("point", points, self.positions.len())?;
        let in_order = points.iter().zip(0..).all(|(point, i)| point[0] == i);
        if in_order && points.len() == self.positions.len() {
            return Ok(());
        }
        fn pick<T: Copy>(points: &[[u32; 1]], array: &mut Vec<T>) {
            if !array.is_empty() {
                *array = points.iter().map(|point| array[point[0] as usize]).collect();
            }
        }
        pick(points, &mut self.positions);
        pick(points, &mut self.normals);
        pick(points, &mut self.texcoords);
        pick(points, &mut self.colors);
        pick(points, &mut self.radii);
        Ok(())
    }
}

fn check_indices<const N: usize>(
    element: &str,
    elements: &[[u32; N]],
    count: usize,
) -> Result<(), LoadProblem> {
    match first_outside(elements, count) {
        None => Ok(()),
        Some((index, vertex)) => Err(LoadProblem::VertexOutOfRange {
            element: element.to_owned(),
            index: index as u64,
            vertex: i64::from(vertex),
            count,
        }),
    }
}
