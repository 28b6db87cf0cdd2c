//! Checks of a mesh after reading: what refers to nothing is an error, and what is merely bad is
//! left out and counted.

use super::{FaceElements, Mesh, polygons};
use crate::{
    load::error::LoadProblem,
    validate::{first_outside, is_color, is_radius},
};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::collections::HashSet;

impl Mesh {
    /// Makes the mesh valid, with warnings about what is left out or replaced.
    ///
    /// # Errors
    ///
    /// If an element names a vertex that does not exist, or if nothing is left.
    pub(crate) fn settle(&mut self) -> Result<(), LoadProblem> {
        self.check_count()?;
        self.settle_short_faces();
        let count = self.positions.len();
        if let Some((index, vertex)) = self.faces.first_outside(count) {
            return Err(outside("face", index, vertex, count));
        }
        self.check_lines_and_points()?;
        self.warn_of_vertices_not_named();
        self.color_by_elements();
        let left = polygons::divide(&mut self.faces, &self.positions);
        if left > 0 {
            self.warnings.push(format!(
                "{left} concave polygons have more than {} corners; drawn as if they were convex",
                polygons::MOST_CORNERS
            ));
        }
        if !self.sound {
            self.replace_values();
            self.leave_out_bad_vertices()?;
        }
        self.check_count()?;
        if self.positions.is_empty() { Err(LoadProblem::EmptyShape) } else { Ok(()) }
    }

    /// Refuses lines and points of vertices that do not exist.
    pub(crate) fn check_lines_and_points(&self) -> Result<(), LoadProblem> {
        let count = self.positions.len();
        check_indices("line", &self.lines, count)?;
        check_indices("point", self.points.as_chunks::<1>().0, count)
    }

    fn warn_of_vertices_not_named(&mut self) {
        if self.faces.is_empty() && self.lines.is_empty() && self.points.is_empty() {
            return;
        }
        let of_faces = match &self.faces.elements {
            FaceElements::Triangles(triangles) => triangles.as_flattened(),
            FaceElements::Quads(quads) => quads.as_flattened(),
        };
        let others = self.lines.as_flattened().iter().chain(&self.points);
        let named = of_faces.iter().chain(others).copied();
        self.warnings.extend(not_named(&self.positions, named));
    }

    fn check_count(&self) -> Result<(), LoadProblem> {
        let (count, limit) = (self.positions.len() as u64, u64::from(u32::MAX));
        if count > limit {
            return Err(LoadProblem::TooMany { what: "vertices", count, limit });
        }
        Ok(())
    }

    /// Takes faces of two vertices for lines if there are no others, as some programs write edges.
    fn settle_short_faces(&mut self) {
        let mut pairs = std::mem::take(&mut self.faces.pairs);
        let short = std::mem::take(&mut self.faces.short_count);
        let left_out = if self.faces.is_empty() {
            self.lines.append(&mut pairs);
            short
        } else {
            short + pairs.len()
        };
        if left_out > 0 {
            self.warnings
                .push(format!("{left_out} faces have fewer than three vertices; left out"));
        }
    }

    /// Replaces normals, texture coordinates and colours that make no sense.
    fn replace_values(&mut self) {
        // Real files have a few of these where a mesh degenerates. Zero stands for no normal.
        let normals = self.normals.par_iter_mut().filter(|normal| !normal.is_finite());
        let texcoords = self.texcoords.par_iter_mut().filter(|texcoord| !texcoord.is_finite());
        let mended = normals.map(|normal| *normal = Vec3::ZERO).count()
            + texcoords.map(|texcoord| *texcoord = Vec2::ZERO).count();
        if mended > 0 {
            self.warnings.push(format!(
                "{mended} normals or texture coordinates are not finite; taken as zero"
            ));
        }
        let colors = self.colors.par_iter_mut().filter(|color| !is_color(color));
        let sensible = |c: f32| if c.is_finite() { c.max(0.0) } else { 0.0 };
        let mended = colors.map(|color| *color = color.to_array().map(sensible).into()).count();
        if mended > 0 {
            self.warnings.push(format!(
                "{mended} colours have channels that are negative or not finite; taken as zero"
            ));
        }
    }

