//! Generators: shapes and textures given by parameters instead of a file.
//!
//! In a scene file, `"generator": { "disk": { "steps": 32, "radius": 0.075 } }` replaces `"uri"`.
//! Vertices and texture coordinates are laid out as in the shapes of yocto-gl's test scenes, so
//! that these scenes need no shape files.

mod branches;
mod bundle;
mod grid;
mod hair;
mod image;
mod lines;
mod noise;
mod solids;

pub(crate) use branches::Branches;
pub(crate) use bundle::Bundle;
pub(crate) use hair::Hair;
pub(crate) use image::{Bumps, FloorGrid, Sky, UvGrid};
pub(crate) use lines::{LinesGrid, PointsGrid};
pub(crate) use solids::{Cube, Disk, QuadSphere, Rectangle, UvCylinder, UvSphere};

use crate::{Shape, Texture};
use serde::Deserialize;

/// A shape, centred on the origin.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Geometry {
    Rectangle(Rectangle),
    Disk(Disk),
    Cube(Cube),
    QuadSphere(QuadSphere),
    UvSphere(UvSphere),
    UvCylinder(UvCylinder),
    PointsGrid(PointsGrid),
    LinesGrid(LinesGrid),
    Hair(Hair),
    Branches(Branches),
    Bundle(Bundle),
}

/// A texture.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Image {
    UvGrid(UvGrid),
    FloorGrid(FloorGrid),
    Bumps(Bumps),
    Sky(Sky),
}

/// A parameter that is out of range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Unfit {
    pub parameter: &'static str,
    pub value: String,
    pub expected: &'static str,
}

impl Geometry {
    /// Returns a square floor whose texture repeats `texture_scale` times along a side.
    pub(crate) fn floor(side: f32, texture_scale: f32) -> Self {
        Self::Rectangle(Rectangle { steps: [1, 1], size: [side, side], texture_scale, floor: true })
    }

    pub(crate) fn build(&self) -> Result<Shape, Unfit> {
        match self {
            Self::Rectangle(rectangle) => rectangle.build(),
            Self::Disk(disk) => disk.build(),
            Self::Cube(cube) => cube.build(),
            Self::QuadSphere(sphere) => sphere.build(),
            Self::UvSphere(sphere) => sphere.build(),
            Self::UvCylinder(cylinder) => cylinder.build(),
            Self::PointsGrid(points) => points.build(),
            Self::LinesGrid(lines) => lines.build(),
            Self::Hair(hair) => hair.build(),
            Self::Branches(branches) => branches.build(),
            Self::Bundle(bundle) => bundle.build(),
        }
    }
}

impl Image {
    pub(crate) fn clear_sky() -> Self {
        let sky =
            Sky { width: 512, sun_elevation_degrees: 45.0, turbidity: 3.0, ground_albedo: 0.4 };
        Self::Sky(sky)
    }

    pub(crate) fn floor_grid() -> Self {
        Self::FloorGrid(FloorGrid { size: 1024 })
    }

    pub(crate) fn build(&self) -> Result<Texture, Unfit> {
        match self {
            Self::UvGrid(grid) => grid.build(),
            Self::FloorGrid(grid) => grid.build(),
            Self::Bumps(bumps) => bumps.build(),
            Self::Sky(sky) => sky.build(),
        }
    }
}

/// Checks a length, which must be positive and finite.
fn positive(parameter: &'static str, value: f32) -> Result<f32, Unfit> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Unfit { parameter, value: value.to_string(), expected: "a positive number" })
}

/// Checks a count, which must be at least one and not so large that memory is exhausted.
fn count(parameter: &'static str, value: u32, limit: u32) -> Result<u32, Unfit> {
    if (1..=limit).contains(&value) {
        return Ok(value);
    }
    let expected = match limit {
        STEPS => "between 1 and 4096",
        _ => "between 1 and 16777216",
    };
    Err(Unfit { parameter, value: value.to_string(), expected })
}

/// The most steps along a side.
const STEPS: u32 = 4096;

/// The most strands of hair.
const STRANDS: u32 = 1 << 24;
