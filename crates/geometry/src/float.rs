//! Rounding bounds, and the origin of a ray that leaves a surface.

use crate::next_float::next_float;
use glam::{DVec3, Vec3};

/// Bound on the relative error of one rounding to `f32`: `2⁻²⁴`, half the distance between 1 and
/// the next larger `f32`.
pub const UNIT_ROUNDOFF: f32 = 0.5 * f32::EPSILON;

/// Returns the origin of a ray that leaves a surface, such that rounding alone cannot make it hit
/// the same surface again. [`Hit::spawn`](crate::Hit::spawn) calls it with the values of a hit.
///
/// `position` lies within `error` of the surface, and `normal` is the unit normal there. The origin
/// is `position` moved by `error` along the normal, to the side that `direction` points to, and
/// rounded outwards in each coordinate: the smallest step that the error allows.
///
/// That is enough on the outer side of a convex surface. On the inner side rounding along the
/// surface must not leave it, so there the radius of curvature must be at least 16 times the
/// [`rounding_error`] of `position`: a millionth of its coordinates. Inside of a smaller sphere
/// there are few `f32`, or none.
///
/// Source: M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering", section 6.8.6 (robust
/// spawned ray origins), 4th edition, 2023.
#[must_use]
#[inline]
pub fn leave_surface(position: Vec3, error: f32, normal: Vec3, direction: Vec3) -> Vec3 {
    // In `f64` the products are exact, so that the sign is right at grazing directions too.
    let outwards = normal.as_dvec3().dot(direction.as_dvec3());
    let side = if outwards < 0.0 { -normal } else { normal };
    // Moves and rounds outwards to the next number.
    let step = (error * side).extend(0.0);
    next_float(position.extend(0.0) + step, step).truncate()
}

/// Returns a bound on the distance between a point that was computed in `f64` and `p`, the same
/// point rounded to `f32`.
///
/// It is nearly all of the [`Hit::error`](crate::Hit::error) of the shapes of this crate, which
/// adds a few roundings of `f64`, in proportion to the size of the shape. Your own
/// [`Primitive`](crate::Primitive) may use it if it computes its point in `f64` and rounds it once,
/// and should add the error in `f64` if the shape may be large and pass the origin of coordinates.
///
/// Each coordinate moves by at most `u |p_i|`, with `u` = [`UNIT_ROUNDOFF`], or by half of the
/// smallest subnormal number. The sum of the three coordinates bounds the length without a square
/// root. A factor a little above 1 covers the rounding of the `f64` arithmetic, and the smallest
/// normal number replaces the subnormal ones, so that the step does not underflow.
#[must_use]
#[inline]
pub fn rounding_error(p: Vec3) -> f32 {
    const FACTOR: f32 = UNIT_ROUNDOFF * (1.0 + 16.0 * f32::EPSILON);
    let p = p.abs();
    FACTOR * (p.x + p.y + p.z) + f32::MIN_POSITIVE
}

/// Returns a bound on the distance between a surface and `p`, a point that was computed in `f64`
/// within `off` of the surface and then rounded.
///
/// The rounding to `f32` is a share of the coordinates of `p`, which may be zero on a shape however
/// large; `off` is a share of the size of the shape.
#[inline(always)]
pub(crate) fn error(p: Vec3, off: f64) -> f32 {
    // A thousandth covers the conversion and the sum in `f32`.
    rounding_error(p) + (1.001 * off) as f32
}

/// Half of `f64::EPSILON`, the bound on the relative error of one rounding to `f64`.
pub(crate) const F64_ROUNDOFF: f64 = 0.5 * f64::EPSILON;

/// Returns a bound on the distance between a sphere of this radius and the tip of a vector `x` from
/// its center, where `normal` is the computed `x / radius`.
///
/// It measures what a solution left, at whatever distance and incidence: `|x| - r` is
/// `r (n² - 1) / (|n| + 1)`, and `|n| + 1` is 2 but for the thousandth in [`error`]. The computed
/// `n` has four roundings, `n²` three, which halve, and adding the center to `x` rounds by a share
/// of the position, which [`rounding_error`] covers, and one of `x`, at most `√3 r`. That is fewer
/// than eight.
#[inline(always)]
pub(crate) fn off_sphere(radius: f64, normal: DVec3) -> f64 {
    radius * (0.5 * (normal.dot(normal) - 1.0).abs() + 8.0 * F64_ROUNDOFF)
}

/// Returns a bound on the rounding in `f64` of a point in the hull of `corners`, as so many
/// roundings of the largest coordinates.
#[inline(always)]
pub(crate) fn off_hull<const N: usize>(corners: [Vec3; N], roundings: f64) -> f64 {
    // The bits of non-negative numbers have the order of the numbers, and the maximum of integers
    // needs no branch, which would be unpredictable here.
    let mut largest = [0; 3];
    for p in &corners {
        for (largest, x) in largest.iter_mut().zip(p.to_array()) {
            *largest = x.abs().to_bits().max(*largest);
        }
    }
    let [x, y, z] = largest.map(f32::from_bits);
    roundings * F64_ROUNDOFF * f64::from(x + y + z)
}

/// Rounds each coordinate to `f32`, once.
#[inline]
pub(crate) fn round(p: DVec3) -> Vec3 {
    p.as_vec3()
}
