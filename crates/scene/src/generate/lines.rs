//! Grids of points and of lines in the plane of x and y.

use super::{STEPS, Unfit, count, grid::surface, positive};
use crate::{Elements, Shape};
use glam::{Vec2, Vec3};
use serde::Deserialize;

/// Points at the corners of a grid of squares.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PointsGrid {
    steps: [u32; 2],
    /// Length of the sides in meters.
    size: [f32; 2],
    /// Radius of each point in meters.
    radius: f32,
}

impl PointsGrid {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let [columns, rows] = self.steps;
        count("steps", columns.min(rows), STEPS)?;
        count("steps", columns.max(rows), STEPS)?;
        positive("size", self.size[0].min(self.size[1]))?;
        let radius = positive("radius", self.radius)?;
        let mut shape = surface();
        for j in 0..=rows {
            for i in 0..=columns {
                let uv = Vec2::new(i as f32 / columns as f32, j as f32 / rows as f32);
                shape.positions.push(((uv - 0.5) * Vec2::from(self.size)).extend(0.0));
                shape.normals.push(Vec3::Z);
                shape.texcoords.push(Vec2::new(uv.x, 1.0 - uv.y));
                shape.radii.push(radius);
            }
        }
        shape.elements = Elements::Points((columns + 1) * (rows + 1));
        Ok(shape)
    }
}

/// Horizontal lines, one above the other.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinesGrid {
    /// Segments of each line.
    steps: u32,
    lines: u32,
    /// Length of the sides in meters.
    size: [f32; 2],
    /// Radii at the left and the right end of each line in meters.
    radius: [f32; 2],
}

impl LinesGrid {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let steps = count("steps", self.steps, STEPS)?;
        let lines = count("lines", self.lines, STEPS)?;
        positive("size", self.size[0].min(self.size[1]))?;
        positive("radius", self.radius[0].min(self.radius[1]))?;
        let mut shape = surface();
        let mut segments = Vec::new();
        for j in 0..lines {
            let v = if lines > 1 { j as f32 / (lines - 1) as f32 } else { 0.5 };
            for i in 0..=steps {
                let uv = Vec2::new(i as f32 / steps as f32, v);
                if i < steps {
                    let vertex = shape.positions.len() as u32;
                    segments.push([vertex, vertex + 1]);
                }
                shape.positions.push(((uv - 0.5) * Vec2::from(self.size)).extend(0.0));
                shape.normals.push(Vec3::X);
                shape.texcoords.push(uv);
                shape.radii.push(self.radius[0] + uv.x * (self.radius[1] - self.radius[0]));
            }
        }
        shape.elements = Elements::Lines(segments);
        Ok(shape)
    }
}
