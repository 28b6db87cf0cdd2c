//! Rays for the unit tests of the exact evaluation, which integration tests cannot reach.

use glam::Vec3;

use crate::test_random::Random;
use crate::{Hit, Ray, leave_surface};

/// A ray from the point of a hit in any direction, half of them close to the tangent plane. It
/// steps off the surface by the error bound, by a tenth of it, or not at all.
pub(crate) fn spawned(random: &mut Random, hit: &Hit) -> Ray {
    let direction = random.in_cube() * random.power(3.0);
    let lift = hit.normal * hit.normal.dot(direction);
    let flat = random.signed() < 0.0;
    let direction =
        if flat { direction - lift * (1.0 - 0.01 * random.power(3.0)) } else { direction };
    let share = [1.0, 1.0, 0.1, 0.0][(random.bits() % 4) as usize];
    let origin = leave_surface(hit.position, share * hit.error, hit.normal, direction);
    let mut ray = Ray::new(origin, direction);
    if random.bits().is_multiple_of(5) {
        ray.t_min = random.power(2.0) * 1e-6 * random.signed();
    }
    ray
}

/// A ray from up to some ten sizes away to a point near `at`.
pub(crate) fn aimed(random: &mut Random, at: Vec3, size: f32) -> Ray {
    let origin = at + size * (10.0 * random.in_cube());
    Ray::new(origin, at + 0.5 * size * random.in_cube() - origin)
}
