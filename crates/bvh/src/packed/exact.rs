//! The exact test of one lane of a block.

use super::kernel::Kernel;
use super::method_tag::MethodTag;
use crate::simd::{Simd, WithSimd};
use rotund_geometry::{Hit, Ray};
use std::marker::PhantomData;

/// The exact `t` of the primitive in a lane.
#[inline(always)]
pub(crate) fn exact_t<S: Simd, P: Kernel, M: MethodTag>(
    simd: S,
    block: &P::Block,
    lane: usize,
    ray: &Ray,
) -> Option<f32> {
    let task = ExactT::<P, M> { block, lane, ray, method: PhantomData };
    if P::OUTLINE_EXACT_TEST { simd.run_outlined(task) } else { task.run(simd) }
}

/// The hit of the exact test of the primitive in a lane.
#[inline(always)]
pub(crate) fn exact_hit<S: Simd, P: Kernel, M: MethodTag>(
    simd: S,
    block: &P::Block,
    lane: usize,
    ray: &Ray,
) -> Option<Hit> {
    let task = ExactHit::<P, M> { block, lane, ray, method: PhantomData };
    if P::OUTLINE_EXACT_TEST { simd.run_outlined(task) } else { task.run(simd) }
}

struct ExactHit<'a, P: Kernel, M> {
    block: &'a P::Block,
    lane: usize,
    ray: &'a Ray,
    method: PhantomData<M>,
}

impl<P: Kernel, M: MethodTag> WithSimd for ExactHit<'_, P, M> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<Hit> {
        P::unpack(self.block, self.lane).exact_hit::<M>(self.ray)
    }
}

struct ExactT<'a, P: Kernel, M> {
    block: &'a P::Block,
    lane: usize,
    ray: &'a Ray,
    method: PhantomData<M>,
}

impl<P: Kernel, M: MethodTag> WithSimd for ExactT<'_, P, M> {
    type Output = Option<f32>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<f32> {
        P::unpack(self.block, self.lane).exact_t::<M>(self.ray)
    }
}
