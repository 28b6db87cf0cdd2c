//! The floating-point filter of the bilinear patch: the frequent rays, with one square root.
//!
//! A ray passes most patches once. Then the outline is odd and one of the two parabolas of
//! `image.rs`, say `f`, has values of opposite sign at the ends of `0..=1`. It has one root in
//! between, whose slope `σ` has the sign of the value at 1, and `D = (c + e - a)² - 4 c e` is a sum
//! of non-negative terms: no digit of it cancels.

use super::BilinearPatch;
use super::image::{PatchImage, Root};
use crate::Ray;
use crate::f64x2::F64x2;
use crate::filter::Filtered;
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;

/// Returns the first crossing of the surface in the interval of the ray.
#[inline(always)]
pub(super) fn filter(patch: &BilinearPatch, ray: &Ray) -> Filtered<Root<f32>> {
    let Some(image) = PatchImage::new(patch, ray) else { return Filtered::Miss };
    let ends = image.c * image.e;
    let passes = ends.less(F64x2::splat(0.0));
    if !(image.odd & passes.any()) {
        return if image.odd {
            Filtered::Uncertain
        } else if image.may_have_two_roots(ends) {
            // By value, so that the code below may keep its image in registers.
            filter_folded(image, ray)
        } else {
            Filtered::Miss
        };
    }
    let k = (image.c + image.e) - image.a;
    let discriminants = k * k - (F64x2::splat(4.0) * image.c) * image.e;
    // Of a parabola with values of opposite sign at its ends: the first, if it is one. Selected
    // without a branch, which would be unpredictable.
    let first = passes.first_in_both();
    let discriminant = first.select(discriminants, discriminants.swapped()).first();
    let negative = F64x2::splat(0.0) - image.e.swapped();
    let sign = first.select(image.e, negative).first();
    let uv = image.roots(discriminant.sqrt(), sign);
    let uv = uv.max(F64x2::splat(0.0)).min(F64x2::splat(1.0));
    let [u, v] = uv.to_array();
    let depth = image.depth(u, v);
    // If a corner is not finite, the discriminant is infinite or NaN.
    if image.too_few_digits(discriminant, depth) | !discriminant.is_finite() {
        let behind = image.is_behind(ray, discriminant, depth);
        return if behind { Filtered::Miss } else { Filtered::Uncertain };
    }
    ray.accept(image.space.t(depth)).map(|t| Root { t, u, v }).into()
}

/// Returns the first of two crossings, or a miss.
///
/// The corners are finite here: with others [`PatchImage::may_have_two_roots`] is false, because
/// infinities do not compare.
#[cold]
#[inline(never)]
fn filter_folded(image: PatchImage, ray: &Ray) -> Filtered<Root<f32>> {
    image.solve_both(ray)
}
