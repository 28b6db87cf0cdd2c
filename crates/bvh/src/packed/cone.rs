//! Rounded cones, and the lines that replace them in the vanilla method.
//!
//! # The wide test
//!
//! A ray that hits comes within the larger radius of the axis; the same holds for the vanilla line.
//! Projected along the ray, the axis is a segment from `a` to `b` in a plane and the ray is the
//! origin of the plane. The point of the segment closest to it, at
//! `s = clamp(a·(a - b) / |a - b|²)`, has the distance of the ray from the axis.
//!
//! As for spheres, the errors of the ends are less than `e = 12 u D`, where `D` is the distance of
//! an end from the origin of the ray. An error of `s` moves the point along the segment by at most
//! `min(|b - a|, |a| e / |b - a|)`. Its maximum, `sqrt(|a| e)`, adds `|a| e` to the squared
//! distance; where that matters `|a|` is about `r`, so that it is covered by counting
//! `r e < (r + e)² - r²` once more. So a lane is kept if `distance² <= (1 + 2^-9) r² + 2^-28 D²`,
//! which is more than `(r + 3 e)²`.
//!
//! The first hit is not before the nearer of the two points where the balls begin along the ray.

use super::kernel::{Block, Candidates, Kernel, both_ends, step};
use super::method_tag::MethodTag;
use super::round::RoundRay;
use super::vec3::{self, dot, neg_mul_add, sub};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, Hit, Method, Ray, RoundedCone, vanilla};

impl Kernel for RoundedCone {
    type Vanilla = vanilla::Line;
    type Block = Block<8>;
    const OUTLINE_EXACT_TEST: bool = true;
    const KEEP_HIT: bool = true;
    const OUTLINE_LEAF: bool = false;
    type LeafRay = RoundRay;

    fn tree_bounds(&self) -> Aabb {
        let finite = self.p0.is_finite()
            && self.p1.is_finite()
            && self.r0.is_finite()
            && self.r1.is_finite();
        if finite { self.bounds() } else { Aabb::EMPTY }
    }

    fn pack(lanes: &[Self; WIDTH], ids: [u32; WIDTH]) -> Block<8> {
        let row = |number: fn(&Self) -> f32| std::array::from_fn(|lane| number(&lanes[lane]));
        Block {
            rows: [
                row(|c| c.p0.x),
                row(|c| c.p0.y),
                row(|c| c.p0.z),
                row(|c| c.r0),
                row(|c| c.p1.x),
                row(|c| c.p1.y),
                row(|c| c.p1.z),
                row(|c| c.r1),
            ],
            ids,
        }
    }

    #[inline(always)]
    fn unpack(block: &Block<8>, lane: usize) -> Self {
        let [x0, y0, z0, r0, x1, y1, z1, r1] = block.lane(lane);
        Self { p0: [x0, y0, z0].into(), r0, p1: [x1, y1, z1].into(), r1 }
    }

    #[inline(always)]
    fn leaf_ray(ray: &SlabRay) -> RoundRay {
        RoundRay::new(ray)
    }

    #[inline(always)]
    fn candidates<S: Simd, M: MethodTag>(
        simd: S,
        ray: &RoundRay,
        block: &Block<8>,
        limit: f32,
    ) -> Candidates<S> {
        let ray = ray.lanes(simd);
        let [x0, y0, z0, r0, x1, y1, z1, r1] = block.rows.each_ref();
        let first = ray.project(simd, vec3::load(simd, [x0, y0, z0]));
        let second = ray.project(simd, vec3::load(simd, [x1, y1, z1]));
        let (r0, r1) = (simd.load(r0), simd.load(r1));
        let axis = sub(simd, first.perpendicular, second.perpendicular);
        let s = simd.div(dot(simd, first.perpendicular, axis), dot(simd, axis, axis));
        // An axis along the ray gives a NaN, which the order of the arguments replaces by zero.
        let s = simd.min(simd.max(s, simd.splat(0.0)), simd.splat(1.0));
        let perpendicular = neg_mul_add(simd, s, axis, first.perpendicular);
        let distance = dot(simd, perpendicular, perpendicular);
        let radius = simd.max(r0, r1);
        let square = simd.mul_add(radius, radius, simd.splat(f32::MIN_POSITIVE));
        let reach = simd.mul_add(
            square,
            simd.splat(1.0 + 1.0 / 512.0),
            simd.mul(
                simd.max(first.distance_squared, second.distance_squared),
                simd.splat(2f32.powi(-28)),
            ),
        );
        let kept = simd.mask_not_gt(distance, reach);
        if kept == 0 {
            return Candidates::none(simd);
        }
        let size = simd.max(simd.abs(first.t), simd.abs(second.t));
        let size = simd.mul_add(radius, ray.inverse_length, size);
        let slack = simd.mul(size, simd.splat(2f32.powi(-19)));
        let (h0, h1) = (
            simd.mul_add(r0, ray.inverse_length, slack),
            simd.mul_add(r1, ray.inverse_length, slack),
        );
        let near = simd.min(simd.sub(first.t, h0), simd.sub(second.t, h1));
        let far = simd.max(simd.add(first.t, h0), simd.add(second.t, h1));
        let within = simd.mask_not_gt(near, simd.splat(limit)) & simd.mask_not_gt(ray.start, far);
        // The order of the arguments replaces a NaN by the start.
        Candidates { possible: kept & within, certain: 0, near: simd.max(near, ray.start), far }
    }

    #[inline(always)]
    fn vanilla(&self) -> vanilla::Line {
        vanilla::Line { p0: self.p0, r0: self.r0, p1: self.p1, r1: self.r1 }
    }

    #[inline(always)]
    fn exact_crossings<M: MethodTag>(&self, ray: &Ray, visit: impl FnMut(Hit, bool)) {
        match M::METHOD {
            Method::Enhanced => both_ends(self, ray, visit),
            Method::Vanilla => step(&self.vanilla(), ray, visit),
        }
    }
}
