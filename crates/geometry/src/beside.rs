//! Which side of a round surface a ray starts on, for rays that start next to it.
//!
//! A ray that leaves a surface, as nearly all rays of a path do, meets this surface once more at about `t = 0`:
//! before its start, but by how much hangs on digits that an `f64` does not have. That it is before needs fewer
//! of them, a sign. The solids are convex, so that a plane between the solid and the ray settles all that is
//! outside; and from inside the entry is before, the exit is not.
//!
//! Each function says what is certain, with bounds on the rounding of its own `f64` arithmetic: `2⁻⁴⁸` of the
//! sum of the terms is more than thirty roundings. What is not certain is left to the numbers of 106 bits. With
//! these the roots have the same signs, and do not come near enough to zero to be rounded to it.

#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Ray, RoundedCone, Sphere, widen};

/// Where a ray starts, for certain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Start {
    /// Outside, and it does not come nearer: there is no crossing in its interval.
    Leaving,
    /// Inside: the first crossing in its interval, if there is one, is the exit.
    Inside,
    Unknown,
}

/// A bound on the rounding of a sum, as a share of its terms.
const ROUNDING: f64 = 1.0 / 281_474_976_710_656.0;

/// What no root of less than this `t` can be told from is zero.
const LEAST_T: f64 = 8.0 * f32::MIN_POSITIVE as f64;

/// Whether the interval of the ray begins at its origin, or later. False for a NaN.
fn begins_ahead(ray: &Ray) -> bool {
    ray.t_min >= 0.0
}

/// With `g = f·f - r²` and `b = f·d`: outside `g` is positive, and both roots of `a t² + 2 b t + g` have the sign
/// of `-b`; inside it is negative and they have two signs. Their product is `g / a`.
pub(crate) fn sphere(sphere: &Sphere, ray: &Ray) -> Start {
    let (c, r) = widen::ball(sphere.center, sphere.radius);
    let (o, d) = widen::ray(ray);
    let f = o - c;
    let (square, from_center, b) = (r * r, f.dot(f), f.dot(d));
    let g = from_center - square;
    // Half of `g` is certain, not its sign alone. A NaN fails.
    if !(begins_ahead(ray) && g.abs() > 2.0 * ROUNDING * (from_center + square)) {
        return Start::Unknown;
    }
    if g > 0.0 {
        let away = b > ROUNDING * f.abs().dot(d.abs());
        // The root nearer to zero is g / (b + root) at `-t`, and the root is less than b.
        if away && g > LEAST_T * b { Start::Leaving } else { Start::Unknown }
    } else {
        // The surface is `|g| / 2 r` away, at least.
        if g * g > (LEAST_T * LEAST_T) * square * d.dot(d) { Start::Inside } else { Start::Unknown }
    }
}

