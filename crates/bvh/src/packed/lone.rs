//! Trees of a single primitive: a floor, a wall or a lamp.
//!
//! The exact test takes less time than the wide test of a leaf that may save it.

use super::Packed;
use super::kernel::{HasIds, Kernel, NO_ID};
use super::method_tag::MethodTag;
use crate::found::PrimitiveHit;
use crate::simd::{Simd, WithSimd};
use rotund_geometry::Ray;
use std::marker::PhantomData;

impl<P: Kernel> Packed<P> {
    /// Returns the id and the block of the only primitive of the tree.
    #[inline(always)]
    pub(super) fn lone(&self) -> Option<(u32, &P::Block)> {
        let [block] = self.blocks.as_slice() else { return None };
        let &[id, NO_ID, ..] = block.ids() else { return None };
        Some((id, block))
    }
}

/// The exact test of the first primitive of a block.
pub(super) struct TestLone<'a, P: Kernel, M> {
    id: u32,
    block: &'a P::Block,
    ray: &'a Ray,
    method: PhantomData<M>,
}

impl<'a, P: Kernel, M> TestLone<'a, P, M> {
    #[inline(always)]
    pub(super) fn new((id, block): (u32, &'a P::Block), ray: &'a Ray) -> Self {
        Self { id, block, ray, method: PhantomData }
    }
}

impl<P: Kernel, M: MethodTag> WithSimd for TestLone<'_, P, M> {
    type Output = Option<PrimitiveHit>;

    /// As in a traversal, a ray that is not finite hits nothing.
    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<PrimitiveHit> {
        if !(self.ray.origin.is_finite() && self.ray.direction.is_finite()) {
            return None;
        }
        let hit = P::unpack(self.block, 0).exact_hit::<M>(self.ray)?;
        Some(PrimitiveHit { id: self.id, hit })
    }
}
