//! All crossings of a ray in order.

use super::Packed;
use super::kernel::{Candidates, HasIds, Kernel, NO_ID};
use super::method_tag::{Enhanced, MethodTag, Vanilla};
use crate::found::Crossing;
use crate::node::WIDTH;
use crate::simd::{Simd, WithSimd};
use crate::slab::SlabRay;
use crate::traverse;
use rotund_geometry::{Method, Ray};
use smallvec::SmallVec;
use std::marker::PhantomData;
use std::ops::ControlFlow;

/// Number of crossings, or of intervals inside solids, of a ray that are collected on the stack;
/// more are collected on the heap.
pub(super) const INLINE: usize = 64;

impl<P: Kernel> Packed<P> {
    /// Calls `visit` with every crossing of the ray with `t` in `ray.t_min..=ray.t_max`, in the
    /// order of `t`, until it returns [`ControlFlow::Break`]; returns what it returned last.
    ///
    /// Of equal `t`, the lower id comes first, and of one primitive the entry. The crossings are
    /// those of a loop over all primitives, to the bit. Their number is not limited. Up to 64 are
    /// collected without allocation.
    ///
    /// A caller that steps past each hit with a new ray finds the same crossings only roughly: it
    /// misses those that follow within the rounding of `t`, and pays a traversal for each.
    ///
    /// ```
    /// use rotund_bvh::geometry::{Ray, Sphere, glam::Vec3};
    /// use rotund_bvh::{Method, SphereTree};
    /// use std::ops::ControlFlow;
    ///
    /// let spheres = [0.0, 1.0].map(|x| Sphere { center: Vec3::X * x, radius: 1.0 });
    /// let tree = SphereTree::build(&spheres);
    /// let mut found = Vec::new();
    /// let ray = Ray::new(Vec3::new(-3.0, 0.0, 0.0), Vec3::X);
    /// _ = tree.crossings(&ray, Method::Enhanced, |crossing| {
    ///     found.push((crossing.hit.t, crossing.id, crossing.enters));
    ///     ControlFlow::Continue(())
    /// });
    /// assert_eq!(found, [(2.0, 0, true), (3.0, 1, true), (4.0, 0, false), (5.0, 1, false)]);
    /// ```
    pub fn crossings(
        &self,
        ray: &Ray,
        method: Method,
        mut visit: impl FnMut(&Crossing) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut found = match method {
            Method::Enhanced => self.isa.run(FindAll::<P, Enhanced>::new(self, ray)),
            Method::Vanilla => self.isa.run(FindAll::<P, Vanilla>::new(self, ray)),
        };
        let key = |crossing: &Crossing| (crossing.id, !crossing.enters);
        found.sort_unstable_by(|a, b| {
            // No `t` is NaN.
            let by_t = a.hit.t.partial_cmp(&b.hit.t).unwrap_or(std::cmp::Ordering::Equal);
            by_t.then_with(|| key(a).cmp(&key(b)))
        });
        found.iter().try_for_each(&mut visit)
    }
}

/// Collects all crossings.
struct FindAll<'a, P: Kernel, M> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    method: PhantomData<M>,
}

impl<'a, P: Kernel, M: MethodTag> FindAll<'a, P, M> {
    #[inline(always)]
    fn new(packed: &'a Packed<P>, ray: &'a Ray) -> Self {
        Self { packed, ray, method: PhantomData }
    }
}

impl<P: Kernel, M: MethodTag> WithSimd for FindAll<'_, P, M> {
    type Output = SmallVec<[Crossing; INLINE]>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Some(slab_ray) = SlabRay::new(self.ray, self.packed.tree.range) else {
            return SmallVec::new();
        };
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        let mut visitor = AllVisitor::<P, M> {
            packed: self.packed,
            ray: self.ray,
            leaf_ray: P::leaf_ray(&slab_ray),
            limit,
            found: SmallVec::new(),
            method: PhantomData,
        };
        traverse::any(simd, &self.packed.tree, &slab_ray, limit, &mut visitor);
        visitor.found
    }
}

/// Collects the crossings of leaves.
struct AllVisitor<'a, P: Kernel, M> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    leaf_ray: P::LeafRay,
    limit: f32,
    found: SmallVec<[Crossing; INLINE]>,
    method: PhantomData<M>,
}

impl<S: Simd, P: Kernel, M: MethodTag> traverse::LeafVisitor<S> for AllVisitor<'_, P, M> {
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        simd.prefetch(&self.packed.blocks[index]);
    }
}

impl<S: Simd, P: Kernel, M: MethodTag> traverse::AnyVisitor<S> for AllVisitor<'_, P, M> {
    /// Never stops the traversal.
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize) -> bool {
        let block = &self.packed.blocks[index];
        let Candidates { possible: mut mask, .. } =
            P::candidates::<S, M>(simd, &self.leaf_ray, block, self.limit);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            let id = block.ids()[lane];
            if id != NO_ID {
                let found = &mut self.found;
                P::unpack(block, lane).exact_crossings::<M>(self.ray, |hit, enters| {
                    found.push(Crossing { id, hit, enters });
                });
            }
        }
        false
    }
}
