//! Rounding bounds, and how to leave a surface without hitting it again.

use glam::{DVec3, Vec3};

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
#[inline]
pub fn leave_surface(position: Vec3, error: f32, normal: Vec3, direction: Vec3) -> Vec3 {
    // In `f64`, where the products are exact: the sign of a grazing direction must not be an accident.
    let outwards = normal.as_dvec3().dot(direction.as_dvec3());
    let side = if outwards < 0.0 { -normal } else { normal };
    // The next number outwards, by selections and no branches, for nobody could foretell them: the integers that
    // the bits are, negative ones mirrored, are in the order of the numbers.
    let away = |p: f32, step: f32| {
        let moved = p + step;
        let mirrored = |bits: i32| bits ^ ((bits >> 31) & i32::MAX);
        let place = mirrored(moved.to_bits() as i32);
        let next = place + i32::from(step > 0.0) - i32::from(step < 0.0);
        let next = f32::from_bits(mirrored(next) as u32);
        if moved.is_finite() { next } else { moved }
    };
    let step = error * side;
    Vec3::new(away(position.x, step.x), away(position.y, step.y), away(position.z, step.z))
}

/// Bound on the distance between a point and `p`, its coordinates rounded to `f32`.
///
/// This is the [`Hit::error`](crate::Hit::error) of all primitives here, which compute the point in
/// `f64` and round it once; an own primitive that does so may use it too.
///
/// Each coordinate moves by at most `u |p_i|`, `u` being [`UNIT_ROUNDOFF`], or by half of the smallest
/// subnormal number. The sum of the three bounds the length of the step, and costs no square root. The
/// factor pays for the `f64` arithmetic before it; the smallest normal number stands in for the subnormal
/// ones, so that the step never underflows.
#[must_use]
#[inline]
pub fn rounding_error(p: Vec3) -> f32 {
    const FACTOR: f32 = UNIT_ROUNDOFF * (1.0 + 16.0 * f32::EPSILON);
    let p = p.abs();
    FACTOR * (p.x + p.y + p.z) + f32::MIN_POSITIVE
}

/// Rounds each coordinate to `f32`, once.
#[inline]
pub(crate) fn round(p: DVec3) -> Vec3 {
    p.as_vec3()
}
