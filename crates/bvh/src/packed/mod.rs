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
mod sphere;
mod triangle;

use crate::build::build;
use crate::isa::Isa;
use crate::node::{Tree, WIDTH};
use crate::sah::Costs;
use crate::simd::{Simd, Task};
use crate::slab::SlabRay;
use crate::traverse;
use kernel::Kernel;
use rayon::prelude::*;
use rotund_geometry::{Aabb, BilinearPatch, Hit, Ray, RoundedCone, Sphere, Triangle};

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
/// let (id, hit) = tree.closest(&ray, Form::Enhanced).expect("the ray was aimed at a sphere");
/// assert_eq!((id, hit.t), (7, 4.75));
/// // The vanilla form of a sphere is a disc through its centre.
/// assert_eq!(tree.closest(&ray, Form::Vanilla).map(|(id, hit)| (id, hit.t)), Some((7, 5.0)));
/// ```
#[derive(Clone, Debug)]
pub struct Packed<P: Kernel> {
    tree: Tree,
    /// One for each leaf.
    blocks: Vec<P::Block>,
    /// The primitives of each block, [`NO_ID`] for lanes that are not used.
    ids: Vec<[u32; WIDTH]>,
    isa: Isa,
}

const NO_ID: u32 = u32::MAX;

impl<P: Kernel> Packed<P> {
    /// Builds a tree on all threads of the current rayon pool. It does not depend on their number.
    ///
    /// Primitives with a number that is not finite are left out.
    ///
    /// # Panics
    ///
    /// If there are more than 2^31 - 2 primitives.
    #[must_use]
    pub fn build(primitives: &[P]) -> Self {
        let costs = Costs { block: 2.0, block_size: WIDTH as u32, leaf_size: WIDTH as u32 };
        let built = build(primitives.len(), |id| primitives[id as usize].bounds(), &costs);
        let packed = |range: &std::ops::Range<u32>| {
            let records = &built.records[range.start as usize..range.end as usize];
            let ids: [u32; WIDTH] =
                std::array::from_fn(|lane| records.get(lane).map_or(NO_ID, |record| record.id()));
            let lane = |id: u32| primitives[if id == NO_ID { ids[0] } else { id } as usize];
            (P::pack(&ids.map(lane)), ids)
        };
        let (blocks, ids) = built.leaves.par_iter().map(packed).unzip();
        Self { tree: built.tree, blocks, ids, isa: Isa::default_set() }
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
    pub fn closest(&self, ray: &Ray, form: Form) -> Option<(u32, Hit)> {
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

struct ClosestTask<'a, P: Kernel, const VANILLA: bool> {
    tree: &'a Packed<P>,
    ray: &'a Ray,
}

impl<P: Kernel, const VANILLA: bool> Task for ClosestTask<'_, P, VANILLA> {
    type Output = Option<(u32, Hit)>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let slab_ray = SlabRay::new(self.ray)?;
        let mut visitor = FindClosest::<S, P, VANILLA> {
            packed: self.tree,
            ray: self.ray,
            slab_ray: &slab_ray,
            lanes: P::lanes(simd, &slab_ray),
            t: f32::INFINITY,
            id: NO_ID,
            block: 0,
            lane: 0,
        };
        let limit = slab_ray.limit(self.ray.t_max);
        traverse::closest(simd, &self.tree.tree, &slab_ray, limit, &mut visitor);
        if visitor.id == NO_ID {
            return None;
        }
        let primitive = P::unpack(&self.tree.blocks[visitor.block], visitor.lane);
        let hit = primitive.closest::<VANILLA>(self.ray)?;
        debug_assert_eq!(hit.t, visitor.t, "the two exact tests agree");
        Some((visitor.id, hit))
    }
}

struct FindClosest<'a, S: Simd, P: Kernel, const VANILLA: bool> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
    slab_ray: &'a SlabRay,
    lanes: P::Lanes<S>,
    t: f32,
    id: u32,
    block: usize,
    lane: usize,
}

impl<S: Simd, P: Kernel, const VANILLA: bool> traverse::Closest<S>
    for FindClosest<'_, S, P, VANILLA>
{
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize, mut limit: f32) -> f32 {
        let block = &self.packed.blocks[index];
        let (mut mask, near) = P::candidates(simd, &self.lanes, block, limit);
        if mask == 0 {
            return limit;
        }
        let ids = &self.packed.ids[index];
        let near = simd.to_array(near);
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
            // The whole interval and not the shrunken one: ties count, and are settled here.
            if let Some(t) = P::unpack(block, lane).closest_t::<VANILLA>(self.ray)
                && (t < self.t || (t == self.t && id < self.id))
            {
                (self.t, self.id, self.block, self.lane) = (t, id, index, lane);
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

impl<S: Simd, P: Kernel, const VANILLA: bool> traverse::Any<S> for FindAny<'_, S, P, VANILLA> {
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize) -> bool {
        let block = &self.packed.blocks[index];
        let (mut mask, _) = P::candidates(simd, &self.lanes, block, self.limit);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            if self.packed.ids[index][lane] != NO_ID
                && P::unpack(block, lane).closest_t::<VANILLA>(self.ray).is_some()
            {
                return true;
            }
        }
        false
    }
}
