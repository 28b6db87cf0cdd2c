//! Triangles, which are the same with both methods.
//!
//! The wide test rejects a triangle if its three signed areas in ray space (`flat.rs`) have
//! different signs.

use super::flat::{
    FlatRay, crossing_range, largest_side, max3, min3, signed_area, volume, z_range,
};
use super::kernel::{Block, Candidates, Kernel};
use super::method_tag::MethodTag;
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, Triangle};

/// Rows of the block: the corners, and the longest side of their box.
impl Kernel for Triangle {
    type Vanilla = Self;
    type Block = Block<10>;
    const OUTLINE_EXACT_TEST: bool = false;
    const KEEP_HIT: bool = false;
    const OUTLINE_LEAF: bool = true;
    type LeafRay = FlatRay;

    fn tree_bounds(&self) -> Aabb {
        let finite = [self.p0, self.p1, self.p2].iter().all(|p| p.is_finite());
        if finite { self.bounds() } else { Aabb::EMPTY }
    }

    fn pack(lanes: &[Self; WIDTH], ids: [u32; WIDTH]) -> Block<10> {
        let mut rows = [[0.0; WIDTH]; 10];
        for (lane, triangle) in lanes.iter().enumerate() {
            let corners = [triangle.p0, triangle.p1, triangle.p2];
            for (corner, p) in corners.iter().enumerate() {
                for axis in 0..3 {
                    rows[3 * corner + axis][lane] = p[axis];
                }
            }
            rows[9][lane] = largest_side(&corners);
        }
        Block { rows, ids }
    }

    #[inline(always)]
    fn unpack(block: &Block<10>, lane: usize) -> Self {
        let [x0, y0, z0, x1, y1, z1, x2, y2, z2, _] = block.lane(lane);
        Self { p0: [x0, y0, z0].into(), p1: [x1, y1, z1].into(), p2: [x2, y2, z2].into() }
    }

    #[inline(always)]
    fn leaf_ray(ray: &SlabRay) -> FlatRay {
        FlatRay::new(ray)
    }

    #[inline(always)]
    fn candidates<S: Simd, M: MethodTag>(
        simd: S,
        ray: &FlatRay,
        block: &Block<10>,
        limit: f32,
    ) -> Candidates<S> {
        let ray = ray.lanes(simd);
        let (corners, _) = block.rows.as_chunks::<3>();
        let c0 = ray.corner(simd, &corners[0]);
        let c1 = ray.corner(simd, &corners[1]);
        let c2 = ray.corner(simd, &corners[2]);
        let (a, b, c) =
            (signed_area(simd, c0, c1), signed_area(simd, c1, c2), signed_area(simd, c2, c0));
        let size = simd.load(&block.rows[9]);
        let error = ray.area_error(simd, size, c0.z);
        let (positive, negative) = (min3(simd, [a, b, c]), max3(simd, [a, b, c]));
        let kept = simd.mask_not_gt(simd.sub(simd.splat(0.0), error), positive)
            | simd.mask_not_gt(negative, error);
        if kept == 0 {
            return Candidates::none(simd);
        }
        let areas = [b, c, a];
        let volume = volume(simd, [&c0, &c1, &c2], areas, size, error);
        let kept = ray.crossing_ahead(simd, areas, error, volume);
        let certain = ray.certain_inside(simd, &c0, size, error, [positive, negative]);
        let range = crossing_range(simd, areas, volume, z_range(simd, &[c0, c1, c2]));
        ray.candidates(simd, range, limit, kept, certain)
    }

    #[inline(always)]
    fn vanilla(&self) -> Self {
        *self
    }
}
