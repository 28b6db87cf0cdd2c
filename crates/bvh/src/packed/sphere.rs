//! Spheres, and the points that replace them in the vanilla method.
//!
//! # The wide test
//!
//! With `f = c - o`, the line passes the center at the parameter `t = f·d / d·d`, at the distance
//! `|f - t d|`. In `f32`, with `u = 2^-24` and `D = |f|`: each coordinate of `f` is rounded by `u`,
//! the dot product has an error of `3 u D |d|`, `1 / d·d` one of `4 u`, and `t d` is subtracted
//! with an error below `2 u D`. An error of `t` itself moves the vector only along `d`. In total
//! the error of the distance is less than `e = 12 u D`. A lane is kept if
//!
//! ```text
//! distance² <= (1 + 2^-9) r² + 2^-31 D²
//! ```
//!
//! The right side exceeds `(r + e)² <= (1 + 2^-9) r² + (1 + 2^9) e²`: the radius grows by a
//! thousandth, or by `2^-15.5` of the distance. The smallest normal number is added for squares
//! that underflow.
//!
//! The hits of both methods are within half a chord of `t`, and the right side above minus the left
//! bounds the squared half chord. With `1 - 2^-9` and `-2^-31` instead, the difference is less than
//! the squared half chord, and if it is positive the sphere is certainly hit. The error of `t`,
//! below `12 u D / |d|`, is covered by `2^-19 (|t| + r / |d|)`.

use super::kernel::{Block, Candidates, Kernel, both_ends, step};
use super::method_tag::MethodTag;
use super::round::RoundRay;
use super::vec3::{self, dot};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, Hit, Method, Ray, Sphere, vanilla};

impl Kernel for Sphere {
    type Vanilla = vanilla::Point;
    type Block = Block<4>;
    const OUTLINE_EXACT_TEST: bool = true;
    const KEEP_HIT: bool = false;
    const OUTLINE_LEAF: bool = false;
    type LeafRay = RoundRay;

    fn tree_bounds(&self) -> Aabb {
        // With both methods only a sphere of positive radius can be hit.
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
    fn leaf_ray(ray: &SlabRay) -> RoundRay {
        RoundRay::new(ray)
    }

    #[inline(always)]
    fn candidates<S: Simd, M: MethodTag>(
        simd: S,
        ray: &RoundRay,
        block: &Block<4>,
        limit: f32,
    ) -> Candidates<S> {
        let ray = ray.lanes(simd);
        let [x, y, z, radius] = block.rows.each_ref();
        let center = ray.project(simd, vec3::load(simd, [x, y, z]));
        let radius = simd.load(radius);
        let distance = dot(simd, center.perpendicular, center.perpendicular);
        let square = simd.mul_add(radius, radius, simd.splat(f32::MIN_POSITIVE));
        let error = simd.mul(center.distance_squared, simd.splat(2f32.powi(-31)));
        let reach = simd.mul_add(square, simd.splat(1.0 + 1.0 / 512.0), error);
        let kept = simd.mask_not_gt(distance, reach);
        if kept == 0 {
            return Candidates::none(simd);
        }
        let half_chord = simd.mul(simd.sqrt(simd.sub(reach, distance)), ray.inverse_length);
        let size = simd.mul_add(radius, ray.inverse_length, simd.abs(center.t));
        let slack = simd.mul(size, simd.splat(2f32.powi(-19)));
        let half_chord = simd.add(half_chord, slack);
        let near = simd.sub(center.t, half_chord);
        let far = simd.add(center.t, half_chord);
        let within = simd.mask_not_gt(near, simd.splat(limit)) & simd.mask_not_gt(ray.start, far);
        let possible = kept & within;
        // The order of the arguments replaces a NaN by the start.
        let first = simd.max(near, ray.start);
        if matches!(M::METHOD, Method::Vanilla) {
            return Candidates { possible, certain: 0, near: first, far };
        }
        // The same with the errors in the other direction. Where this square root is real, the ray
        // enters the sphere at the resulting parameter at the latest. A lane with a NaN is not
        // certain.
        let less = simd.add(simd.add(error, distance), simd.splat(f32::MIN_POSITIVE));
        let square = simd.mul(radius, radius);
        let half_square = simd.sub(simd.mul(square, simd.splat(1.0 - 1.0 / 512.0)), less);
        let half_chord = simd.mul(simd.sqrt(half_square), ray.inverse_length);
        let entry = simd.add(simd.sub(center.t, half_chord), slack);
        let certain = simd.mask_le(ray.start, near) & simd.mask_le(entry, ray.end);
        Candidates { possible, certain: certain & possible, near: first, far: entry }
    }

    #[inline(always)]
    fn vanilla(&self) -> vanilla::Point {
        vanilla::Point { center: self.center, radius: self.radius }
    }

    #[inline(always)]
    fn exact_crossings<M: MethodTag>(&self, ray: &Ray, visit: impl FnMut(Hit, bool)) {
        match M::METHOD {
            Method::Enhanced => both_ends(self, ray, visit),
            Method::Vanilla => step(&self.vanilla(), ray, visit),
        }
    }
}
