//! Any-hit traversal of packed trees.

use super::Packed;
use super::exact::exact_t;
use super::kernel::{Candidates, HasIds, Kernel};
use super::method_tag::MethodTag;
use crate::node::WIDTH;
use crate::simd::{Simd, WithSimd};
use crate::slab::SlabRay;
use crate::traverse;
use rotund_geometry::Ray;
use std::marker::PhantomData;

/// Finds out whether there is a hit.
pub(crate) struct FindAny<'a, P: Kernel, M> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    method: PhantomData<M>,
}

impl<'a, P: Kernel, M: MethodTag> FindAny<'a, P, M> {
    #[inline(always)]
    pub(crate) fn new(packed: &'a Packed<P>, ray: &'a Ray) -> Self {
        Self { packed, ray, method: PhantomData }
    }
}

impl<P: Kernel, M: MethodTag> WithSimd for FindAny<'_, P, M> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Some(slab_ray) = SlabRay::new(self.ray, self.packed.tree.range) else { return false };
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        let mut visitor = AnyVisitor::<P, M> {
            packed: self.packed,
            ray: self.ray,
            leaf_ray: P::leaf_ray(&slab_ray),
            limit,
            method: PhantomData,
        };
        traverse::any(simd, &self.packed.tree, &slab_ray, limit, &mut visitor)
    }
}

/// Tests leaves until there is a hit.
struct AnyVisitor<'a, P: Kernel, M> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    leaf_ray: P::LeafRay,
    limit: f32,
    method: PhantomData<M>,
}

impl<S: Simd, P: Kernel, M: MethodTag> traverse::LeafVisitor<S> for AnyVisitor<'_, P, M> {
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        simd.prefetch(&self.packed.blocks[index]);
    }
}

impl<S: Simd, P: Kernel, M: MethodTag> traverse::AnyVisitor<S> for AnyVisitor<'_, P, M> {
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize) -> bool {
        let task = TestLeaf { visitor: self, index };
        if P::OUTLINE_LEAF { simd.run_outlined(task) } else { task.run(simd) }
    }
}

struct TestLeaf<'a, V> {
    visitor: &'a V,
    index: usize,
}

impl<P: Kernel, M: MethodTag> WithSimd for TestLeaf<'_, AnyVisitor<'_, P, M>> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        self.visitor.test(simd, self.index)
    }
}

impl<P: Kernel, M: MethodTag> AnyVisitor<'_, P, M> {
    /// Returns whether the ray hits a primitive of a leaf.
    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, index: usize) -> bool {
        let block = &self.packed.blocks[index];
        let Candidates { possible: mut mask, certain, .. } =
            P::candidates::<S, M>(simd, &self.leaf_ray, block, self.limit);
        if certain != 0 {
            // Even in an unused lane, which repeats the first one.
            return true;
        }
        if mask == 0 {
            return false;
        }
        mask &= block.used();
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            if exact_t::<S, P, M>(simd, block, lane, self.ray).is_some() {
                return true;
            }
        }
        false
    }
}
