//! Meshes as they are in files, with elements of any kind, and their conversion to shapes.

mod element_colors;
mod faces;
mod parts;
mod polygons;
mod settle;

pub(crate) use faces::{FaceElements, Faces, Look, NO_MATERIAL};
pub(crate) use parts::Part;
pub(crate) use settle::not_named;

use glam::{DVec3, Vec2, Vec3, Vec4};
use std::path::PathBuf;

/// The content of a file. Readers fill it in unchecked: indices may be out of range and values NaN.
/// After [`Mesh::settle`] it is valid.
#[derive(Debug, Default)]
pub(crate) struct Mesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub texcoords: Vec<Vec2>,
    pub colors: Vec<Vec4>,
    pub radii: Vec<f32>,
    pub points: Vec<u32>,
    pub lines: Vec<[u32; 2]>,
    /// The colour of each line; empty if lines have none of their own.
    pub line_colors: Vec<Vec4>,
    /// The material of each line, as of faces; empty if no line has one.
    pub line_materials: Vec<u32>,
    pub faces: Faces,
    /// What has been subtracted from all positions of the file.
    pub offset: DVec3,
    /// The materials that faces name.
    pub materials: Vec<MeshMaterial>,
    /// The files that define the materials by name.
    pub libraries: Vec<String>,
    /// Other files that were read.
    pub files: Vec<PathBuf>,
    /// Texts of warnings about the file.
    pub warnings: Vec<String>,
    /// True if the vertex arrays are known to be valid.
    pub sound: bool,
}

/// A material that the file of a mesh defines or names.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshMaterial {
    pub name: String,
    /// Linear; `None` if it is not known.
    pub color: Option<Vec3>,
    /// The file of the image that scales the colour.
    pub texture: Option<String>,
}

/// The radius in meters of points and lines whose file has none.
pub(crate) const DEFAULT_RADIUS: f32 = 0.001;

impl Mesh {
    /// Returns copies of these vertices, without elements.
    fn picked(&self, vertices: &[u32]) -> Self {
        fn pick<T: Copy>(array: &[T], vertices: &[u32]) -> Vec<T> {
            if array.is_empty() {
                return Vec::new();
            }
            vertices.iter().map(|&vertex| array[vertex as usize]).collect()
        }
        Self {
            positions: pick(&self.positions, vertices),
            normals: pick(&self.normals, vertices),
            texcoords: pick(&self.texcoords, vertices),
            colors: pick(&self.colors, vertices),
            radii: pick(&self.radii, vertices),
            ..Self::default()
        }
    }

    /// Replaces the vertices by copies of these; elements stay as they are.
    pub(crate) fn gather(&mut self, vertices: &[u32]) {
        let Self { positions, normals, texcoords, colors, radii, .. } = self.picked(vertices);
        (self.positions, self.normals, self.texcoords) = (positions, normals, texcoords);
        (self.colors, self.radii) = (colors, radii);
    }
}

/// Returns the first names of a list, and how many more there are.
pub(crate) fn listed<T: AsRef<str>>(names: &[T]) -> String {
    const MOST: usize = 12;
    let first: Vec<&str> = names.iter().take(MOST).map(AsRef::as_ref).collect();
    let first = first.join(", ");
    match names.len().saturating_sub(MOST) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}
