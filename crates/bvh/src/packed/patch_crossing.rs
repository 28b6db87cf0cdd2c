//! Bounds on where a ray crosses a bilinear patch whose outline winds around it once.
//!
//! The range of the depths of its corners bounds the crossing too, but a ray that starts next to
//! the patch starts within that range. Here the crossing is solved in `f32`, with an error bound.
//! From a distance of about a thousandth of the patch on, most rays then need no exact test. Rays
//! that start nearer, as those do that leave a surface by its error bound, still need it.
//!
//! # Derivation
//!
//! In ray space (`flat.rs`) let `p0 p1 p2 p3` be the corners around the patch and `a_ij` their
//! signed areas. The ray crosses at a root of `f(u) = P(u, 0) × P(u, 1)`, in Bernstein form
//!
//! ```text
//! f(u) = -a_30 (1-u)² + (a_02 + a_13) u (1-u) + a_12 u²
//! ```
//!
//! and at a root `v` of the same form with `a_01`, `a_13 - a_02` and `a_23` instead. If the outline
//! winds around the ray, all four areas of edges have one sign, `f` has opposite signs at 0 and 1
//! and thus one root in between. With `k = a_02 + a_13` and `D = k² + 4 a_30 a_12`, a sum without
//! cancellation, it is `u = 2 a_30 / (2 a_30 + k ± √D)`, with the sign of the areas.
//!
//! # Error
//!
//! If the areas are wrong by at most `E`, so is a polynomial in Bernstein form; `2 E` covers the
//! rounding of `k` too. With the smallest area `w` of an edge, `D >= 4 a_30 a_12 >= s`,
//! `s = 2 w (|a_30| + |a_12|)`. So `f` has a slope of `√s` at least at its root, and one that
//! changes by `2 |a|` per unit, `|a| <= |a_30| + |a_12| + |k|`. At a distance of `8 E / √s` from
//! the root `f` is more than `8 E (1 - 8 E |a| / s)`, and so more than `2 E` if `16 E |a| <= s`:
//! the true root is nearer. The roundings of `√D` and of the denominator add less than `2^-20`
//! times `√D + |2 a_30 + k|` over the denominator. The depth is bilinear, so it is wrong by at most
//! the range of depths times the errors of `u` and `v`, and by its own rounding.

use super::flat::Corner;
use crate::simd::Simd;

/// The signed areas of the edges of a patch and of its diagonals.
pub(super) struct Areas<S: Simd> {
    pub(super) a01: S::Lanes,
    pub(super) a12: S::Lanes,
    pub(super) a23: S::Lanes,
    pub(super) a30: S::Lanes,
    pub(super) a02: S::Lanes,
    pub(super) a13: S::Lanes,
}

/// Narrows the range of the depth of the crossing in lanes where the outline certainly winds around
/// the ray, which the conditions of [`FlatLanes::certain_inside`] tell. `extremes` are the smallest
/// and the largest area of an edge, `size` is the longest side of the box of the corners, and
/// `error` bounds the errors of areas.
///
/// [`FlatLanes::certain_inside`]: super::flat::FlatLanes::certain_inside
#[inline(always)]
pub(super) fn narrowed<S: Simd>(
    simd: S,
    corners: [&Corner<S>; 4],
    areas: &Areas<S>,
    extremes: [S::Lanes; 2],
    [size, error]: [S::Lanes; 2],
    [smallest, largest]: [S::Lanes; 2],
) -> [S::Lanes; 2] {
    let Areas { a01, a12, a23, a30, a02, a13 } = *areas;
    let (k, l) = (simd.add(a13, a02), simd.sub(a13, a02));
    let [u, u_rounding] = root(simd, a30, k, a12);
    let [v, v_rounding] = root(simd, a01, l, a23);
    let u_ends = simd.add(simd.abs(a30), simd.abs(a12));
    let v_ends = simd.add(simd.abs(a01), simd.abs(a23));
    let winding = simd.max(extremes[0], simd.sub(simd.splat(0.0), extremes[1]));
    let steep = simd.mul(simd.add(winding, winding), simd.min(u_ends, v_ends));
    let sixteen = simd.mul(error, simd.splat(16.0));
    // The errors of `u` and of `v`.
    let share = simd.mul(simd.add(u_rounding, v_rounding), simd.splat(2f32.powi(-20)));
    let share = simd.add(share, simd.div(sixteen, simd.sqrt(steep)));
    let curved = simd.max(simd.add(u_ends, simd.abs(k)), simd.add(v_ends, simd.abs(l)));
    let share = simd.nan_unless_le(share, simd.mul(sixteen, curved), steep);
    let share = simd.nan_unless_le(share, simd.mul(error, simd.splat(4.0)), winding);
    let [p0, p1, p2, p3] = corners;
    let distance = simd.max(simd.abs(p0.x), simd.abs(p0.y));
    let share = simd.nan_unless_le(share, distance, simd.add(size, size));
    let start = simd.mul_add(v, simd.sub(p3.z, p0.z), p0.z);
    let end = simd.mul_add(v, simd.sub(p2.z, p1.z), p1.z);
    let z = simd.mul_add(u, simd.sub(end, start), start);
    let depth = simd.max(simd.abs(smallest), simd.abs(largest));
    let rounding = simd.mul(depth, simd.splat(2f32.powi(-20)));
    let error = simd.mul_add(simd.sub(largest, smallest), share, rounding);
    // The order of the arguments keeps the range where there is a NaN.
    [simd.max(simd.sub(z, error), smallest), simd.min(simd.add(z, error), largest)]
}

