//! Readers of streamlines, polylines through the directions of a diffusion image: TCK of MRtrix
//! and TRK of TrackVis.
//!
//! Both give lines without radii in millimeters, with x to the right, y to the front and z up of
//! the head. A vertex is coloured by the direction of its streamline, as is usual: red for left and
//! right, green for front and back, blue for up and down.

mod byte_order;
mod orientation;
pub(super) mod tck;
pub(super) mod trk;

use super::{error::LoadProblem, mesh::Mesh};
use crate::direction_color;
use glam::DVec3;

/// Collects the streamlines of a file.
#[derive(Debug, Default)]
struct Bundle {
    mesh: Mesh,
    /// Index of the first vertex of the streamline that is being read.
    start: usize,
    /// The number of complete streamlines.
    count: u64,
    /// How many of them have fewer than two points.
    short_count: u64,
}

impl Bundle {
    /// Adds a point to the streamline.
    fn push(&mut self, point: DVec3) -> Result<(), LoadProblem> {
        let position = point.as_vec3();
        if !position.is_finite() {
            let index = self.mesh.positions.len() - self.start;
            return Err(self.refuse(format!(
                "point {index} is {point}, expected finite coordinates; leave the streamline out"
            )));
        }
        self.mesh.positions.push(position);
        Ok(())
    }

    /// Ends the streamline. Those of fewer than two points are left out.
    fn end(&mut self) -> Result<(), LoadProblem> {
        self.count += 1;
        let vertices = self.mesh.positions.len();
        if vertices < self.start + 2 {
            self.short_count += 1;
            self.mesh.positions.truncate(self.start);
            return Ok(());
        }
        let limit = u64::from(u32::MAX);
        if vertices as u64 > limit {
            return Err(LoadProblem::TooMany { what: "points", count: vertices as u64, limit });
        }
        let last = vertices as u32 - 1;
        self.mesh.lines.extend((self.start as u32..last).map(|first| [first, first + 1]));
        self.mesh.colors.reserve(vertices - self.start);
        direction_color::append(&self.mesh.positions[self.start..], &mut self.mesh.colors);
        self.start = vertices;
        Ok(())
    }

    /// Returns the lines, with a warning if any streamlines were left out.
    fn finish(mut self) -> Mesh {
        if self.short_count > 0 {
            self.mesh.warnings.push(format!(
                "{} of {} streamlines have fewer than two points; left out",
                self.short_count, self.count
            ));
        }
        self.mesh
    }

    /// Returns the error for a problem of the streamline that is being read.
    fn refuse(&self, problem: String) -> LoadProblem {
        LoadProblem::Streamline { index: self.count, problem }
    }
}
