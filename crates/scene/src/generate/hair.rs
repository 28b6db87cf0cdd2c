//! Hair on a surface of quads.

use super::{Geometry, STEPS, STRANDS, Unfit, count, grid::surface, noise::vector_noise, positive};
use crate::{Elements, Shape};
use glam::{Vec2, Vec3};
use serde::Deserialize;

/// Strands along the normals of another shape, evenly distributed over it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hair {
    /// The surface with the roots: any generated surface.
    on: Box<Geometry>,
    strands: u32,
    /// Segments of each strand.
    steps: u32,
    /// Length of each strand in meters.
    length: f32,
    /// Radii at the root and at the tip in meters.
    radius: [f32; 2],
    /// Amplitude of the displacement of tips in meters, and frequency of the noise per meter.
    #[serde(default)]
    noise: [f32; 2],
    /// Weight with which tips move to the nearest of the leading strands, `0.0..=1.0`, and their
    /// number.
    #[serde(default)]
    clump: Clump,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Clump {
    strength: f32,
    strands: u32,
}

/// The root of a strand.
#[derive(Clone, Copy)]
struct Root {
    position: Vec3,
    normal: Vec3,
}

impl Hair {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let length = positive("length", self.length)?;
        let steps = count("steps", self.steps, STEPS)?;
        let strands = count("strands", self.strands, STRANDS / steps)?;
        positive("radius", self.radius[0].min(self.radius[1]))?;
        let roots = scatter(&self.on.build()?, strands)?;
        // The first strands lead the clumps, since any prefix of the sequence is evenly
        // distributed.
        let clumps = if self.clump.strength > 0.0 {
            // Each strand searches all of them.
            count("clump.strands", self.clump.strands, strands.min(STEPS))? as usize
        } else {
            0
        };
        let mut shape = surface();
        let mut segments = Vec::with_capacity(strands as usize * steps as usize);
        for (index, root) in roots.iter().enumerate() {
            let leader = roots[..clumps].iter().min_by(|a, b| {
                let distance = |r: &Root| r.position.distance_squared(root.position);
                distance(a).total_cmp(&distance(b))
            });
            let first = shape.positions.len();
            for step in 0..=steps {
                let t = step as f32 / steps as f32;
                let along = |root: &Root| root.position + t * length * root.normal;
                let mut position = along(root);
                position += t * self.noise[0] * vector_noise(self.noise[1] * position);
                if let Some(leader) = leader {
                    position += t * self.clump.strength * (along(leader) - position);
                }
                shape.positions.push(position);
                shape.texcoords.push(Vec2::new(t, index as f32 / strands as f32));
                shape.radii.push(self.radius[0] + t * (self.radius[1] - self.radius[0]));
                if step < steps {
                    let vertex = (first as u32) + step;
                    segments.push([vertex, vertex + 1]);
                }
            }
            let strand = &shape.positions[first..];
            let last = strand.len() - 1;
            let tangent = |i: usize| {
                (strand[(i + 1).min(last)] - strand[i.saturating_sub(1)]).normalize_or_zero()
            };
            shape.normals.extend((0..=last).map(tangent));
        }
        shape.elements = Elements::Lines(segments);
        Ok(shape)
    }
}

/// Distributes roots evenly over the area of a surface of quads: points of Roberts' sequence in
/// three dimensions select a quad in proportion to its area, and a point in it.
///
/// Source: M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
fn scatter(shape: &Shape, points: u32) -> Result<Vec<Root>, Unfit> {
    let Elements::Quads(quads) = &shape.elements else {
        let (value, expected) = ("not a surface".to_owned(), "a generator of a surface");
        return Err(Unfit { parameter: "on", value, expected });
    };
    let mut total = 0.0;
    let areas: Vec<f64> = quads
        .iter()
        .map(|quad| {
            let [a, b, c, d] = quad.map(|vertex| shape.positions[vertex as usize].as_dvec3());
            total += 0.5 * (c - a).cross(d - b).length();
            total
        })
        .collect();
    // The real root of x^4 = x + 1.
    const BASE: f64 = 1.220_744_084_605_759_5;
    let fraction = |i: u32, power: i32| (0.5 + f64::from(i) * BASE.powi(-power)).fract();
    let root = |i: u32| {
        let share = fraction(i, 1) * total;
        let chosen = areas.partition_point(|area| *area < share).min(quads.len() - 1);
        let (u, v) = (fraction(i, 2) as f32, fraction(i, 3) as f32);
        let at = |array: &[Vec3]| {
            let [a, b, c, d] = quads[chosen].map(|vertex| array[vertex as usize]);
            (a * (1.0 - u) + b * u) * (1.0 - v) + (d * (1.0 - u) + c * u) * v
        };
        Root { position: at(&shape.positions), normal: at(&shape.normals).normalize_or(Vec3::Y) }
    };
    Ok((0..points).map(root).collect())
}
