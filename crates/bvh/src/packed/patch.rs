//! Bilinear patches, and the pairs of triangles that stand for them in the vanilla form.
//!
//! # The reject
//!
//! Seen along the ray (`flat.rs`), a triangle is met if its three signed areas have the same sign, so if the least of
//! them is not negative or the largest not positive. The vanilla form is two triangles. The patch lies in the
//! tetrahedron of the corners, whose picture is the union of those of its four faces.

use super::flat::{FlatLanes, area, largest_side, least, most, range, volume};
use super::kernel::{Aligned, Block, Candidates, Kernel};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, BilinearPatch, Hit, Ray, vanilla};

/// Rows: the corners p00, p10, p11, p01 (around the patch), and the largest side of their box.
impl Kernel for BilinearPatch {
    type Block = Aligned<Block<13>>;
    const APART: bool = false;
    type Lanes<S: Simd> = FlatLanes<S>;

    fn bounds(&self) -> Aabb {
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
    fn lanes<S: Simd>(simd: S, ray: &SlabRay) -> FlatLanes<S> {
        FlatLanes::new(simd, ray)
    }

    #[inline(always)]
    fn candidates<S: Simd, const VANILLA: bool>(
        simd: S,
        ray: &FlatLanes<S>,
        block: &Aligned<Block<13>>,
        limit: f32,
    ) -> Candidates<S> {
        let (corners, _) = block.0.rows.as_chunks::<3>();
        let c0 = ray.corner(simd, &corners[0]);
        let c1 = ray.corner(simd, &corners[1]);
        let c2 = ray.corner(simd, &corners[2]);
        let c3 = ray.corner(simd, &corners[3]);
        let (a01, a12) = (area(simd, c0, c1), area(simd, c1, c2));
        let (a23, a30) = (area(simd, c2, c3), area(simd, c3, c0));
        let (a02, a13) = (area(simd, c0, c2), area(simd, c1, c3));
        let zero = simd.splat(0.0);
        // In the other direction rounding is the same but for the sign.
        let (a20, a31) = (simd.sub(zero, a02), simd.sub(zero, a13));
        // The triangles of the vanilla form, and the other two faces.
        let (first, second) = ([a13, a30, a01], [a31, a12, a23]);
        let others = [[a12, a20, a01], [a02, a23, a30]];
        let mut positive = simd.max(least(simd, first), least(simd, second));
        let mut negative = simd.min(most(simd, first), most(simd, second));
        if !VANILLA {
            for face in others {
                positive = simd.max(positive, least(simd, face));
                negative = simd.min(negative, most(simd, face));
            }
        }
        let size = simd.load(&block.0.rows[12]);
        let error = ray.area_error(simd, size, c0.z);
        let mut kept =
            simd.mask_not_gt(simd.sub(zero, error), positive) | simd.mask_not_gt(negative, error);
        if kept == 0 {
            return Candidates::none(simd);
        }
        if VANILLA {
            let of_first = volume(simd, [&c0, &c1, &c3], first, size, error);
            let of_second = volume(simd, [&c2, &c3, &c1], second, size, error);
            kept =
                ray.ahead(simd, first, error, of_first) | ray.ahead(simd, second, error, of_second);
        }
        // If the outline turns around the ray, the ray passes through, in both forms.
        let ends = [
            simd.min(least(simd, [a01, a12, a23]), a30),
            simd.max(most(simd, [a01, a12, a23]), a30),
        ];
        let surely = ray.surely(simd, &c0, size, error, ends);
        ray.candidates(simd, range(simd, &[c0, c1, c2, c3]), limit, kept, surely)
    }

    #[inline(always)]
    fn closest<const VANILLA: bool>(&self, ray: &Ray) -> Option<Hit> {
        if VANILLA { quad(self).closest(ray) } else { self.closest(ray) }
    }

    #[inline(always)]
    fn closest_t<const VANILLA: bool>(&self, ray: &Ray) -> Option<f32> {
        if VANILLA { quad(self).closest_t(ray) } else { self.closest_t(ray) }
    }
}

#[inline(always)]
fn quad(patch: &BilinearPatch) -> vanilla::Quad {
    vanilla::Quad { p0: patch.p00, p1: patch.p10, p2: patch.p11, p3: patch.p01 }
}
