//! Triangles, which have one form only.
//!
//! The reject: the three signed areas, seen along the ray (`flat.rs`), do not have the same sign.

use super::flat::{FlatLanes, area, crossing, largest_side, least, most, range, volume};
use super::kernel::{Block, Candidates, Kernel};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, Hit, Ray, Triangle};

/// Rows: the corners, and the largest side of their box.
impl Kernel for Triangle {
    type Block = Block<10>;
    const APART: bool = false;
    type Lanes<S: Simd> = FlatLanes<S>;

    fn bounds(&self) -> Aabb {
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
    fn lanes<S: Simd>(simd: S, ray: &SlabRay) -> FlatLanes<S> {
        FlatLanes::new(simd, ray)
    }

    #[inline(always)]
    fn candidates<S: Simd, const VANILLA: bool>(
        simd: S,
        ray: &FlatLanes<S>,
        block: &Block<10>,
        limit: f32,
    ) -> Candidates<S> {
        let (corners, _) = block.rows.as_chunks::<3>();
        let c0 = ray.corner(simd, &corners[0]);
        let c1 = ray.corner(simd, &corners[1]);
        let c2 = ray.corner(simd, &corners[2]);
        let (a, b, c) = (area(simd, c0, c1), area(simd, c1, c2), area(simd, c2, c0));
        let size = simd.load(&block.rows[9]);
        let error = ray.area_error(simd, size, c0.z);
        let (positive, negative) = (least(simd, [a, b, c]), most(simd, [a, b, c]));
        let kept = simd.mask_not_gt(simd.sub(simd.splat(0.0), error), positive)
            | simd.mask_not_gt(negative, error);
        if kept == 0 {
            return Candidates::none(simd);
        }
        let areas = [b, c, a];
        let volume = volume(simd, [&c0, &c1, &c2], areas, size, error);
        let kept = ray.ahead(simd, areas, error, volume);
        let surely = ray.surely(simd, &c0, size, error, [positive, negative]);
        let range = crossing(simd, areas, volume, range(simd, &[c0, c1, c2]));
        ray.candidates(simd, range, limit, kept, surely)
    }

    #[inline(always)]
    fn closest<const VANILLA: bool>(&self, ray: &Ray) -> Option<Hit> {
        self.closest(ray)
    }

    #[inline(always)]
    fn closest_t<const VANILLA: bool>(&self, ray: &Ray) -> Option<f32> {
        self.closest_t(ray)
    }
}
