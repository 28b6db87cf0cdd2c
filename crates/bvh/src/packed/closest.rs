//! Closest-hit traversal of packed trees.

use super::Packed;
use super::exact::{exact_hit, exact_t};
use super::kernel::{Candidates, HasIds, Kernel, NO_ID};
use super::method_tag::MethodTag;
use crate::found::PrimitiveHit;
use crate::node::WIDTH;
use crate::simd::{Simd, WithSimd};
use crate::slab::{Scaling, SlabRay};
use crate::traverse;
use rotund_geometry::{Hit, Ray};
use std::marker::PhantomData;

/// Finds the closest hit.
pub(crate) struct FindClosest<'a, P: Kernel, M> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    method: PhantomData<M>,
}

impl<'a, P: Kernel, M: MethodTag> FindClosest<'a, P, M> {
    #[inline(always)]
    pub(crate) fn new(packed: &'a Packed<P>, ray: &'a Ray) -> Self {
        Self { packed, ray, method: PhantomData }
    }
}

impl<P: Kernel, M: MethodTag> WithSimd for FindClosest<'_, P, M> {
    type Output = Option<PrimitiveHit>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let slab_ray = SlabRay::new(self.ray, self.packed.tree.range)?;
        let mut visitor = ClosestVisitor::<P, M>::new(self.packed, self.ray, &slab_ray);
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        traverse::closest(simd, &self.packed.tree, &slab_ray, limit, &mut visitor);
        let best = visitor.best;
        if best.id == NO_ID {
            return None;
        }
        if let (true, Some(hit)) = (P::KEEP_HIT, best.hit) {
            return Some(PrimitiveHit { id: best.id, hit });
        }
        let block = &self.packed.blocks[best.block];
        // A certain hit is one of the exact test.
        let hit = P::unpack(block, best.lane).exact_hit::<M>(self.ray)?;
        Some(PrimitiveHit { id: best.id, hit })
    }
}

/// Tests leaves for a hit closer than the best so far.
pub(crate) struct ClosestVisitor<'a, P: Kernel, M> {
    pub(crate) packed: &'a Packed<P>,
    ray: &'a Ray,
    scaling: Scaling,
    leaf_ray: P::LeafRay,
    best: Best,
    method: PhantomData<M>,
}

/// The closest hit so far.
///
/// The exact test of a certain hit is deferred until another candidate could be nearer: most rays
/// need a single exact test, that of the closest primitive.
#[derive(Clone, Copy)]
struct Best {
    id: u32,
    block: usize,
    lane: usize,
    /// The exact `t`, or `None` while its test is deferred.
    t: Option<f32>,
    /// Lower bound on the parameter of the hit.
    near: f32,
    /// The hit, where [`Kernel::KEEP_HIT`] is set.
    hit: Option<Hit>,
}

impl Best {
    const NONE: Self = Self {
        id: NO_ID,
        block: 0,
        lane: 0,
        t: Some(f32::INFINITY),
        near: f32::INFINITY,
        hit: None,
    };
}

impl<'a, P: Kernel, M: MethodTag> ClosestVisitor<'a, P, M> {
    #[inline(always)]
    pub(crate) fn new(packed: &'a Packed<P>, ray: &'a Ray, slab_ray: &SlabRay) -> Self {
        let leaf_ray = P::leaf_ray(slab_ray);
        Self {
            packed,
            ray,
            scaling: slab_ray.scaling,
            leaf_ray,
            best: Best::NONE,
            method: PhantomData,
        }
    }

    /// The exact `t` of a primitive, in the whole interval of the ray and not the shrunken one, so
    /// that the caller can break ties.
    #[inline(always)]
    fn exact<S: Simd>(&self, simd: S, block: usize, lane: usize) -> Option<f32> {
        exact_t::<S, P, M>(simd, &self.packed.blocks[block], lane, self.ray)
    }

    /// Lower bound on the parameter of `t`.
    #[inline(always)]
    fn near(&self, t: f32) -> f32 {
        let t = t * self.scaling.scale;
        t - 4.0 * f32::EPSILON * t.abs() - self.scaling.least
    }
}

impl<S: Simd, P: Kernel, M: MethodTag> traverse::LeafVisitor<S> for ClosestVisitor<'_, P, M> {
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        simd.prefetch(&self.packed.blocks[index]);
    }
}

impl<S: Simd, P: Kernel, M: MethodTag> traverse::ClosestVisitor<S> for ClosestVisitor<'_, P, M> {
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize, limit: f32) -> f32 {
        let task = TestLeaf { visitor: self, index, limit };
        if P::OUTLINE_LEAF { simd.run_outlined(task) } else { task.run(simd) }
    }
}

struct TestLeaf<'a, V> {
    visitor: &'a mut V,
    index: usize,
    limit: f32,
}

impl<P: Kernel, M: MethodTag> WithSimd for TestLeaf<'_, ClosestVisitor<'_, P, M>> {
    type Output = f32;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f32 {
        self.visitor.test(simd, self.index, self.limit)
    }
}

impl<P: Kernel, M: MethodTag> ClosestVisitor<'_, P, M> {
    /// Tests the primitives of a leaf, and returns the new limit.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, index: usize, mut limit: f32) -> f32 {
        let block = &self.packed.blocks[index];
        let Candidates { possible: mut mask, certain, near, far } =
            P::candidates::<S, M>(simd, &self.leaf_ray, block, limit);
        if mask == 0 {
            return limit;
        }
        // Unused lanes repeat the first one.
        mask &= block.used();
        let ids = block.ids();
        let (near, far) = (simd.to_array(near), simd.to_array(far));
        while mask != 0 {
            let mut lane = mask.trailing_zeros() as usize % WIDTH;
            let mut rest = mask & (mask - 1);
            while rest != 0 {
                let other = rest.trailing_zeros() as usize % WIDTH;
                rest &= rest - 1;
                if near[other] < near[lane] {
                    lane = other;
                }
            }
            mask &= !(1 << lane);
            let id = ids[lane];
            if near[lane] > limit {
                continue;
            }
            if certain >> lane & 1 == 1 && far[lane] < self.best.near {
                self.best = Best { id, block: index, lane, t: None, near: near[lane], hit: None };
                limit = Scaling::beyond(far[lane]);
                continue;
            }
            let best_t = match self.best.t {
                Some(t) => t,
                None => {
                    // `None` only if `t` overflows; see `FindClosest`.
                    let t = self.exact(simd, self.best.block, self.best.lane);
                    let t = t.unwrap_or(f32::INFINITY);
                    (self.best.t, self.best.near) = (Some(t), self.near(t));
                    limit = limit.min(self.scaling.limit(t));
                    if near[lane] > limit {
                        continue;
                    }
                    t
                }
            };
            let (t, hit) = if P::KEEP_HIT {
                let hit = exact_hit::<S, P, M>(simd, block, lane, self.ray);
                (hit.map(|hit| hit.t), hit)
            } else {
                (self.exact(simd, index, lane), None)
            };
            if let Some(t) = t
                && (t < best_t || (t == best_t && id < self.best.id))
            {
                self.best = Best { id, block: index, lane, t: Some(t), near: self.near(t), hit };
                limit = self.scaling.limit(t);
            }
        }
        limit
    }
}
