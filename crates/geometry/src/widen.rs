//! Conversion of `f32` to `f64`, two numbers at a time.
//!
//! The conversion is exact; pairs are faster. On x86-64 the scalar conversion keeps the upper half
//! of its target register, a false dependency on the instruction that wrote the register last. In a
//! small function that is called in a loop this is the end of the previous call, and a sphere takes
//! twice as long. The packed conversion has no such dependency.

use glam::{DVec3, Vec3};

use crate::Ray;
use crate::f64x2::F64x2;

#[inline(always)]
fn pair(x: f32, y: f32) -> [f64; 2] {
    F64x2::widen(x, y).to_array()
}

/// Widens a point and its radius.
#[inline(always)]
pub(crate) fn ball(p: Vec3, r: f32) -> (DVec3, f64) {
    let ([x, y], [z, r]) = (pair(p.x, p.y), pair(p.z, r));
    (DVec3::new(x, y, z), r)
}

/// Widens two points.
#[inline(always)]
pub(crate) fn points(p: Vec3, q: Vec3) -> (DVec3, DVec3) {
    let ([px, py], [pz, qx], [qy, qz]) = (pair(p.x, p.y), pair(p.z, q.x), pair(q.y, q.z));
    (DVec3::new(px, py, pz), DVec3::new(qx, qy, qz))
}

/// Widens the origin and the direction of a ray.
#[inline(always)]
pub(crate) fn ray(ray: &Ray) -> (DVec3, DVec3) {
    points(ray.origin, ray.direction)
}