/// The root in `0..=1` of a polynomial with the Bernstein coefficients `-first`, `middle` and
/// `last`, if `first` and `last` have one sign, and a factor of its rounding.
#[inline(always)]
fn root<S: Simd>(simd: S, first: S::Lanes, middle: S::Lanes, last: S::Lanes) -> [S::Lanes; 2] {
    let product = simd.mul(simd.mul(first, last), simd.splat(4.0));
    let slope = simd.sqrt(simd.mul_add(middle, middle, product));
    let twice = simd.add(first, first);
    let rest = simd.add(twice, middle);
    let inverse = simd.div(simd.splat(1.0), simd.add(rest, simd.times_sign_of(slope, first)));
    let rounding = simd.mul(simd.add(slope, simd.abs(rest)), simd.abs(inverse));
    [simd.mul(twice, inverse), rounding]
}

#[cfg(test)]
mod tests {
    use crate::isa::Isa;
    use crate::packed::kernel::{Candidates, Kernel};
    use crate::packed::method_tag::Enhanced;
    use crate::simd::{Simd, WithSimd};
    use crate::slab::SlabRay;
    use crate::test_random::Random;
    use rotund_geometry::glam::Vec3;
    use rotund_geometry::{BilinearPatch, Ray};

    /// The bounds of the wide test on a patch alone.
    struct Bounds<'a> {
        patch: &'a BilinearPatch,
        ray: &'a Ray,
    }

    impl WithSimd for Bounds<'_> {
        /// Whether a hit is possible and whether it is certain, and the range of its `t`.
        type Output = (bool, bool, [f32; 2]);

        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let block = BilinearPatch::pack(&[*self.patch; 8], [0; 8]);
            let ray = SlabRay::new(self.ray, crate::node::RANGE).expect("a usual ray");
            let leaf_ray = BilinearPatch::leaf_ray(&ray);
            let Candidates { possible, certain, near, far } =
                BilinearPatch::candidates::<S, Enhanced>(simd, &leaf_ray, &block, f32::INFINITY);
            let range = [simd.to_array(near)[0], simd.to_array(far)[0]];
            (possible & 1 != 0, certain & 1 != 0, range)
        }
    }

    /// Rays start at a hundredth to a ten millionth of the size of the patch before or behind it,
    /// where the depths of the corners decide nothing. Of those farther away than three
    /// thousandths, four fifths need no exact test.
    #[test]
    fn rays_that_start_at_a_patch_are_decided_and_rightly() {
        let mut random = Random(0x5851_F42D_4C95_7F2D);
        for isa in Isa::available() {
            let (mut tested, mut decided, mut farther) = (0, 0, 0);
            while tested < 100_000 {
                let size = random.power(3.0);
                let center = size * random.power(1.0) * random.in_cube();
                let twist = 0.5 * random.unit();
                let mut corner = |x: f32, y: f32| {
                    center + size * (Vec3::new(x, y, 0.0) + twist * random.in_cube())
                };
                let (p00, p10) = (corner(-1.0, -1.0), corner(1.0, -1.0));
                let (p01, p11) = (corner(-1.0, 1.0), corner(1.0, 1.0));
                let patch = BilinearPatch { p00, p10, p01, p11 };
                let target = center + 0.5 * size * random.in_cube();
                let direction = size * random.direction().as_vec3();
                let Some(hit) = patch.closest(&Ray::new(target - 9.0 * direction, direction))
                else {
                    continue;
                };
                tested += 1;
                let away = 3e-5 * random.power(2.5);
                let away = if tested % 2 == 0 { away } else { -away };
                let ray = Ray::new(hit.position + away * direction, direction);
                let exact = patch.closest_t(&ray);
                let (possible, certain, [near, far]) = isa.run(Bounds { patch: &patch, ray: &ray });
                assert!(possible || exact.is_none(), "{patch:?} {ray:?} hits at {exact:?}");
                if certain {
                    let t = exact.expect("a certain hit");
                    assert!(
                        near <= t && t <= far,
                        "{t} is not in {near}..={far}: {patch:?} {ray:?}"
                    );
                }
                if away.abs() > 3e-3 {
                    farther += 1;
                    decided += u32::from(possible == certain);
                }
            }
            assert!(decided > farther / 5 * 4, "{decided} of {farther}");
        }
    }
}
