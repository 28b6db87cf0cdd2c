//! Branching trees of tubes: vessels and neurites.

use super::noise::{hash, share, unit_vector};
use super::{STEPS, Unfit, count, positive};
use crate::{Elements, Shape};
use glam::{Quat, Vec3};
use serde::Deserialize;
use std::f32::consts::PI;

/// Lines that share vertices at forks, from a root at the origin.
///
/// At a fork a branch of radius `r` splits into two of radii `a` and `b` with
/// `a^k + b^k = r^k`, where `k` is `exponent`. It is 3 for vessels and 1.5 for dendrites.
///
/// Source: C. D. Murray, "The Physiological Principle of Minimum Work", Proc. Natl. Acad. Sci. 12,
/// 1926; W. Rall, "Branching dendritic trees and motoneuron membrane resistivity", Exp. Neurol. 1,
/// 1959.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Branches {
    /// Branches that leave the root: one grows along y, several in all directions.
    stems: u32,
    /// Radius of the ball at the root in meters; that of the stems if it is left out.
    root_radius: Option<f32>,
    /// Radius of the stems in meters.
    radius: f32,
    /// Radius in meters below which a branch does not split.
    tip_radius: f32,
    exponent: f32,
    /// Length of a branch from fork to fork, in radii of it.
    length: f32,
    /// Segments of each branch.
    steps: u32,
    /// Angle between the two branches of a fork in degrees.
    angle: f32,
    /// How much a branch turns at each vertex: 0 is straight, 1 a right angle or more.
    #[serde(default)]
    bend: f32,
    /// Factor on all radii of the finished tree, for what is inside a wall.
    #[serde(default = "one")]
    thickness: f32,
    #[serde(default)]
    seed: u32,
}

fn one() -> f32 {
    1.0
}

/// A branch that has not grown yet.
struct Bud {
    /// Its first vertex, which it shares.
    vertex: u32,
    direction: Vec3,
    radius: f32,
    /// Decides its shape and that of all branches behind it.
    key: u32,
}

/// The most segments of a tree.
const MAX_SEGMENTS: usize = 1 << 20;

/// The smallest ratio of the radii of two branches of a fork.
const MIN_RATIO: f32 = 0.55;

impl Branches {
    pub(super) fn build(&self) -> Result<Shape, Unfit> {
        let stems = count("stems", self.stems, STEPS)?;
        let steps = count("steps", self.steps, STEPS)?;
        let radius = positive("radius", self.radius)?;
        let tip_radius = positive("tip_radius", self.tip_radius)?;
        positive("exponent", self.exponent)?;
        positive("length", self.length)?;
        positive("thickness", self.thickness)?;
        let root_radius = positive("root_radius", self.root_radius.unwrap_or(radius))?;
        let mut shape =
            Shape { positions: vec![Vec3::ZERO], radii: vec![root_radius], ..Shape::default() };
        let mut segments = Vec::new();
        let mut buds: Vec<Bud> = (0..stems)
            .map(|stem| Bud {
                vertex: 0,
                direction: if stems == 1 { Vec3::Y } else { spread(stem, stems) },
                radius,
                key: hash([self.seed, stem, 0]),
            })
            .collect();
        while let Some(bud) = buds.pop() {
            let (vertex, direction) = self.grow(&bud, steps, &mut shape, &mut segments);
            if segments.len() > MAX_SEGMENTS {
                let (parameter, value) = ("tip_radius", tip_radius.to_string());
                let expected = "a radius at which the tree has at most 1048576 segments";
                return Err(Unfit { parameter, value, expected });
            }
            if bud.radius > tip_radius {
                buds.extend(self.fork(&bud, vertex, direction));
            }
        }
        shape.radii.iter_mut().for_each(|radius| *radius *= self.thickness);
        shape.elements = Elements::Lines(segments);
        Ok(shape)
    }

    /// Adds the vertices of a branch, and returns the last one and its direction.
    fn grow(
        &self,
        bud: &Bud,
        steps: u32,
        shape: &mut Shape,
        segments: &mut Vec<[u32; 2]>,
    ) -> (u32, Vec3) {
        let step_length = self.length * bud.radius / steps as f32;
        let (mut vertex, mut direction) = (bud.vertex, bud.direction);
        for step in 0..steps {
            let next = shape.positions.len() as u32;
            shape.positions.push(shape.positions[vertex as usize] + step_length * direction);
            shape.radii.push(bud.radius);
            segments.push([vertex, next]);
            vertex = next;
            let turn = self.bend * unit_vector([bud.key, step, 1]);
            direction = (direction + turn).try_normalize().unwrap_or(direction);
        }
        (vertex, direction)
    }

