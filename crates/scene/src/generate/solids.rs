//! Rectangles, disks, cubes, spheres and cylinders of quads, with normals and texture coordinates.

use super::{
    STEPS, Unfit, count,
    grid::{Vertex, Winding, add_grid, surface},
    positive,
};
use crate::Shape;
use glam::{Vec2, Vec3};
use serde::Deserialize;
use std::f32::consts::{PI, TAU};

/// A rectangle in the plane of x and y that faces +z, or a floor: in the plane of x and z, facing
/// +y.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Rectangle {
    #[serde(default = "ones")]
    pub(super) steps: [u32; 2],
    /// Length of the sides in meters.
    pub(super) size: [f32; 2],
    /// Number of repetitions of a texture along a side.
    #[serde(default = "one")]
    pub(super) texture_scale: f32,
    #[serde(default)]
    pub(super) floor: bool,
}

fn ones() -> [u32; 2] {
    [1, 1]
}

fn one() -> f32 {
    1.0
}

impl Rectangle {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let [width, height] = self.size;
        positive("size", width.min(height))?;
        let steps = [count("steps", self.steps[0], STEPS)?, count("steps", self.steps[1], STEPS)?];
        let mut shape = surface();
        add_grid(&mut shape, steps, Winding::CounterClockwise, |uv| {
            let (x, y) = ((uv.x - 0.5) * width, (uv.y - 0.5) * height);
            let (position, normal) = if self.floor {
                (Vec3::new(x, 0.0, -y), Vec3::Y)
            } else {
                (Vec3::new(x, y, 0.0), Vec3::Z)
            };
            let texcoord = self.texture_scale * Vec2::new(uv.x, 1.0 - uv.y);
            Vertex { position, normal, texcoord }
        });
        Ok(shape)
    }
}

/// A disk in the plane of x and y, mapped from a grid over a square.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Disk {
    steps: u32,
    radius: f32,
}

impl Disk {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let radius = positive("radius", self.radius)?;
        let steps = count("steps", self.steps, STEPS)?;
        let mut shape = surface();
        add_grid(&mut shape, [steps, steps], Winding::CounterClockwise, |uv| {
            let square = 2.0 * uv - 1.0;
            // The elliptical map from square to disk, which preserves the axes and both diagonals.
            let across = (Vec2::ONE - 0.5 * square * square).map(f32::sqrt);
            Vertex {
                position: (radius * square * Vec2::new(across.y, across.x)).extend(0.0),
                normal: Vec3::Z,
                texcoord: flip(uv),
            }
        });
        Ok(shape)
    }
}

/// A cube with rounded edges and corners.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cube {
    /// Number of quads along each side.
    steps: u32,
    /// Length of a side in meters.
    size: f32,
    /// Radius of the edges, at most half a side.
    #[serde(default)]
    rounding: f32,
}

impl Cube {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let half = 0.5 * positive("size", self.size)?;
        let steps = count("steps", self.steps, STEPS)?;
        let rounding = rounding(self.rounding, half)?;
        Ok(cube_map(steps, |p, face| {
            if rounding == 0.0 {
                return (half * p, face);
            }
            let inner = Vec3::splat(half - rounding);
            let core = (half * p).clamp(-inner, inner);
            let normal = (half * p - core).normalize();
            (core + rounding * normal, normal)
        }))
    }
}

/// A sphere of quads: a cube whose vertices are projected onto the sphere.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct QuadSphere {
    /// Number of quads along each side of the cube.
    steps: u32,
    radius: f32,
}

impl QuadSphere {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let radius = positive("radius", self.radius)?;
        let steps = count("steps", self.steps, STEPS)?;
        Ok(cube_map(steps, |p, _| (radius * p.normalize(), p.normalize())))
    }
}

/// Builds a surface from the six faces of the cube from -1 to 1, in the order +z -z +x -x +y -y.
/// `vertex` maps a point of the cube and the normal of its face to a position and a normal.
fn cube_map(steps: u32, vertex: impl Fn(Vec3, Vec3) -> (Vec3, Vec3)) -> Shape {
    let mut shape = surface();
    // The directions of u, of v, and of the normal.
    let faces = [
        (Vec3::X, Vec3::Y, Vec3::Z),
        (Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z),
        (Vec3::NEG_Z, Vec3::Y, Vec3::X),
        (Vec3::Z, Vec3::Y, Vec3::NEG_X),
        (Vec3::X, Vec3::NEG_Z, Vec3::Y),
        (Vec3::X, Vec3::Z, Vec3::NEG_Y),
    ];
    for (right, up, out) in faces {
        add_grid(&mut shape, [steps, steps], Winding::CounterClockwise, |uv| {
            let square = 2.0 * uv - 1.0;
            let (position, normal) = vertex(right * square.x + up * square.y + out, out);
            Vertex { position, normal, texcoord: flip(uv) }
        });
    }
    shape
}

