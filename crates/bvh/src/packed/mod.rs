//! Trees whose leaves hold the primitives themselves.
//!
//! A leaf is one block of up to eight primitives, next to each other in memory and in the order of
//! the tree. A wide test in single precision, with an error bound, throws out those that the ray
//! cannot hit; the few that are left are put back together, to the bit, and given to the exact test
//! of the geometry crate, nearest first. So the answer is that of a loop over all primitives.

mod cone;
mod flat;
mod kernel;
mod patch;
mod refit;
mod report;
mod sphere;
mod triangle;

use crate::build::{TASK, build};
use crate::found::PrimitiveHit;
use crate::huge;
use crate::isa::Isa;
use crate::node::{Tree, WIDTH};
use crate::simd::{Simd, Task};
use crate::slab::SlabRay;
use crate::traverse;
pub use report::{Statistics, Visits};

use kernel::{Candidates, HasIds, Kernel, NO_ID};
use rayon::prelude::*;
use rotund_geometry::{Aabb, BilinearPatch, Ray, RoundedCone, Sphere, Triangle};

/// A tree over spheres.
pub type SphereTree = Packed<Sphere>;
/// A tree over rounded cones.
pub type ConeTree = Packed<RoundedCone>;
/// A tree over bilinear patches.
pub type PatchTree = Packed<BilinearPatch>;
/// A tree over triangles.
pub type TriangleTree = Packed<Triangle>;

/// The shape that a primitive of a packed tree has for a query. The same tree serves both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Spheres, rounded cones and bilinear patches; triangles.
    #[default]
    Enhanced,
    /// Points, lines and quads, of [`rotund_geometry::vanilla`]; triangles.
    Vanilla,
}

/// A tree over primitives of one kind, each known by its index in the slice the tree was built from.
///
/// ```
/// use rotund_bvh::{Form, SphereTree};
/// use rotund_geometry::{Ray, Sphere, glam::Vec3};
///
/// let spheres: Vec<Sphere> =
///     (0..100).map(|i| Sphere { center: Vec3::X * i as f32, radius: 0.25 }).collect();
/// let tree = SphereTree::build(&spheres);
///
/// let ray = Ray::new(Vec3::new(7.0, 0.0, 5.0), Vec3::NEG_Z);
/// let found = tree.closest(&ray, Form::Enhanced).expect("the ray was aimed at a sphere");
/// assert_eq!((found.id, found.hit.t), (7, 4.75));
/// // The vanilla form of a sphere is a disc through its centre.
/// assert_eq!(tree.closest(&ray, Form::Vanilla).map(|found| found.hit.t), Some(5.0));
/// ```
#[derive(Clone, Debug)]
pub struct Packed<P: Kernel> {
    tree: Tree,
    /// One for each leaf.
    blocks: Vec<P::Block>,
    isa: Isa,
}

impl<P: Kernel> Packed<P> {
    /// Builds a tree on all threads of the current rayon pool. It does not depend on their number.
    ///
    /// Primitives with a number that is not finite are left out.
    ///
    /// # Panics
    ///
    /// If there are more than [`crate::MAX_PRIMITIVES`].
    #[must_use]
    pub fn build(primitives: &[P]) -> Self {
        let bounds = |id: u32| primitives[id as usize].bounds();
        let built = build(primitives.len(), bounds, WIDTH as u32);
        let packed = |range: &std::ops::Range<u32>| {
            let few = &built.ids[range.start as usize..range.end as usize];
            let ids: [u32; WIDTH] =
                std::array::from_fn(|lane| few.get(lane).copied().unwrap_or(NO_ID));
            let lane = |id: u32| primitives[if id == NO_ID { ids[0] } else { id } as usize];
            P::pack(&ids.map(lane), ids)
        };
        let mut blocks = huge::vec_with_capacity(built.leaves.len());
        if primitives.len() <= TASK {
            blocks.extend(built.leaves.iter().map(packed));
        } else {
            built.leaves.par_iter().map(packed).collect_into_vec(&mut blocks);
        }
        Self { tree: built.tree, blocks, isa: Isa::default_set() }
    }