    /// Returns the two branches of a fork. The thinner one turns more.
    fn fork(&self, bud: &Bud, vertex: u32, direction: Vec3) -> [Bud; 2] {
        let ratio = MIN_RATIO + (1.0 - MIN_RATIO) * share([bud.key, 0, 2]) as f32;
        let thick = bud.radius * (1.0 + ratio.powf(self.exponent)).powf(-1.0 / self.exponent);
        let axis = direction.cross(unit_vector([bud.key, 1, 2]));
        let axis = axis.try_normalize().unwrap_or_else(|| direction.any_orthonormal_vector());
        let angle = self.angle.to_radians();
        let turn = angle * ratio * ratio / (1.0 + ratio * ratio);
        let branch = |radius, turn, side| Bud {
            vertex,
            direction: Quat::from_axis_angle(axis, turn) * direction,
            radius,
            key: hash([bud.key, side, 3]),
        };
        [branch(thick, turn, 0), branch(ratio * thick, turn - angle, 1)]
    }
}

/// Returns one of `count` directions that are evenly distributed, on a spiral.
///
/// Source: R. Swinbank and R. J. Purser, "Fibonacci grids", Q. J. R. Meteorol. Soc. 132, 2006.
fn spread(index: u32, count: u32) -> Vec3 {
    let z = 1.0 - (2 * index + 1) as f32 / count as f32;
    let angle = PI * (3.0 - 5f32.sqrt()) * index as f32;
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * angle.cos(), z, r * angle.sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    const VESSELS: Branches = Branches {
        stems: 1,
        root_radius: None,
        radius: 0.01,
        tip_radius: 0.002,
        exponent: 3.0,
        length: 8.0,
        steps: 4,
        angle: 75.0,
        bend: 0.2,
        thickness: 1.0,
        seed: 1,
    };

    fn lines(shape: &Shape) -> &[[u32; 2]] {
        let Elements::Lines(lines) = &shape.elements else { panic!("lines") };
        lines
    }

    #[test]
    fn radii_at_each_fork_follow_the_law() {
        for exponent in [1.5, 3.0] {
            let tree = Branches { exponent, ..VESSELS }.build().expect("a tree");
            let mut forks = 0;
            for vertex in 0..tree.positions.len() as u32 {
                let next: Vec<u32> =
                    lines(&tree).iter().filter(|line| line[0] == vertex).map(|l| l[1]).collect();
                assert!(next.len() <= 2, "a fork has two branches");
                if let [a, b] = next[..] {
                    let power = |v: u32| tree.radii[v as usize].powf(exponent);
                    let sum = (power(a) + power(b)) / power(vertex);
                    assert!((sum - 1.0).abs() < 1e-5, "{sum}");
                    forks += 1;
                }
            }
            assert!(forks > 5, "{forks} forks");
        }
    }

    #[test]
    fn every_vertex_but_the_root_ends_one_segment() {
        let tree =
            Branches { stems: 5, root_radius: Some(0.03), ..VESSELS }.build().expect("a tree");
        let mut ends = vec![0; tree.positions.len()];
        lines(&tree).iter().for_each(|line| ends[line[1] as usize] += 1);
        assert_eq!(ends[0], 0);
        assert!(ends[1..].iter().all(|&count| count == 1));
        assert_eq!(lines(&tree).iter().filter(|line| line[0] == 0).count(), 5);
        assert_eq!(tree.radii[0], 0.03);
    }

    #[test]
    fn thickness_scales_radii_alone() {
        let wall = VESSELS.build().expect("a tree");
        let lumen = Branches { thickness: 0.5, ..VESSELS }.build().expect("a tree");
        assert_eq!(wall.positions, lumen.positions);
        assert!(wall.radii.iter().zip(&lumen.radii).all(|(wall, lumen)| 0.5 * wall == *lumen));
    }

    #[test]
    fn a_tree_that_would_not_end_is_refused() {
        let endless = Branches { exponent: 1e6, tip_radius: 1e-6, steps: 64, ..VESSELS };
        assert_eq!(endless.build().expect_err("too many segments").parameter, "tip_radius");
        for (parameter, tree) in [
            ("stems", Branches { stems: 0, ..VESSELS }),
            ("radius", Branches { radius: f32::NAN, ..VESSELS }),
            ("tip_radius", Branches { tip_radius: 0.0, ..VESSELS }),
            ("exponent", Branches { exponent: -3.0, ..VESSELS }),
            ("length", Branches { length: f32::INFINITY, ..VESSELS }),
            ("root_radius", Branches { root_radius: Some(-1.0), ..VESSELS }),
        ] {
            assert_eq!(tree.build().expect_err(parameter).parameter, parameter);
        }
    }
}
