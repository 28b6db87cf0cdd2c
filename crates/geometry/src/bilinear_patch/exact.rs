//! The exact evaluation of the bilinear patch, for the rays that its filter cannot decide.
//!
//! The general solution in `f64` comes first, then double-double. The letters and the derivation
//! are those of `image.rs`. In double-double there is no need to exchange `u` and `v` where two
//! roots nearly agree in `u` and differ in `v`: half of the digits of `u` are lost then, and `v`
//! inherits the error, but half of 106 bits still are those of an `f64`.

use super::BilinearPatch;
use super::image::{PatchImage, Root, nearest};
use crate::Ray;
use crate::double_double::{DoubleDouble, ON_SURFACE, Real};
use crate::filter::Filtered;

/// `2⁻⁹⁶`. A ruling whose image is shorter than its square root, `2⁻⁴⁸`, of the patch is seen
/// end-on: the place of a double root is known to no better.
const END_ON: f64 = 1.0 / 79_228_162_514_264_337_593_543_950_336.0;

/// The image of a vertex: `x`, `y`, and the depth.
type Image = [DoubleDouble; 3];

/// Returns the first crossing of any ray: also of one that crosses the patch twice, or once near a
/// fold or a corner, or for which 53 bits are too few.
pub(super) fn solve(patch: &BilinearPatch, ray: &Ray) -> Option<Root<f32>> {
    let corners = [patch.p00, patch.p10, patch.p01, patch.p11];
    if !corners.iter().all(|p| p.is_finite()) {
        return None;
    }
    let image = PatchImage::new(patch, ray)?;
    match image.solve_both(ray) {
        Filtered::Miss => None,
        Filtered::Hit(root) => Some(root),
        Filtered::Uncertain => {
            nearest(ray, solve_in_double_double(patch, ray, image.space.axes(), image.odd))
        }
    }
}

/// Returns the crossings in the square, projected along the last of the axes, whatever their `t`:
/// one if `odd`, otherwise two or none.
#[cold]
#[inline(never)]
fn solve_in_double_double(
    patch: &BilinearPatch,
    ray: &Ray,
    axes: [usize; 3],
    odd: bool,
) -> [Option<Root>; 2] {
    let [ox, oy, oz] = axes.map(|i| DoubleDouble::exact(ray.origin[i]));
    let [dx, dy, dz] = axes.map(|i| DoubleDouble::exact(ray.direction[i]));
    let [p00, p10, p01, p11] = [patch.p00, patch.p10, patch.p01, patch.p11].map(|p| {
        let [x, y, z] = axes.map(|i| DoubleDouble::exact(p[i]));
        let (x, y, z) = (x - ox, y - oy, z - oz);
        [x * dz - z * dx, y * dz - z * dy, z]
    });
    let c = cross(p00, p01);
    let a = cross(sub(p10, p00), sub(p11, p01));
    let b = cross(p10, p11) - c - a;
    let discriminant = b * b - DoubleDouble::exact(4.0) * a * c;
    if !odd && discriminant < DoubleDouble::ZERO {
        return [None, None];
    }
    let root = if discriminant > DoubleDouble::ZERO {
        discriminant.square_root()
    } else {
        DoubleDouble::ZERO
    };
    let q = DoubleDouble::exact(-0.5) * (if b < DoubleDouble::ZERO { b - root } else { b + root });
    let size = [p00, p10, p01, p11]
        .iter()
        .map(|p| p[0].nearest().abs().max(p[1].nearest().abs()))
        .fold(0.0, f64::max);
    let deepest = [p00, p10, p01, p11].iter().map(|p| p[2].nearest().abs()).fold(0.0, f64::max);
    let (zero, one, half) =
        (DoubleDouble::ZERO, DoubleDouble::exact(1.0), DoubleDouble::exact(0.5));
    let clamp = |x: DoubleDouble| {
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
        // Rulings parallel to the ray solve the equation too, at any distance from it.
        let distance2 = (p0[0] * p0[0] + p0[1] * p0[1]).nearest();
        let passes_by = is_point && distance2 > END_ON * (size * size);
        let depth = p0[2] + clamp(v) * ruling[2];
        let t = if depth.nearest().abs() <= ON_SURFACE * deepest { zero } else { depth / dz };
        // A parabola without curvature has its second root at infinity, or none.
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
        // The root nearer to the center is the one in the square, up to the rounding of the
        // outline.
        return [Some(if first_off < second_off { first } else { second }), None];
    }
    if first_in && second_in { [Some(first), Some(second)] } else { [None, None] }
}

fn cross(p: Image, q: Image) -> DoubleDouble {
    p[0] * q[1] - q[0] * p[1]
}

fn sub(p: Image, q: Image) -> Image {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn between(p: Image, q: Image, s: DoubleDouble) -> Image {
    [0, 1, 2].map(|i| p[i] + s * (q[i] - p[i]))
}

#[cfg(test)]
mod tests {
    use super::super::filter;
    use super::*;
    use crate::test_random::Random;
    use crate::test_rays::{aimed, spawned};
    use glam::Vec3;

    #[test]
    fn a_ray_whose_root_is_behind_for_certain_misses_with_106_bits() {
        let mut random = Random(0x2545_F491_4F6C_DD1D);
        let (mut behind, mut count) = (0, 0);
        while count < 200_000 {
            let size = random.power(3.0);
            let center = random.in_cube() * random.power(3.0);
            let twist = 0.3 * random.power(1.0);
            let mut corner =
                |x: f32, y: f32| center + size * (Vec3::new(x, y, 0.0) + twist * random.in_cube());
            let [p00, p10] = [corner(-1.0, -1.0), corner(1.0, -1.0)];
            let [p01, p11] = [corner(-1.0, 1.0), corner(1.0, 1.0)];
            let patch = BilinearPatch { p00, p10, p01, p11 };
            let Some(hit) = patch.closest(&aimed(&mut random, center, size)) else { continue };
            count += 1;
            let ray = spawned(&mut random, &hit);
            let Some(image) = PatchImage::new(&patch, &ray) else { continue };
            let missed = match filter::filter(&patch, &ray) {
                Filtered::Miss => true,
                Filtered::Hit(_) => false,
                Filtered::Uncertain => solve(&patch, &ray).is_none(),
            };
            let exact = solve_in_double_double(&patch, &ray, image.space.axes(), image.odd);
            let found = nearest(&ray, exact);
            assert_eq!(missed, found.is_none(), "{patch:?} {ray:?}");
            behind += u32::from(missed && image.odd);
        }
        assert!(behind > 100_000, "{behind}");
    }
}
