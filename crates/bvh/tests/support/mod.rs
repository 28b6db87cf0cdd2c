//! Random primitives, balls in double precision, the loop over all of them, and seeded random
//! numbers.
#![allow(dead_code, unused_imports, reason = "each test file uses a part of it")]

mod primitives;
#[path = "../../../geometry/src/test_random.rs"]
mod test_random;

use glam::{DVec3, Vec3};
pub(crate) use primitives::{cones, patches, spheres, triangles};
use rotund_bvh::Bvh;
use rotund_geometry::{Aabb, Ray};
pub(crate) use test_random::Random;

/// A ball whose box is rounded outwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
}

impl Ball {
    pub(crate) fn bounds(&self) -> Aabb {
        Aabb {
            min: (self.center - self.radius).map(f32::next_down),
            max: (self.center + self.radius).map(f32::next_up),
        }
    }

    pub(crate) fn closest(&self, ray: &Ray) -> Option<f32> {
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (c, r) = (self.center.as_dvec3(), f64::from(self.radius));
        let to_center = c - o;
        let t = to_center.dot(d) / d.length_squared();
        let perpendicular: DVec3 = to_center - t * d;
        let half = ((r * r - perpendicular.length_squared()) / d.length_squared()).sqrt();
        [t - half, t + half]
            .into_iter()
            .map(|t| t as f32)
            .find(|&t| t >= ray.t_min && t <= ray.t_max)
    }
}

/// The answer by definition: the lowest id among the smallest `t`.
pub(crate) fn loop_over(balls: &[Ball], ray: &Ray) -> Option<(u32, f32)> {
    let mut best: Option<(u32, f32)> = None;
    for (id, ball) in balls.iter().enumerate() {
        if let Some(t) = ball.closest(ray)
            && best.is_none_or(|(_, best)| t < best)
        {
            best = Some((id as u32, t));
        }
    }
    best
}

pub(crate) fn boxes(balls: &[Ball]) -> Vec<Aabb> {
    balls.iter().map(Ball::bounds).collect()
}

pub(crate) fn ask(bvh: &Bvh, balls: &[Ball], ray: &Ray) -> Option<(u32, f32)> {
    bvh.closest(ray, |id, ray| Some((balls[id as usize].closest(ray)?, ())))
        .map(|found| (found.id, found.t))
}

pub(crate) fn ask_any(bvh: &Bvh, balls: &[Ball], ray: &Ray) -> bool {
    bvh.any(ray, |id, ray| balls[id as usize].closest(ray).is_some())
}
