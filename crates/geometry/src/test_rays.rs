//! Rays for the tests of what cannot be reached from outside.

use crate::{Hit, Ray, leave_surface};
use glam::Vec3;

/// xorshift: numbers in -1..1, the same in each run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn number(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 40) as f32) / (1_u32 << 23) as f32 - 1.0
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// A power of ten, of up to so many decades up or down.
    pub(crate) fn power(&mut self, decades: f32) -> f32 {
        10_f32.powf(decades * self.number())
    }
}

/// A ray from the point of a hit, in any direction, half of them near to the tangent plane, from the bound of
/// the error, a share of it, or not at all.
pub(crate) fn spawned(random: &mut Random, hit: &Hit) -> Ray {
    let direction = random.point() * random.power(3.0);
    let lift = hit.normal * hit.normal.dot(direction);
    let flat = random.number() < 0.0;
    let direction =
        if flat { direction - lift * (1.0 - 0.01 * random.power(3.0)) } else { direction };
    let share = [1.0, 1.0, 0.1, 0.0][(random.0 % 4) as usize];
    let origin = leave_surface(hit.position, share * hit.error, hit.normal, direction);
    let mut ray = Ray::new(origin, direction);
    if random.0.is_multiple_of(5) {
        ray.t_min = random.power(2.0) * 1e-6 * random.number();
    }
    ray
}

/// A ray from some ten sizes away.
pub(crate) fn aimed(random: &mut Random, at: Vec3, size: f32) -> Ray {
    let origin = at + size * (10.0 * random.point());
    Ray::new(origin, at + 0.5 * size * random.point() - origin)
}
