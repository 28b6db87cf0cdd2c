//! The corners of elements in an OBJ file: indices of a position, a texture coordinate and a
//! normal. Each distinct corner becomes a vertex.

use crate::load::{
    error::LoadProblem,
    mesh::{Mesh, not_named},
};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// Indices of a position, a texture coordinate and a normal, or [`NONE`].
type Corner = [u32; 3];

const NONE: u32 = u32::MAX;

/// What the indices of a corner name.
const WHAT: [&str; 3] = ["vertex", "texture coordinate", "normal"];

#[derive(Debug, Default)]
pub(super) struct Corners {
    /// The number of each distinct corner.
    numbers: HashMap<Corner, u32>,
    /// Each corner, with the first line that names it.
    corners: Vec<(Corner, usize)>,
}

impl Corners {
    /// Returns the number of the corner for a word such as `1`, `1/2`, `1//3` or `1/2/3`. Indices
    /// count from 1, or backwards from -1, the last of the `counts` so far. Those from 1 may name
    /// what follows later in the file.
    pub(super) fn number(
        &mut self,
        word: &str,
        counts: [usize; 3],
        line: usize,
    ) -> Result<u32, String> {
        let mut corner = [NONE; 3];
        for (i, part) in word.split('/').enumerate().take(3).filter(|(_, part)| !part.is_empty()) {
            let count = counts[i];
            let index = part.parse::<i64>().ok().and_then(|index| match index {
                ..0 => index.checked_add(count as i64),
                _ => index.checked_sub(1),
            });
            let index = index.and_then(|index| u32::try_from(index).ok());
            corner[i] = index.filter(|&index| index != NONE).ok_or_else(|| {
                format!("{word:?} names {} {part}, but there are {count} so far", WHAT[i])
            })?;
        }
        if corner[0] == NONE {
            return Err(format!("{word:?} names no vertex"));
        }
        let next = self.corners.len() as u32;
        let number = *self.numbers.entry(corner).or_insert(next);
        if number == next {
            self.corners.push((corner, line));
        }
        Ok(number)
    }

    /// Makes the corners the vertices of the mesh, if there are any; a missing normal or texture
    /// coordinate of some is zero.
    ///
    /// A vertex that does not exist is an error. A normal that does not exist is a warning, and
    /// none is used then, since versions of yocto-gl have written such files.
    pub(super) fn become_vertices(
        self,
        mesh: &mut Mesh,
        texcoords: &[Vec2],
        normals: &[Vec3],
    ) -> Result<(), LoadProblem> {
        if self.corners.is_empty() {
            return Ok(());
        }
        let counts = [mesh.positions.len(), texcoords.len(), normals.len()];
        let missing = |i: usize| {
            let exists =
                move |corner: &Corner| corner[i] == NONE || (corner[i] as usize) < counts[i];
            let lost = self.corners.iter().filter(move |(corner, _)| !exists(corner));
            let first = lost.clone().next().map(|&(corner, line)| {
                let (what, number, count) = (WHAT[i], u64::from(corner[i]) + 1, counts[i]);
                (line, format!("an element names {what} {number}, but there are {count}"))
            });
            first.map(|(line, problem)| (line, problem, lost.count()))
        };
        if let Some((line, problem, _)) = missing(0) {
            return Err(LoadProblem::ObjLine { line, problem });
        }
        if let Some((line, problem, count)) = missing(1) {
            mesh.warnings
                .push(format!("line {line}: {problem}; {count} corners are left without one"));
        }
        let no_normals = missing(2).map(|(line, problem, count)| {
            mesh.warnings.push(format!(
                "line {line}: {problem}; no normals are taken from the file, since {count} \
                 corners lack one"
            ));
        });
        let vertices: Vec<u32> = self.corners.iter().map(|(corner, _)| corner[0]).collect();
        mesh.warnings.extend(not_named(&mesh.positions, vertices.iter().copied()));
        mesh.gather(&vertices);
        mesh.texcoords = self.values(1, texcoords);
        mesh.normals = if no_normals.is_some() { Vec::new() } else { self.values(2, normals) };
        Ok(())
    }

    /// Returns the values of all corners, zero where there is none; nothing if no corner has one.
    fn values<T: Copy + Default>(&self, i: usize, values: &[T]) -> Vec<T> {
        let value = |corner: &Corner| values.get(corner[i] as usize).copied();
        if self.corners.iter().all(|(corner, _)| value(corner).is_none()) {
            return Vec::new();
        }
        self.corners.iter().map(|(corner, _)| value(corner).unwrap_or_default()).collect()
    }
}
