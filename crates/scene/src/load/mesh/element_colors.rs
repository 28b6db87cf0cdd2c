//! Colours of faces and lines become colours of vertices, which are repeated where colours meet.

use super::Mesh;
use crate::load::colors::Scale;
use glam::Vec4;
use std::collections::HashMap;

impl Mesh {
    /// Gives lines the colours of their materials.
    pub(crate) fn color_lines_by_materials(&mut self) {
        let materials = std::mem::take(&mut self.line_materials);
        let color = |&i: &u32| self.materials.get(i as usize).and_then(|material| material.color);
        if materials.iter().any(|i| color(i).is_some()) {
            let colors = materials.iter().map(|i| color(i).map_or(Vec4::ONE, |c| c.extend(1.0)));
            self.line_colors = colors.collect();
        }
    }

    /// Gives the colours of faces and lines to their vertices. Colours of vertices come first,
    /// unless they are all the same.
    pub(super) fn color_by_elements(&mut self) {
        let mut of_faces = std::mem::take(&mut self.faces.colors);
        let mut of_lines = std::mem::take(&mut self.line_colors);
        if of_faces.is_empty() && of_lines.is_empty() {
            return;
        }
        if self.colors.windows(2).any(|pair| pair[0] != pair[1]) {
            let what = if of_faces.is_empty() { "lines" } else { "faces" };
            self.warnings.push(format!(
                "colours of {what} are not used, since vertices have colours of their own"
            ));
            return;
        }
        for colors in [&mut of_faces, &mut of_lines] {
            let scale = Scale::of(colors.iter().map(|color| [color.x, color.y, color.z]));
            self.warnings.extend(scale.settle(colors));
        }
        self.color_vertices(&of_faces, &of_lines);
        // The new colours have not been checked.
        self.sound = false;
    }

    /// Gives these colours of faces and lines, or of the one kind that has some, to the vertices.
    pub(super) fn color_vertices(&mut self, of_faces: &[Vec4], of_lines: &[Vec4]) {
        let plain = self.colors.first().copied().unwrap_or(Vec4::ONE);
        let mut vertices = Vertices::new(self.positions.len(), plain);
        let corners = if self.faces.is_triangles() { 3 } else { 4 };
        let mut corner = 0;
        self.faces.for_each_vertex(|vertex| {
            let color = of_faces.get(corner / corners).copied().unwrap_or(plain);
            *vertex = vertices.colored(*vertex, color);
            corner += 1;
        });
        for (i, line) in self.lines.iter_mut().enumerate() {
            let color = of_lines.get(i).copied().unwrap_or(plain);
            *line = line.map(|vertex| vertices.colored(vertex, color));
        }
        if vertices.repeated.is_empty() {
            self.colors = vertices.colors;
            return;
        }
        let own = 0..self.positions.len() as u32;
        let sources: Vec<u32> = own.chain(vertices.repeated).collect();
        self.gather(&sources);
        self.colors = vertices.colors;
    }
}

/// Vertices with one colour each.
struct Vertices {
    colors: Vec<Vec4>,
    /// True for vertices whose colour is decided.
    taken: Vec<bool>,
    /// The vertices that additional ones repeat.
    repeated: Vec<u32>,
    /// The number of each additional vertex.
    numbers: HashMap<(u32, [u32; 4]), u32>,
}

impl Vertices {
    fn new(count: usize, color: Vec4) -> Self {
        Self {
            colors: vec![color; count],
            taken: vec![false; count],
            repeated: Vec::new(),
            numbers: HashMap::new(),
        }
    }

    /// Returns the number of the vertex, or of its copy, that has this colour.
    fn colored(&mut self, vertex: u32, color: Vec4) -> u32 {
        let i = vertex as usize;
        if !self.taken[i] {
            self.taken[i] = true;
            self.colors[i] = color;
        }
        if self.colors[i] == color {
            return vertex;
        }
        // More vertices than `u32` counts are refused later.
        let next = self.colors.len() as u32;
        let key = (vertex, color.to_array().map(f32::to_bits));
        let number = *self.numbers.entry(key).or_insert(next);
        if number == next {
            self.repeated.push(vertex);
            self.colors.push(color);
        }
        number
    }
}