    /// The box of all primitives; [`Aabb::EMPTY`] if there is none.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// The instruction set that this tree is walked with.
    #[must_use]
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// The same tree, walked with another instruction set. The answers are the same.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// Returns the primitive with the smallest `t`, of those the one with the lowest id, and its hit:
    /// the answer, to the bit, of a loop over all primitives.
    ///
    /// A ray whose origin or direction is not finite, or whose direction is zero, meets nothing.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray, form: Form) -> Option<PrimitiveHit> {
        match form {
            Form::Enhanced => self.isa.run(ClosestTask::<P, false> { tree: self, ray }),
            Form::Vanilla => self.isa.run(ClosestTask::<P, true> { tree: self, ray }),
        }
    }

    /// True if the ray hits any primitive: [`Packed::closest`] would find one.
    #[must_use]
    #[inline]
    pub fn any(&self, ray: &Ray, form: Form) -> bool {
        match form {
            Form::Enhanced => self.isa.run(AnyTask::<P, false> { tree: self, ray }),
            Form::Vanilla => self.isa.run(AnyTask::<P, true> { tree: self, ray }),
        }
    }
}

/// The exact `t` of one primitive.
#[inline(always)]
fn exact<S: Simd, P: Kernel, const VANILLA: bool>(
    simd: S,
    block: &P::Block,
    lane: usize,
    ray: &Ray,
) -> Option<f32> {
    let task = Exact::<P, VANILLA> { block, lane, ray };
    if P::APART { simd.run_apart(task) } else { task.run(simd) }
}

struct Exact<'a, P: Kernel, const VANILLA: bool> {
    block: &'a P::Block,
    lane: usize,
    ray: &'a Ray,
}

impl<P: Kernel, const VANILLA: bool> Task for Exact<'_, P, VANILLA> {
    type Output = Option<f32>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<f32> {
        P::unpack(self.block, self.lane).closest_t::<VANILLA>(self.ray)
    }
}

struct ClosestTask<'a, P: Kernel, const VANILLA: bool> {
    tree: &'a Packed<P>,
    ray: &'a Ray,
}

impl<P: Kernel, const VANILLA: bool> Task for ClosestTask<'_, P, VANILLA> {
    type Output = Option<PrimitiveHit>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let slab_ray = SlabRay::new(self.ray)?;
        let mut visitor = FindClosest::<S, P, VANILLA>::new(simd, self.tree, self.ray, &slab_ray);
        let limit = slab_ray.limit(self.ray.t_max);
        traverse::closest(simd, &self.tree.tree, &slab_ray, limit, &mut visitor);
        let best = visitor.best;
        if best.id == NO_ID {
            return None;
        }
        let hit = P::unpack(&self.tree.blocks[best.block], best.lane).closest::<VANILLA>(self.ray);
        debug_assert!(hit.is_some(), "what was sure to be hit is hit");
        Some(PrimitiveHit { id: best.id, hit: hit? })
    }
}

struct FindClosest<'a, S: Simd, P: Kernel, const VANILLA: bool> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    slab_ray: &'a SlabRay,
    lanes: P::Lanes<S>,
    best: Best,
}

/// The closest hit so far.
///
/// Where the wide test is sure, the exact one waits: most rays end with a single exact test, of what is
/// known to be closest. It is made up for as soon as another candidate might be nearer.
#[derive(Clone, Copy)]
struct Best {
    id: u32,
    block: usize,
    lane: usize,
    /// The exact `t`, or `None` while it waits.
    t: Option<f32>,
    /// A bound below the parameter of the hit.
    near: f32,
}

impl Best {
    const NONE: Self =
        Self { id: NO_ID, block: 0, lane: 0, t: Some(f32::INFINITY), near: f32::INFINITY };
}

impl<'a, S: Simd, P: Kernel, const VANILLA: bool> FindClosest<'a, S, P, VANILLA> {
    #[inline(always)]
    fn new(simd: S, packed: &'a Packed<P>, ray: &'a Ray, slab_ray: &'a SlabRay) -> Self {
        Self { packed, ray, slab_ray, lanes: P::lanes(simd, slab_ray), best: Best::NONE }
    }

