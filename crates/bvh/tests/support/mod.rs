//! Balls in double precision, seeded random numbers, and the loop over all primitives.
#![allow(dead_code, reason = "each test file uses a part of it")]

use glam::{DVec3, Vec3};
use rotund_bvh::Bvh;
use rotund_geometry::{Aabb, Ray};

/// SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 * 2f32.powi(-24)
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    /// A point of the cube `-1..1`.
    pub(crate) fn point(&mut self) -> Vec3 {
        2.0 * Vec3::new(self.unit(), self.unit(), self.unit()) - 1.0
    }
}

/// A ball whose box is drawn around it with care.
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
        let beside: DVec3 = to_center - t * d;
        let half = ((r * r - beside.length_squared()) / d.length_squared()).sqrt();
        [t - half, t + half]
            .into_iter()
            .map(|t| t as f32)
            .find(|&t| t >= ray.t_min && t <= ray.t_max)
    }
}

/// The answer by definition.
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
