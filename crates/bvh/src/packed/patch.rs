//! Bilinear patches, and the pairs of triangles that replace them in the vanilla method.
//!
//! # The wide test
//!
//! In ray space (`flat.rs`) the origin lies inside a triangle if its three signed areas have the
//! same sign, so if the smallest is not negative or the largest not positive. The vanilla shape is
//! two triangles. The patch lies in the tetrahedron of its corners, whose projection is the union
//! of the projections of its four faces. If that leaves open whether the ray crosses in its
//! interval, the crossing itself is bounded (`patch_crossing.rs`).

use super::flat::{FlatRay, largest_side, max3, min3, signed_area, volume, z_range};
use super::kernel::{Aligned, Block, Candidates, Kernel};
use super::method_tag::MethodTag;
use super::patch_crossing::{Areas, narrowed};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, BilinearPatch, Method, vanilla};

/// Rows of the block: the corners p00, p10, p11, p01 (around the patch), and the longest side of
/// their box.
impl Kernel for BilinearPatch {
    type Vanilla = vanilla::Quad;
    type Block = Aligned<Block<13>>;
    const OUTLINE_EXACT_TEST: bool = false;
    const KEEP_HIT: bool = false;
    const OUTLINE_LEAF: bool = true;
    type LeafRay = FlatRay;

    fn tree_bounds(&self) -> Aabb {
        let finite = [self.p00, self.p10, self.p01, self.p11].iter().all(|p| p.is_finite());
        if finite { self.bounds() } else { Aabb::EMPTY }
    }

    fn pack(lanes: &[Self; WIDTH], ids: [u32; WIDTH]) -> Aligned<Block<13>> {
        let mut rows = [[0.0; WIDTH]; 13];
        for (lane, patch) in lanes.iter().enumerate() {
            let corners = [patch.p00, patch.p10, patch.p11, patch.p01];
            for (corner, p) in corners.iter().enumerate() {
                for axis in 0..3 {
                    rows[3 * corner + axis][lane] = p[axis];
                }
            }
            rows[12][lane] = largest_side(&corners);
        }
        Aligned(Block { rows, ids })
    }

    #[inline(always)]
    fn unpack(block: &Aligned<Block<13>>, lane: usize) -> Self {
        let [x0, y0, z0, x1, y1, z1, x2, y2, z2, x3, y3, z3, _] = block.0.lane(lane);
        Self {
            p00: [x0, y0, z0].into(),
            p10: [x1, y1, z1].into(),
            p11: [x2, y2, z2].into(),
            p01: [x3, y3, z3].into(),
        }
    }

    #[inline(always)]
    fn leaf_ray(ray: &SlabRay) -> FlatRay {
        FlatRay::new(ray)
    }

    #[inline(always)]
    fn candidates<S: Simd, M: MethodTag>(
        simd: S,
        ray: &FlatRay,
        block: &Aligned<Block<13>>,
        limit: f32,
    ) -> Candidates<S> {
        let ray = ray.lanes(simd);
        let (corners, _) = block.0.rows.as_chunks::<3>();
        let c0 = ray.corner(simd, &corners[0]);
        let c1 = ray.corner(simd, &corners[1]);
        let c2 = ray.corner(simd, &corners[2]);
        let c3 = ray.corner(simd, &corners[3]);
        let (a01, a12) = (signed_area(simd, c0, c1), signed_area(simd, c1, c2));
        let (a23, a30) = (signed_area(simd, c2, c3), signed_area(simd, c3, c0));
        let (a02, a13) = (signed_area(simd, c0, c2), signed_area(simd, c1, c3));
        // The areas of the reversed edges have the same bits but for the sign.
        let minus = simd.splat(-0.0);
        let (a20, a31) = (simd.times_sign_of(a02, minus), simd.times_sign_of(a13, minus));
        // The triangles of the vanilla quad, and the other two faces of the tetrahedron.
        let (first, second) = ([a13, a30, a01], [a31, a12, a23]);
        let (third, fourth) = ([a12, a20, a01], [a02, a23, a30]);
        let mut positive = simd.max(min3(simd, first), min3(simd, second));
        let mut negative = simd.min(max3(simd, first), max3(simd, second));
        if matches!(M::METHOD, Method::Enhanced) {
            let least = simd.max(min3(simd, third), min3(simd, fourth));
            let most = simd.min(max3(simd, third), max3(simd, fourth));
            (positive, negative) = (simd.max(positive, least), simd.min(negative, most));
        }
        let size = simd.load(&block.0.rows[12]);
        let error = ray.area_error(simd, size, c0.z);
        let mut kept = simd.mask_not_gt(simd.sub(simd.splat(0.0), error), positive)
            | simd.mask_not_gt(negative, error);
        if kept == 0 {
            return Candidates::none(simd);
        }
        if matches!(M::METHOD, Method::Vanilla) {
            let first_volume = volume(simd, [&c0, &c1, &c3], first, size, error);
            let second_volume = volume(simd, [&c2, &c3, &c1], second, size, error);
            kept = ray.crossing_ahead(simd, first, error, first_volume)
                | ray.crossing_ahead(simd, second, error, second_volume);
        }
        // If the outline winds around the ray, the ray passes through, with both methods.
        let extremes = [
            simd.min(min3(simd, [a01, a12, a23]), a30),
            simd.max(max3(simd, [a01, a12, a23]), a30),
        ];
        let certain = ray.certain_inside(simd, &c0, size, error, extremes);
        let range = z_range(simd, &[c0, c1, c2, c3]);
        let found = ray.candidates(simd, range, limit, kept, certain);
        if matches!(M::METHOD, Method::Vanilla) || found.is_decided() {
            return found;
        }
        let areas = Areas { a01, a12, a23, a30, a02, a13 };
        let corners = [&c0, &c1, &c2, &c3];
        let range = narrowed(simd, corners, &areas, extremes, [size, error], range);
        ray.candidates(simd, range, limit, kept, certain)
    }

    #[inline(always)]
    fn vanilla(&self) -> vanilla::Quad {
        vanilla::Quad { p0: self.p00, p1: self.p10, p2: self.p11, p3: self.p01 }
    }
}