    /// Leaves out vertices whose position is not finite or whose radius is none, with the elements
    /// that name them.
    fn leave_out_bad_vertices(&mut self) -> Result<(), LoadProblem> {
        let count = self.positions.len();
        let is_bad = |i: usize| {
            !self.positions[i].is_finite() || self.radii.get(i).is_some_and(|r| !is_radius(r))
        };
        let kept: Vec<bool> = (0..count).into_par_iter().map(|i| !is_bad(i)).collect();
        let missing = self.positions.par_iter().filter(|p| !p.is_finite()).count();
        let without_radius = kept.par_iter().filter(|kept| !**kept).count() - missing;
        if missing + without_radius == 0 {
            return Ok(());
        }
        if missing + without_radius == count {
            return Err(self.nothing_is_good(0));
        }
        let stays = |vertex: &u32| kept[*vertex as usize];
        let before = self.lines.len() + self.points.len();
        self.lines.retain(|line| line.iter().all(stays));
        self.points.retain(stays);
        let gone = before - self.lines.len() - self.points.len() + self.faces.retain(&kept);
        let elements = match gone {
            0 => String::new(),
            gone => format!(", with {gone} elements between them"),
        };
        let mut warn = |number, what| {
            if number > 0 {
                self.warnings
                    .push(format!("{number} of {count} vertices have {what}; left out{elements}"));
            }
        };
        warn(missing, "coordinates that are not finite");
        warn(without_radius, "a radius that is negative or not finite");
        let mut numbers = vec![0; count];
        let vertices: Vec<u32> = (0..count as u32).filter(stays).collect();
        for (number, &vertex) in (0..).zip(&vertices) {
            numbers[vertex as usize] = number;
        }
        let first_bad = kept.iter().position(|kept| !kept);
        if let Some(bad) = first_bad
            && gone > 0
            && self.faces.is_empty()
            && self.lines.is_empty()
            && self.points.is_empty()
        {
            return Err(self.nothing_is_good(bad));
        }
        self.gather(&vertices);
        self.faces.for_each_vertex(|vertex| *vertex = numbers[*vertex as usize]);
        let ends = self.lines.as_flattened_mut().iter_mut();
        ends.chain(&mut self.points).for_each(|vertex| *vertex = numbers[*vertex as usize]);
        Ok(())
    }

    /// Returns the error for a vertex of a file without any element that is good.
    fn nothing_is_good(&self, vertex: usize) -> LoadProblem {
        let radius = self.radii.get(vertex).filter(|_| self.positions[vertex].is_finite());
        let (property, value, expected) = match radius {
            Some(radius) => ("radius", radius.to_string(), "a finite number that is not negative"),
            None => {
                let position = self.positions[vertex].to_string();
                ("position", position, "finite coordinates")
            }
        };
        LoadProblem::ElementValue {
            element: "vertex".to_owned(),
            index: vertex as u64,
            property: property.to_owned(),
            value,
            expected,
        }
    }
}

/// Returns the warning about vertices that no element names. Those at the place of one that is
/// named do not count: spheres have them at their poles.
pub(crate) fn not_named(positions: &[Vec3], named: impl Iterator<Item = u32>) -> Option<String> {
    let count = positions.len();
    let mut is_named = vec![false; count];
    named.for_each(|vertex| is_named[vertex as usize] = true);
    let unnamed: Vec<usize> = (0..count).filter(|&vertex| !is_named[vertex]).collect();
    if unnamed.is_empty() {
        return None;
    }
    let place = |vertex: usize| positions[vertex].to_array().map(f32::to_bits);
    let mut places: HashSet<_> = unnamed.iter().map(|&vertex| place(vertex)).collect();
    for vertex in (0..count).filter(|&vertex| is_named[vertex]) {
        places.remove(&place(vertex));
    }
    let left = unnamed.iter().filter(|&&vertex| places.contains(&place(vertex))).count();
    (left > 0)
        .then(|| format!("{left} of {count} vertices belong to no element; they are not drawn"))
}

fn check_indices<const N: usize>(
    element: &str,
    elements: &[[u32; N]],
    count: usize,
) -> Result<(), LoadProblem> {
    match first_outside(elements, count) {
        None => Ok(()),
        Some((index, vertex)) => Err(outside(element, index, vertex, count)),
    }
}

fn outside(element: &str, index: usize, vertex: u32, count: usize) -> LoadProblem {
    LoadProblem::VertexOutOfRange {
        element: element.to_owned(),
        index: index as u64,
        vertex: i64::from(vertex),
        count,
    }
}
