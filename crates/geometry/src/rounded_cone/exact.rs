//! The exact evaluation of the rounded cone, for the rays that its filter cannot decide.
//!
//! It finds entry and exit in every position, in `f64` where that suffices and in double-double
//! otherwise. The letters and the derivation are those of `mod.rs`.

use glam::{DVec3, Vec3};

use crate::Ray;
use crate::double_double::{DoubleDouble, ON_SURFACE, Real};
use crate::filter::{CANCELLATION, FAR};
use crate::origin_side::{self, OriginSide};

use super::RoundedCone;

/// A crossing: `t`, the ball `s` that it belongs to, and the point relative to the center of that
/// ball.
pub(crate) struct Crossing {
    pub(crate) t: f32,
    pub(crate) s: f64,
    pub(crate) from_ball: DVec3,
    /// `t` before rounding.
    pub(crate) root: DoubleDouble,
}

/// An end of the part of a line that lies in the solid.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum End {
    Entry,
    Exit,
}

/// The result of solving in numbers of a given precision.
enum Attempt {
    Found(Option<Crossing>),
    /// The numbers have too few digits.
    TooFewDigits,
}

/// Returns the first crossing with `t` in the interval of the ray.
pub(crate) fn solve(cone: &RoundedCone, ray: &Ray) -> Option<Crossing> {
    let ends: &[End] =
        match origin_side::of_rounded_cone([(cone.p0, cone.r0), (cone.p1, cone.r1)], ray) {
            OriginSide::Leaving => return None,
            OriginSide::Inside => &[End::Exit],
            OriginSide::Uncertain => &[End::Entry, End::Exit],
        };
    match attempt::<f64>(cone, ray, CANCELLATION, ends) {
        Attempt::Found(crossing) => crossing,
        Attempt::TooFewDigits => solve_in_double_double(cone, ray, ends),
    }
}

/// Returns the exit, if it is in the interval of the ray.
pub(crate) fn exit(cone: &RoundedCone, ray: &Ray) -> Option<Crossing> {
    match attempt::<f64>(cone, ray, CANCELLATION, &[End::Exit]) {
        Attempt::Found(crossing) => crossing,
        Attempt::TooFewDigits => solve_in_double_double(cone, ray, &[End::Exit]),
    }
}

/// Returns the first of `ends` in the interval of the ray, computed with 106 bits.
pub(crate) fn solve_in_double_double(
    cone: &RoundedCone,
    ray: &Ray,
    ends: &[End],
) -> Option<Crossing> {
    match attempt::<DoubleDouble>(cone, ray, 0.0, ends) {
        Attempt::Found(crossing) => crossing,
        Attempt::TooFewDigits => None,
    }
}

