//! Spheres, and the points that stand for them in the vanilla form.
//!
//! # The reject
//!
//! With `f = c - o`, the line passes the centre at the parameter `t = f·d / d·d`, at the distance
//! `|f - t d|`. In `f32`, with `u = 2^-24` and `D = |f|`: each coordinate of `f` is rounded by `u`, the
//! dot product by `3 u D |d|`, `1 / d·d` by `4 u`, and `t d` is subtracted with an error below `2 u D`. An
//! error of `t` itself moves the vector only along `d`. All in all the distance is wrong by less than
//! `e = 12 u D`. A lane is kept if
//!
//! ```text
//! distance² <= (1 + 2^-9) r² + 2^-31 D²
//! ```
//!
//! which is more than `(r + e)² <= (1 + 2^-9) r² + (1 + 2^9) e²`: the radius grows by a thousandth, or by
//! `2^-15.5` of the distance. The smallest normal number is added for squares that underflow.
//!
//! The hits, in both forms, are within half a chord of `t`; the right side above minus the left
//! bounds the half chord. With `1 - 2^-9` and `-2^-31` instead, what is left is less than the half chord,
//! and if it is positive the sphere is hit for sure. The error of `t`, below `12 u D / |d|`, is covered by `2^-19 (|t| + r / |d|)`.

use super::kernel::{Block, Candidates, Kernel, RoundLanes, dot, load3};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, Hit, Ray, Sphere, vanilla};

impl Kernel for Sphere {
    type Block = Block<4>;
    const APART: bool = true;
    type Lanes<S: Simd> = RoundLanes<S>;

    fn bounds(&self) -> Aabb {
        // In both forms only a positive radius hits.
        let finite = self.center.is_finite() && self.radius.is_finite();
        if finite && self.radius > 0.0 { self.bounds() } else { Aabb::EMPTY }
    }

    fn pack(lanes: &[Self; WIDTH], ids: [u32; WIDTH]) -> Block<4> {
        let row = |number: fn(&Self) -> f32| std::array::from_fn(|lane| number(&lanes[lane]));
        Block {
            rows: [
                row(|s| s.center.x),
                row(|s| s.center.y),
                row(|s| s.center.z),
                row(|s| s.radius),
            ],
            ids,
        }
    }

    #[inline(always)]
    fn unpack(block: &Block<4>, lane: usize) -> Self {
        let [x, y, z, radius] = block.lane(lane);
        Self { center: [x, y, z].into(), radius }
    }

    #[inline(always)]
    fn lanes<S: Simd>(simd: S, ray: &SlabRay) -> RoundLanes<S> {
        RoundLanes::new(simd, ray)
    }

    #[inline(always)]
    fn candidates<S: Simd, const VANILLA: bool>(
        simd: S,
        ray: &RoundLanes<S>,
        block: &Block<4>,
        limit: f32,
    ) -> Candidates<S> {
        let [x, y, z, radius] = block.rows.each_ref();
        let seen = ray.project(simd, load3(simd, [x, y, z]));
        let radius = simd.load(radius);
        let distance = dot(simd, seen.beside, seen.beside);
        let square = simd.mul_add(radius, radius, simd.splat(f32::MIN_POSITIVE));
        let error = simd.mul(seen.square, simd.splat(2f32.powi(-31)));
        let reach = simd.mul_add(square, simd.splat(1.0 + 1.0 / 512.0), error);
        let kept = simd.mask_not_gt(distance, reach);
        if kept == 0 {
            return Candidates::none(simd);
        }
        let half = simd.mul(simd.sqrt(simd.sub(reach, distance)), ray.inverse_length);
        let size = simd.mul_add(radius, ray.inverse_length, simd.abs(seen.t));
        let slack = simd.mul(size, simd.splat(2f32.powi(-19)));
        let half = simd.add(half, slack);
        let near = simd.sub(seen.t, half);
        let far = simd.add(seen.t, half);
        let within = simd.mask_not_gt(near, simd.splat(limit)) & simd.mask_not_gt(ray.start, far);
        let maybe = kept & within;
        // In this order a NaN becomes the start.
        let first = simd.max(near, ray.start);
        if VANILLA {
            return Candidates { maybe, surely: 0, near: first, far };
        }
        // The same with errors the other way. Where this has a root, the sphere is entered, at the
        // latest there; a NaN, from the root of a negative number, is not sure.
        let less = simd.add(simd.add(error, distance), simd.splat(f32::MIN_POSITIVE));
        let square = simd.mul(radius, radius);
        let surely = simd.sub(simd.mul(square, simd.splat(1.0 - 1.0 / 512.0)), less);
        let half = simd.mul(simd.sqrt(surely), ray.inverse_length);
        let entry = simd.add(simd.sub(seen.t, half), slack);
        let surely = simd.mask_le(ray.start, near) & simd.mask_le(entry, ray.end);
        Candidates { maybe, surely: surely & maybe, near: first, far: entry }
    }

    #[inline(always)]
    fn closest<const VANILLA: bool>(&self, ray: &Ray) -> Option<Hit> {
        if VANILLA { point(self).closest(ray) } else { self.closest(ray) }
    }

    #[inline(always)]
    fn closest_t<const VANILLA: bool>(&self, ray: &Ray) -> Option<f32> {
        if VANILLA { point(self).closest_t(ray) } else { self.closest_t(ray) }
    }
}

#[inline(always)]
fn point(sphere: &Sphere) -> vanilla::Point {
    vanilla::Point { center: sphere.center, radius: sphere.radius }
}
