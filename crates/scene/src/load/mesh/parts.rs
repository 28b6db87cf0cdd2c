//! Division of a mesh into shapes, each with elements of one kind and one material.

use super::{Mesh, NO_MATERIAL, faces::FaceElements};
use crate::{Elements, Shape};
use glam::Vec4;
use std::collections::HashMap;

/// A shape of a file, and the material that the file gives it, an index into [`Mesh::materials`].
#[derive(Debug)]
pub(crate) struct Part {
    pub shape: Shape,
    pub material: Option<u32>,
}

impl Mesh {
    /// Converts a settled mesh: first the faces, by their materials, then lines. Points beside
    /// lines are lines of no length, so that they are balls of the same body. Vertices without any
    /// elements are points.
    pub(crate) fn into_parts(mut self, default_radius: f32) -> Vec<Part> {
        if !self.lines.is_empty() {
            self.lines.extend(self.points.drain(..).map(|point| [point, point]));
        }
        let kinds = [!self.faces.is_empty(), !self.lines.is_empty(), !self.points.is_empty()];
        let several = kinds.iter().filter(|present| **present).count() > 1;
        let one_material = self.faces.materials.windows(2).all(|pair| pair[0] == pair[1]);
        if !several && one_material {
            return vec![self.into_part(default_radius)];
        }
        let mut numbers = Numbers::new(self.positions.len());
        let mut parts = self.face_parts(&mut numbers);
        let lines: Vec<_> = self.lines.iter().map(|line| line.map(|end| numbers.of(end))).collect();
        let vertices = numbers.finish();
        if !lines.is_empty() {
            let with_lines = Self { lines, ..self.picked(&vertices) };
            parts.push(with_lines.into_part(default_radius));
        }
        if !self.points.is_empty() {
            parts.push(self.picked(&self.points).into_part(default_radius));
        }
        parts
    }

    /// Returns the faces of each material, in the order of their first use.
    fn face_parts(&mut self, numbers: &mut Numbers) -> Vec<Part> {
        let of_face = std::mem::take(&mut self.faces.materials);
        let mut order: Vec<u32> = Vec::new();
        let mut faces_of: HashMap<u32, Vec<usize>> = HashMap::new();
        for face in 0..self.faces.len() {
            let material = of_face.get(face).copied().unwrap_or(NO_MATERIAL);
            let faces = faces_of.entry(material).or_default();
            if faces.is_empty() {
                order.push(material);
            }
            faces.push(face);
        }
        let mut part = |material: &u32| {
            let faces = &faces_of[material];
            let elements = match &self.faces.elements {
                FaceElements::Triangles(triangles) => {
                    let own = faces.iter().map(|&face| triangles[face].map(|v| numbers.of(v)));
                    FaceElements::Triangles(own.collect())
                }
                FaceElements::Quads(quads) => {
                    let own = faces.iter().map(|&face| quads[face].map(|v| numbers.of(v)));
                    FaceElements::Quads(own.collect())
                }
            };
            let mut mesh = self.picked(&numbers.finish());
            mesh.faces.elements = elements;
            let material = (*material != NO_MATERIAL).then_some(*material);
            Part { material, ..mesh.into_part(0.0) }
        };
        order.iter().map(&mut part).collect()
    }

    /// Converts a mesh of one kind of elements and at most one material.
    fn into_part(mut self, default_radius: f32) -> Part {
        let mut material = None;
        let elements = if !self.faces.is_empty() {
            material = self.faces.materials.first().copied().filter(|&i| i != NO_MATERIAL);
            match std::mem::take(&mut self.faces.elements) {
                FaceElements::Triangles(triangles) => Elements::Triangles(triangles),
                FaceElements::Quads(quads) => Elements::Quads(quads),
            }
        } else if !self.lines.is_empty() {
            Elements::Lines(std::mem::take(&mut self.lines))
        } else {
            let points = std::mem::take(&mut self.points);
            let in_order = points.iter().copied().eq(0..self.positions.len() as u32);
            if !points.is_empty() && !in_order {
                self.gather(&points);
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
        Part { shape, material }
    }

    /// Gives the colours of materials to the vertices instead of the materials, for a shape that
    /// has its material from elsewhere; says so or why not.
    pub(crate) fn materials_to_colors(&mut self) {
        let mut used = std::mem::take(&mut self.faces.materials);
        let materials = std::mem::take(&mut self.materials);
        let of = |face: &u32| materials.get(*face as usize);
        let several = used.windows(2).any(|pair| pair[0] != pair[1]);
        let colored = several
            && self.colors.is_empty()
            && used.iter().filter_map(of).all(|m| m.color.is_some() && m.texture.is_none());
        if colored {
            let color = |face: &u32| of(face).and_then(|material| material.color);
            let colors: Vec<Vec4> =
                used.iter().map(|face| color(face).map_or(Vec4::ONE, |c| c.extend(1.0))).collect();
            self.color_vertices(&colors, &[]);
            return;
        }
        used.sort_unstable();
        used.dedup();
        let names: Vec<&str> =
            used.iter().filter_map(of).map(|material| material.name.as_str()).collect();
        if !names.is_empty() {
            let names = super::listed(&names);
            self.warnings.push(format!(
                "materials of the file are not used, since the scene gives one: {names}"
            ));
        }
    }
}

/// Numbers vertices anew, in the order of their first use.
struct Numbers {
    number_of: Vec<u32>,
    used: Vec<u32>,
}

impl Numbers {
    const NONE: u32 = u32::MAX;

    fn new(count: usize) -> Self {
        Self { number_of: vec![Self::NONE; count], used: Vec::new() }
    }

    fn of(&mut self, vertex: u32) -> u32 {
        let number = &mut self.number_of[vertex as usize];
        if *number == Self::NONE {
            *number = self.used.len() as u32;
            self.used.push(vertex);
        }
        *number
    }

    /// Returns the vertices in use, and forgets them.
    fn finish(&mut self) -> Vec<u32> {
        for &vertex in &self.used {
            self.number_of[vertex as usize] = Self::NONE;
        }
        std::mem::take(&mut self.used)
    }
}