/// Returns the first of `ends` in the interval of the ray. If a difference keeps less than the
/// share `allowed` of its terms, the numbers have too few digits.
fn attempt<R: Real>(cone: &RoundedCone, ray: &Ray, allowed: f64, ends: &[End]) -> Attempt {
    let at_origin = if allowed > 0.0 { 0.0 } else { ON_SURFACE };
    let r = [R::exact(cone.r0), R::exact(cone.r1)];
    let rho = r[0] - r[1];
    let (p0, d, o) = (exact::<R>(cone.p0), exact::<R>(ray.direction), exact::<R>(ray.origin));
    let e = sub(exact(cone.p1), p0);
    let f = sub(o, p0);
    let d2 = dot(e, e) - rho * rho;
    let (w, g) = (cross(f, d), cross(d, e));
    let moment = [0, 1, 2].map(|i| r[0] * g[i] + rho * w[i]);
    let volume = dot(f, g);
    let moment2 = dot(moment, moment);
    let discriminant = moment2 - volume * volume;
    if discriminant.nearest().abs() < allowed * moment2.nearest() {
        return Attempt::TooFewDigits;
    }
    // Written so that a NaN fails.
    let is_shape = cone.r0.min(cone.r1) >= 0.0 && cone.r0.max(cone.r1) > 0.0;
    if !(discriminant >= R::ZERO && d2 > R::ZERO && is_shape) {
        return Attempt::Found(None);
    }
    let (a, b, m) = (dot(d, d), dot(f, d), dot(d, e));
    let thinnest = f64::from(cone.r0.min(cone.r1));
    let (far, left) = (b * b * moment2, a * discriminant);
    if allowed > 0.0 && far.nearest() > FAR * (thinnest * thinnest) * left.nearest() {
        return Attempt::TooFewDigits;
    }
    let width = a * d2;
    let k2 = dot(g, g) - rho * rho * a;
    let y0 = -dot(w, g) - r[0] * rho * a;
    let k1 = -(m * y0);
    let spread = a * (d2 * discriminant).square_root();
    let k1_positive = k1 >= R::ZERO;
    // Both terms have the sign of -k1, so their sum does not cancel. The other root is the
    // difference over k2, or k0 / q: see "Which form of the root".
    let q = if k1_positive { -k1 - spread } else { spread - k1 };
    let (w2, square0) = (dot(w, w), r[0] * r[0] * a);
    let k0 = width * (w2 - square0) - y0 * y0;
    let cancels = w2 > square0;
    let by_difference = (q.nearest() / k2.nearest()).abs();
    let by_product = if cancels { ((width * w2).nearest() / q.nearest()).abs() } else { 0.0 };
    let other = if by_difference < by_product {
        (if k1_positive { spread - k1 } else { -k1 - spread }) / k2
    } else {
        k0 / q
    };
    let other_terms = by_difference.min(by_product);
    let mut before = f64::NEG_INFINITY;
    for end in ends {
        let entry = *end == End::Entry;
        // The line is inside the cone from or to infinity: it is steeper than the cone, or along a
        // cylinder.
        let along = q == R::ZERO && k2 == R::ZERO;
        let endless = (k2 < R::ZERO && entry == (m * rho >= R::ZERO)) || along;
        if along && k0 > R::ZERO {
            return Attempt::Found(None);
        }
        let theta = if endless {
            None
        } else {
            Some(if entry == k1_positive || q == R::ZERO { q / k2 } else { other })
        };
        // The place in the body times `width`; a value outside `0..=width` selects a cap.
        let y = match theta {
            Some(theta) if theta.nearest().is_finite() => y0 + m * theta,
            Some(theta) => R::exact(if (m.nearest() > 0.0) == (theta.nearest() > 0.0) {
                f32::INFINITY
            } else {
                f32::NEG_INFINITY
            }),
            None if entry == (m >= R::ZERO) => R::exact(f32::NEG_INFINITY),
            None => R::exact(f32::INFINITY),
        };
        let (t, s) = if y >= R::ZERO && y <= width {
            let Some(theta) = theta else { return Attempt::Found(None) };
            let difference = theta - b;
            let share = moment2.nearest() / discriminant.nearest();
            let terms: f64 = (0..3).map(|i| (f[i] * d[i]).nearest().abs()).sum();
            let size = theta.nearest().abs().max(terms);
            if difference.nearest().abs() < allowed * (share * size.max(other_terms)) {
                return Attempt::TooFewDigits;
            }
            // A share that grows without limit towards tangents must not reach the origin.
            let on_surface = difference.nearest().abs() <= at_origin * size;
            let t = if on_surface { R::ZERO } else { difference / a };
            (t, y / width)
        } else if y < R::ZERO || y > width {
            // The cap, intersected as a sphere.
            let i = usize::from(y > width);
            let center = if i == 0 { f } else { sub(f, e) };
            let moment = cross(center, d);
            let (along, radius) = (dot(center, d), r[i]);
            let square = radius * radius * a;
            let chord = square - dot(moment, moment);
            if chord.nearest().abs() < allowed * square.nearest() {
                return Attempt::TooFewDigits;
            }
            if chord < R::ZERO {
                return Attempt::Found(None);
            }
            let root = chord.square_root();
            let square0 = dot(center, center);
            let mut g = square0 - radius * radius;
            if g.nearest().abs() <= at_origin * square0.nearest() {
                g = R::ZERO;
            }
            let ahead = along >= R::ZERO;
            let q = if ahead { -along - root } else { root - along };
            let from_product = entry != ahead;
            if from_product && g.nearest().abs() < allowed * (radius * radius).nearest() {
                return Attempt::TooFewDigits;
            }
            (if from_product { g / q } else { q / a }, R::exact(if i == 0 { 0.0 } else { 1.0 }))
        } else {
            return Attempt::Found(None);
        };
        // If the cone is too long for 106 bits, the exit may come out before the entry.
        if t.nearest() < before {
            return Attempt::Found(None);
        }
        before = t.nearest();
        if let Some(rounded) = ray.accept(t.nearest()) {
            let x = [0, 1, 2].map(|i| (f[i] + t * d[i] - s * e[i]).nearest());
            let (s, root) = (s.nearest(), t.widen());
            let crossing = Crossing { t: rounded, s, from_ball: x.into(), root };
            return Attempt::Found(Some(crossing));
        }
    }
    Attempt::Found(None)
}

fn exact<R: Real>(p: Vec3) -> [R; 3] {
    p.to_array().map(R::exact)
}

fn sub<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;
    use crate::test_rays::{aimed, spawned};

    #[test]
    fn the_side_of_the_origin_of_a_ray_is_that_found_with_106_bits() {
        let mut random = Random(0xD1B5_4A32_D192_ED03);
        let mut known = [0, 0];
        let mut spawned_count = 0;
        while spawned_count < 200_000 {
            let size = random.power(3.0);
            let p0 = random.in_cube() * random.power(3.0);
            let p1 = p0 + size * random.power(1.5) * random.in_cube();
            let (r0, r1) = (size * random.power(1.0), size * random.power(1.0));
            let cone = RoundedCone { p0, r0, p1, r1 };
            let (rho, length) =
                (f64::from(r0) - f64::from(r1), p0.as_dvec3().distance(p1.as_dvec3()));
            let at = if random.signed() < 0.0 { p0 } else { p1 };
            let Some(hit) = cone.closest(&aimed(&mut random, at, r0.min(r1))) else { continue };
            if length <= rho.abs() {
                continue;
            }
            spawned_count += 1;
            let ray = spawned(&mut random, &hit);
            let exact = solve_in_double_double(&cone, &ray, &[End::Entry, End::Exit]).map(|c| c.t);
            match origin_side::of_rounded_cone([(p0, r0), (p1, r1)], &ray) {
                OriginSide::Leaving => assert_eq!(exact, None, "{cone:?} {ray:?}"),
                OriginSide::Inside => {
                    let exit = solve_in_double_double(&cone, &ray, &[End::Exit]).map(|c| c.t);
                    assert_eq!(exact, exit, "{cone:?} {ray:?}");
                }
                OriginSide::Uncertain => continue,
            }
            known[usize::from(exact.is_some())] += 1;
        }
        assert!(known[0] > 60_000 && known[1] > 40_000, "{known:?}");
    }
}
