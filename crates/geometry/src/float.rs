//! Rounding bounds, and how to leave a surface without hitting it again.

use glam::{DVec3, Vec3};

use crate::Ray;

/// Half the distance between 1 and the next larger `f32`: the largest relative error of one
/// rounding.
pub const UNIT_ROUNDOFF: f32 = 0.5 * f32::EPSILON;

/// Where a ray leaves a surface so that it cannot meet the surface again by rounding alone.
///
/// `position` lies within `error` of the surface, whose normal there is `normal` (of unit length);
/// the result lies on the side that `direction` points to. The step is `error` along the normal,
/// rounded outwards in each coordinate, so it is as small as the error allows.
///
/// Source: M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering", section 6.8.6 (robust
/// spawned ray origins), 4th edition, 2023.
#[must_use]
pub fn leave_surface(position: Vec3, error: f32, normal: Vec3, direction: Vec3) -> Vec3 {
    let side = if normal.dot(direction) < 0.0 { -normal } else { normal };
    let away = |p: f32, step: f32| {
        let moved = p + step;
        if step > 0.0 {
            moved.next_up()
        } else if step < 0.0 {
            moved.next_down()
        } else {
            moved
        }
    };
    let step = error * side;
    Vec3::new(away(position.x, step.x), away(position.y, step.y), away(position.z, step.z))
}

/// Bound on the distance between a point and `p`, its coordinates rounded to `f32`.
///
/// Each coordinate moves by at most `u |p_i| (1 + u)`, `u` being [`UNIT_ROUNDOFF`], or by half of the
/// smallest subnormal number. The sum of the three bounds the length of the step, and costs no square
/// root. The factor pays for what came before, in `f64`: all of it stays under `2⁻²⁴ u |p|`... and the
/// smallest normal number stands in for the subnormal ones, so that the step never underflows.
#[inline]
pub(crate) fn rounding_error(p: Vec3) -> f32 {
    const FACTOR: f32 = UNIT_ROUNDOFF * (1.0 + 16.0 * f32::EPSILON);
    let p = p.abs();
    FACTOR * (p.x + p.y + p.z) + f32::MIN_POSITIVE
}

/// Rounds `t` to `f32`; `None` if that is not finite or not in the interval of the ray.
///
/// The rounded value decides, because it is the one that callers see: a hit is always within its
/// interval, and is found again if it becomes the end of the interval.
#[inline]
pub(crate) fn accept(ray: &Ray, t: f64) -> Option<f32> {
    let t = t as f32;
    // In this form, unlike `max` and `min`, a NaN end of the interval survives and rejects.
    let first = if f32::MIN > ray.t_min { f32::MIN } else { ray.t_min };
    let last = if f32::MAX < ray.t_max { f32::MAX } else { ray.t_max };
    (t >= first && t <= last).then_some(t)
}

/// Rounds each coordinate to `f32`, once.
#[inline]
pub(crate) fn round(p: DVec3) -> Vec3 {
    p.as_vec3()
}

/// A difference that keeps less than this share of its terms has lost digits that an `f32` could miss:
/// 2⁻⁵² over this is 2⁻³⁶, and the solvers may take a root of it, 2⁻¹⁸ ... so they compute it again with more.
pub(crate) const CANCELLATION: f64 = 1.0 / 65_536.0;