    /// The exact `t` of a primitive. With the whole interval and not the shrunken one: ties count, and
    /// are settled by the caller.
    #[inline(always)]
    fn exact(&self, simd: S, block: usize, lane: usize) -> Option<f32> {
        exact::<S, P, VANILLA>(simd, &self.packed.blocks[block], lane, self.ray)
    }

    /// A bound below the parameter of `t`.
    #[inline(always)]
    fn near(&self, t: f32) -> f32 {
        let t = t * self.slab_ray.scale;
        t - 4.0 * f32::EPSILON * t.abs() - f32::MIN_POSITIVE
    }
}

impl<S: Simd, P: Kernel, const VANILLA: bool> traverse::Leaves<S>
    for FindClosest<'_, S, P, VANILLA>
{
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        simd.prefetch(&self.packed.blocks[index]);
    }
}

impl<S: Simd, P: Kernel, const VANILLA: bool> traverse::Closest<S>
    for FindClosest<'_, S, P, VANILLA>
{
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize, mut limit: f32) -> f32 {
        let block = &self.packed.blocks[index];
        let Candidates { maybe: mut mask, surely, near, far } =
            P::candidates::<S, VANILLA>(simd, &self.lanes, block, limit);
        if mask == 0 {
            return limit;
        }
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
            if near[lane] > limit || id == NO_ID {
                continue;
            }
            if surely >> lane & 1 == 1 && far[lane] < self.best.near {
                self.best = Best { id, block: index, lane, t: None, near: near[lane] };
                limit = SlabRay::beyond(far[lane]);
                continue;
            }
            let best_t = match self.best.t {
                Some(t) => t,
                None => {
                    let t = self.exact(simd, self.best.block, self.best.lane);
                    debug_assert!(t.is_some(), "what was sure to be hit is hit");
                    let t = t.unwrap_or(f32::INFINITY);
                    (self.best.t, self.best.near) = (Some(t), self.near(t));
                    limit = limit.min(self.slab_ray.limit(t));
                    if near[lane] > limit {
                        continue;
                    }
                    t
                }
            };
            if let Some(t) = self.exact(simd, index, lane)
                && (t < best_t || (t == best_t && id < self.best.id))
            {
                self.best = Best { id, block: index, lane, t: Some(t), near: self.near(t) };
                limit = self.slab_ray.limit(t);
            }
        }
        limit
    }
}

struct AnyTask<'a, P: Kernel, const VANILLA: bool> {
    tree: &'a Packed<P>,
    ray: &'a Ray,
}

impl<P: Kernel, const VANILLA: bool> Task for AnyTask<'_, P, VANILLA> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Some(slab_ray) = SlabRay::new(self.ray) else { return false };
        let limit = slab_ray.limit(self.ray.t_max);
        let mut visitor = FindAny::<S, P, VANILLA> {
            packed: self.tree,
            ray: self.ray,
            lanes: P::lanes(simd, &slab_ray),
            limit,
        };
        traverse::any(simd, &self.tree.tree, &slab_ray, limit, &mut visitor)
    }
}

struct FindAny<'a, S: Simd, P: Kernel, const VANILLA: bool> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    lanes: P::Lanes<S>,
    limit: f32,
}

impl<S: Simd, P: Kernel, const VANILLA: bool> traverse::Leaves<S> for FindAny<'_, S, P, VANILLA> {
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        simd.prefetch(&self.packed.blocks[index]);
    }
}

impl<S: Simd, P: Kernel, const VANILLA: bool> traverse::Any<S> for FindAny<'_, S, P, VANILLA> {
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize) -> bool {
        let block = &self.packed.blocks[index];
        let Candidates { maybe: mut mask, surely, .. } =
            P::candidates::<S, VANILLA>(simd, &self.lanes, block, self.limit);
        if surely != 0 {
            // Also if the lane is not used: it repeats the first.
            return true;
        }
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            if block.ids()[lane] != NO_ID
                && exact::<S, P, VANILLA>(simd, block, lane, self.ray).is_some()
            {
                return true;
            }
        }
        false
    }
}
