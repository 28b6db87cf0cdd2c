//! Decides on which side of a round surface a ray starts, for rays whose origin is next to the
//! surface.
//!
//! A ray that leaves a surface, as nearly all rays of a path do, has a root at about `t = 0`, at a
//! small negative value. The value depends on digits that an `f64` does not have, but its sign can
//! be found with fewer digits. The solids are convex: a plane that separates the ray from the solid
//! shows that a ray outside misses. For a ray that starts inside, the entry lies before the origin
//! and the exit does not.
//!
//! The functions report only what is certain, with bounds on the rounding of their own `f64`
//! arithmetic: `2⁻⁴⁸` of the sum of the terms is more than thirty roundings. The remaining rays are
//! solved in double-double; where a function is certain, that evaluation finds the same signs, and
//! its roots are not so near to zero that they could be rounded to it.

#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Ray, widen};
use glam::Vec3;

/// The side of a surface on which a ray starts, as far as `f64` can tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OriginSide {
    /// The ray starts outside and does not approach the solid: it has no crossing in its interval.
    Leaving,
    /// The ray starts inside: the first crossing in its interval, if there is one, is the exit.
    Inside,
    /// The digits of an `f64` do not suffice, or the ray may enter the solid.
    Uncertain,
}

/// Bound on the rounding error of a sum, as a share of its terms: `2⁻⁴⁸`.
const ROUNDING: f64 = 1.0 / 281_474_976_710_656.0;

/// A root must be larger than this to be distinguished from zero after it is rounded to `f32`.
const LEAST_T: f64 = 8.0 * f32::MIN_POSITIVE as f64;

/// Returns whether the interval of the ray begins at its origin or later. False for a NaN.
fn begins_ahead(ray: &Ray) -> bool {
    ray.t_min >= 0.0
}

/// Locates the origin relative to the sphere of this `center` and `radius`.
///
/// With `g = f·f - r²` and `b = f·d`: outside, `g` is positive and both roots of `a t² + 2 b t + g`
/// have the sign of `-b`; inside, `g` is negative and the roots have opposite signs. Their product
/// is `g / a`.
#[inline(always)]
pub(crate) fn of_sphere(center: Vec3, radius: f32, ray: &Ray) -> OriginSide {
    let (c, r) = widen::ball(center, radius);
    let (o, d) = widen::ray(ray);
    let f = o - c;
    let (square, from_center, b) = (r * r, f.dot(f), f.dot(d));
    let g = from_center - square;
    // Requires `g` to half of its value, not its sign alone. A NaN fails.
    if !(begins_ahead(ray) && g.abs() > 2.0 * ROUNDING * (from_center + square)) {
        return OriginSide::Uncertain;
    }
    if g > 0.0 {
        let away = b > ROUNDING * f.abs().dot(d.abs());
        // The root nearer to zero is `t = -g / (b + root)`, and the root is less than b.
        if away && g > LEAST_T * b { OriginSide::Leaving } else { OriginSide::Uncertain }
    } else {
        // The surface is at least `|g| / 2 r` away.
        let certain = g * g > (LEAST_T * LEAST_T) * square * d.dot(d);
        if certain { OriginSide::Inside } else { OriginSide::Uncertain }
    }
}

/// Locates the origin relative to a rounded cone, neither of whose balls contains the other.
///
/// The ball nearest to a point next to the surface is that of the surface point. The direction from
/// its center to the ray origin is the normal `n` of the separating plane: the solid lies behind
/// the plane if both end balls do, and the ray lies before it if its origin does and it does not
/// approach the plane. The error of `n` does not matter to this test.
#[inline(always)]
pub(crate) fn of_rounded_cone([(p0, r0), (p1, r1)]: [(Vec3, f32); 2], ray: &Ray) -> OriginSide {
    let ((p0, r0), (p1, r1)) = (widen::ball(p0, r0), widen::ball(p1, r1));
    let (o, d) = widen::ray(ray);
    let (e, f) = (p1 - p0, o - p0);
    let rho = r0 - r1;
    let s = ((f.dot(e) - r0 * rho) / (e.dot(e) - rho * rho)).clamp(0.0, 1.0);
    let n = f - s * e;
    let length = n.dot(n).sqrt();
    // A NaN fails every comparison below.
    if !(begins_ahead(ray) && r0 >= 0.0 && r1 >= 0.0) {
        return OriginSide::Uncertain;
    }
    let terms = n.abs().dot(f.abs() + e.abs()) + (r0 + r1) * length;
    let (above0, above1) = (n.dot(f) - r0 * length, n.dot(f - e) - r1 * length);
    let (above, away) = (above0.min(above1), n.dot(d));
    if above > 2.0 * ROUNDING * terms
        && above > LEAST_T * away
        && away > ROUNDING * n.abs().dot(d.abs())
    {
        return OriginSide::Leaving;
    }
    let depth = (r0 - s * rho) - length;
    let terms = (f.abs() + e.abs()).element_sum() + r0 + r1;
    let inside = depth > 2.0 * ROUNDING * terms && depth * depth > (LEAST_T * LEAST_T) * d.dot(d);
    if inside { OriginSide::Inside } else { OriginSide::Uncertain }
}
