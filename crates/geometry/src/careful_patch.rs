//! The bilinear patch once more, in 106 bits, for the rays that its common path gives up.
//!
//! The letters and the derivation are those of `patch_solver.rs`. There is no need to exchange `u` and
//! `v` where two roots nearly agree in `u` and differ in `v`: half of the digits of `u` are lost then, and
//! `v` follows, but half of 106 is still an `f64`.

use crate::double_double::{Double, Real};
use crate::patch_solver::Root;
use crate::{BilinearPatch, Ray};

/// A ruling whose image is shorter than `2⁻⁴⁸` of the patch is seen end-on: its place is known to no
/// better, if it is a double root.
const END_ON: f64 = 1.0 / 79_228_162_514_264_337_593_543_950_336.0;

/// The image of a vertex: `x`, `y`, and the depth.
type Image = [Double; 3];

/// The crossings in the square, seen along the last of the axes, whatever their `t`: one if their number is odd, otherwise two or none.
#[cold]
#[inline(never)]
pub(crate) fn solve(
    patch: &BilinearPatch,
    ray: &Ray,
    axes: [usize; 3],
    odd: bool,
) -> [Option<Root>; 2] {
    let [ox, oy, oz] = axes.map(|i| Double::exact(ray.origin[i]));
    let [dx, dy, dz] = axes.map(|i| Double::exact(ray.direction[i]));
    let [p00, p10, p01, p11] = [patch.p00, patch.p10, patch.p01, patch.p11].map(|p| {
        let [x, y, z] = axes.map(|i| Double::exact(p[i]));
        let (x, y, z) = (x - ox, y - oy, z - oz);
        [x * dz - z * dx, y * dz - z * dy, z]
    });
    let c = cross(p00, p01);
    let a = cross(sub(p10, p00), sub(p11, p01));
    let b = cross(p10, p11) - c - a;
    let discriminant = b * b - Double::exact(4.0) * a * c;
    if !odd && discriminant < Double::ZERO {
        return [None, None];
    }
    let root = if discriminant > Double::ZERO { discriminant.square_root() } else { Double::ZERO };
    let q = Double::exact(-0.5) * (if b < Double::ZERO { b - root } else { b + root });
    let size = [p00, p10, p01, p11]
        .iter()
        .map(|p| p[0].nearest().abs().max(p[1].nearest().abs()))
        .fold(0.0, f64::max);
    let (zero, one, half) = (Double::ZERO, Double::exact(1.0), Double::exact(0.5));
    let clamp = |x: Double| {
        if x < zero {
            zero
        } else if x > one {
            one
        } else {
            x
        }
    };
    let crossings = [q / a, if q == zero { zero } else { c / q }].map(|raw| {
        let u = clamp(raw);
        let (p0, p1) = (between(p00, p10, u), between(p01, p11, u));
        let ruling = sub(p1, p0);
        let square = ruling[0] * ruling[0] + ruling[1] * ruling[1];
        let (is_point, v) = if square.nearest() > END_ON * (size * size) {
            (false, -(p0[0] * ruling[0] + p0[1] * ruling[1]) / square)
        } else {
            (true, half)
        };
        // Rulings that are parallel to the ray solve the equation too, wherever they are.
        let beside = (p0[0] * p0[0] + p0[1] * p0[1]).nearest();
        let passes_by = is_point && beside > END_ON * (size * size);
        let t = (p0[2] + clamp(v) * ruling[2]) / dz;
        // A parabola without curvature has its other root at infinity, or nowhere.
        let from_center = if raw.nearest().is_finite() && !passes_by {
            (raw - half).nearest().abs().max((v - half).nearest().abs())
        } else {
            f64::INFINITY
        };
        let in_square = (zero..=one).contains(&raw) && (zero..=one).contains(&v) && !passes_by;
        let root = Root { t: t.nearest(), u: u.nearest(), v: clamp(v).nearest() };
        (root, from_center, in_square)
    });
    let [(first, first_off, first_in), (second, second_off, second_in)] = crossings;
    if odd {
        // The one nearer to the centre is the one in the square, but for the rounding of the outline.
        return [Some(if first_off < second_off { first } else { second }), None];
    }
    if first_in && second_in { [Some(first), Some(second)] } else { [None, None] }
}

fn cross(p: Image, q: Image) -> Double {
    p[0] * q[1] - q[0] * p[1]
}

fn sub(p: Image, q: Image) -> Image {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn between(p: Image, q: Image, s: Double) -> Image {
    [0, 1, 2].map(|i| p[i] + s * (q[i] - p[i]))
}