/// A sphere of meridians and parallels about the z axis.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct UvSphere {
    /// Number of quads around the axis, and from pole to pole.
    steps: [u32; 2],
    radius: f32,
    /// Height of the two caps, which are mirrored inwards.
    #[serde(default)]
    flipped_caps: f32,
}

impl UvSphere {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let radius = positive("radius", self.radius)?;
        let steps = [count("steps", self.steps[0], STEPS)?, count("steps", self.steps[1], STEPS)?];
        let caps = self.flipped_caps;
        if !(0.0..=radius).contains(&caps) {
            let expected = "between 0 and the radius";
            return Err(Unfit { parameter: "flipped_caps", value: caps.to_string(), expected });
        }
        let mut shape = surface();
        add_grid(&mut shape, steps, Winding::CounterClockwise, |uv| {
            // The bottom row of the image is at the pole +z.
            let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * uv.x).sin_cos(), (PI * uv.y).sin_cos());
            let mut normal = Vec3::new(cos_u * sin_v, sin_u * sin_v, cos_v);
            let mut position = radius * normal;
            let rim = radius - caps;
            if caps > 0.0 && position.z.abs() > rim {
                position.z = (2.0 * rim).copysign(position.z) - position.z;
                normal = Vec3::new(-normal.x, -normal.y, normal.z);
            }
            Vertex { position, normal, texcoord: flip(uv) }
        });
        Ok(shape)
    }
}

/// A cylinder about the z axis with rounded rims.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct UvCylinder {
    /// Number of quads around the axis, along the side, and from rim to centre.
    steps: [u32; 3],
    radius: f32,
    height: f32,
    #[serde(default)]
    rounding: f32,
}

impl UvCylinder {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let radius = positive("radius", self.radius)?;
        let half = 0.5 * positive("height", self.height)?;
        let rounding = rounding(self.rounding, radius.min(half))?;
        for steps in self.steps {
            count("steps", steps, STEPS)?;
        }
        let [around, along, inwards] = self.steps;
        // `outline` is a point on the cylinder without rounding: its distance from the axis, and
        // its height.
        let vertex = |uv: Vec2, outline: Vec2, face: Vec2| {
            let inner = Vec2::new(radius, half) - rounding;
            let core = outline.clamp(Vec2::new(0.0, -inner.y), inner);
            let (place, normal) = if rounding > 0.0 && outline != core {
                let normal = (outline - core).normalize();
                (core + rounding * normal, normal)
            } else {
                (outline, face)
            };
            let (sin, cos) = (TAU * uv.x).sin_cos();
            Vertex {
                position: Vec3::new(cos * place.x, sin * place.x, place.y),
                normal: Vec3::new(cos * normal.x, sin * normal.x, normal.y),
                texcoord: flip(uv),
            }
        };
        let mut shape = surface();
        add_grid(&mut shape, [around, along], Winding::Clockwise, |uv| {
            vertex(uv, Vec2::new(radius, half * (1.0 - 2.0 * uv.y)), Vec2::X)
        });
        add_grid(&mut shape, [around, inwards], Winding::CounterClockwise, |uv| {
            vertex(uv, Vec2::new(radius * (1.0 - uv.y), half), Vec2::Y)
        });
        add_grid(&mut shape, [around, inwards], Winding::Clockwise, |uv| {
            vertex(uv, Vec2::new(radius * (1.0 - uv.y), -half), Vec2::NEG_Y)
        });
        Ok(shape)
    }
}

fn rounding(rounding: f32, limit: f32) -> Result<f32, Unfit> {
    if (0.0..=limit).contains(&rounding) {
        return Ok(rounding);
    }
    let expected = "not negative and at most half of the smallest side";
    Err(Unfit { parameter: "rounding", value: rounding.to_string(), expected })
}

fn flip(uv: Vec2) -> Vec2 {
    Vec2::new(uv.x, 1.0 - uv.y)
}
