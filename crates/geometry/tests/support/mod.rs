//! Shared by the integration tests: seeded random numbers, and double-double arithmetic.
#![allow(dead_code, unused_imports, reason = "each test file uses a part")]

#[path = "../../src/test_random.rs"]
mod random;
mod wide;

use rotund_geometry::Ray;
use rotund_geometry::glam::{DVec3, Vec3};

pub(crate) use random::Random;
pub(crate) use wide::{Wide, Wide3};

pub(crate) fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray::new(origin.as_vec3(), direction.as_vec3())
}

pub(crate) fn wide(p: Vec3) -> Wide3 {
    p.into()
}

/// Returns the point of a ray at an exact `t`.
pub(crate) fn at(ray: &Ray, t: Wide) -> Wide3 {
    wide(ray.origin) + wide(ray.direction) * t
}

/// Returns the smallest and the largest real that round to `t`, slightly widened.
pub(crate) fn rounding_interval(t: f32) -> [Wide; 2] {
    let (t, below, above) = (f64::from(t), f64::from(t.next_down()), f64::from(t.next_up()));
    let slack = 1e-12 * (above - below);
    [Wide::from(0.5 * (t + below) - slack), Wide::from(0.5 * (t + above) + slack)]
}

/// Returns `2⁻²⁴` times the larger of the length of `p` and `size`.
pub(crate) fn local_unit(p: Vec3, size: f32) -> f64 {
    f64::from(p.length().max(size)) * 2.0_f64.powi(-24)
}

/// Returns the angle in degrees between a rounded normal and an exact direction of any length.
pub(crate) fn degrees(normal: Vec3, exact: DVec3) -> f64 {
    let n = normal.as_dvec3();
    n.cross(exact).length().atan2(n.dot(exact)).to_degrees()
}