/// For a cone neither of whose balls holds the other.
///
/// Next to the surface the ball that is nearest is that of the surface point; its centre and the origin of the
/// ray give the normal `n` of a plane. The solid lies behind it if both end balls do, and the ray before it if its
/// origin does and it does not approach. How well `n` was found does not matter to that.
pub(crate) fn rounded_cone(cone: &RoundedCone, ray: &Ray) -> Start {
    let ((p0, r0), (p1, r1)) = (widen::ball(cone.p0, cone.r0), widen::ball(cone.p1, cone.r1));
    let (o, d) = widen::ray(ray);
    let (e, f) = (p1 - p0, o - p0);
    let rho = r0 - r1;
    let s = ((f.dot(e) - r0 * rho) / (e.dot(e) - rho * rho)).clamp(0.0, 1.0);
    let n = f - s * e;
    let length = n.dot(n).sqrt();
    // A NaN fails every comparison below.
    if !(begins_ahead(ray) && r0 >= 0.0 && r1 >= 0.0) {
        return Start::Unknown;
    }
    let terms = n.abs().dot(f.abs() + e.abs()) + (r0 + r1) * length;
    let (above0, above1) = (n.dot(f) - r0 * length, n.dot(f - e) - r1 * length);
    let (above, away) = (above0.min(above1), n.dot(d));
    if above > 2.0 * ROUNDING * terms
        && above > LEAST_T * away
        && away > ROUNDING * n.abs().dot(d.abs())
    {
        return Start::Leaving;
    }
    let depth = (r0 - s * rho) - length;
    let terms = (f.abs() + e.abs()).element_sum() + r0 + r1;
    let inside = depth > 2.0 * ROUNDING * terms && depth * depth > (LEAST_T * LEAST_T) * d.dot(d);
    if inside { Start::Inside } else { Start::Unknown }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::careful_cone::{End, solve_exactly};
    use crate::test_rays::{Random, aimed, spawned};

    #[test]
    fn rays_are_told_to_leave_a_sphere_or_start_inside_as_106_bits_do() {
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let mut known = [0, 0];
        let mut spawned_count = 0;
        while spawned_count < 200_000 {
            let size = random.power(4.0);
            let center = random.point() * random.power(4.0);
            let sphere = Sphere { center, radius: size };
            let Some(hit) = sphere.closest(&aimed(&mut random, center, size)) else { continue };
            spawned_count += 1;
            let ray = spawned(&mut random, &hit);
            let exact = sphere.solve_exactly(&ray).map(|root| root.t);
            match super::sphere(&sphere, &ray) {
                Start::Leaving => assert_eq!(exact, None, "{sphere:?} {ray:?}"),
                Start::Inside => {
                    let exit = Ray { t_min: ray.t_min.max(f32::MIN_POSITIVE), ..ray };
                    let last = sphere.solve_exactly(&exit).map(|root| root.t);
                    assert_eq!(exact, last, "{sphere:?} {ray:?}");
                    let found = sphere.closest_t(&ray);
                    let near = |t: f32| found == Some(t) || found == Some(t.next_up());
                    let agrees = exact.map_or(found.is_none(), |t| near(t) || near(t.next_down()));
                    assert!(agrees, "{sphere:?} {ray:?} {exact:?} {found:?}");
                }
                Start::Unknown => continue,
            }
            known[usize::from(exact.is_some())] += 1;
        }
        assert!(known[0] > 60_000 && known[1] > 40_000, "{known:?}");
    }

    #[test]
    fn rays_are_told_to_leave_a_cone_or_start_inside_as_106_bits_do() {
        let mut random = Random(0xD1B5_4A32_D192_ED03);
        let mut known = [0, 0];
        let mut spawned_count = 0;
        while spawned_count < 200_000 {
            let size = random.power(3.0);
            let p0 = random.point() * random.power(3.0);
            let p1 = p0 + size * random.power(1.5) * random.point();
            let (r0, r1) = (size * random.power(1.0), size * random.power(1.0));
            let cone = RoundedCone { p0, r0, p1, r1 };
            let (rho, length) =
                (f64::from(r0) - f64::from(r1), p0.as_dvec3().distance(p1.as_dvec3()));
            let at = if random.number() < 0.0 { p0 } else { p1 };
            let Some(hit) = cone.closest(&aimed(&mut random, at, r0.min(r1))) else { continue };
            if length <= rho.abs() {
                continue;
            }
            spawned_count += 1;
            let ray = spawned(&mut random, &hit);
            let exact = solve_exactly(&cone, &ray, &[End::Entry, End::Exit]).map(|c| c.t);
            match rounded_cone(&cone, &ray) {
                Start::Leaving => assert_eq!(exact, None, "{cone:?} {ray:?}"),
                Start::Inside => {
                    let exit = solve_exactly(&cone, &ray, &[End::Exit]).map(|c| c.t);
                    assert_eq!(exact, exit, "{cone:?} {ray:?}");
                }
                Start::Unknown => continue,
            }
            known[usize::from(exact.is_some())] += 1;
        }
        assert!(known[0] > 60_000 && known[1] > 40_000, "{known:?}");
    }
}
