//! Trees whose leaves hold the primitives themselves.
//!
//! A leaf is one block of up to eight primitives, adjacent in memory and in the order of the tree.
//! A wide test in single precision, with an error bound, rejects those that the ray cannot hit. The
//! others are unpacked, to the bit, and given to the exact test of the geometry crate, nearest
//! first. So the answer is that of a loop over all primitives.

mod any;
mod closest;
mod cone;
mod crossings;
mod exact;
mod flat;
mod kernel;
mod lone;
mod method_tag;
mod patch;
mod patch_crossing;
mod pieces;
mod place;
mod refit;
mod report;
mod round;
mod sphere;
mod triangle;
mod union;
mod vec3;

use crate::build::{SEQUENTIAL_LIMIT, build};
use crate::found::PrimitiveHit;
use crate::huge_pages;
use crate::isa::Isa;
use crate::node::{Tree, WIDTH};
use any::FindAny;
use closest::FindClosest;
use kernel::{Kernel, NO_ID};
use lone::TestLone;
use method_tag::{Enhanced, Vanilla};
use place::WriteTo;
use rayon::prelude::*;
use rotund_geometry::{Aabb, BilinearPatch, Method, Ray, RoundedCone, Sphere, Triangle};

pub use report::{Statistics, Visits};
pub use union::Start;

/// A tree over spheres; vanilla: points.
///
/// ```
/// use rotund_bvh::geometry::{Ray, Sphere, glam::Vec3};
/// use rotund_bvh::{Method, SphereTree};
///
/// let spheres: Vec<Sphere> =
///     (0..100).map(|i| Sphere { center: Vec3::X * i as f32, radius: 0.25 }).collect();
/// let tree = SphereTree::build(&spheres);
///
/// let ray = Ray::new(Vec3::new(7.0, 0.0, 5.0), Vec3::NEG_Z);
/// let found = tree.closest(&ray, Method::Enhanced).expect("the ray is aimed at a sphere");
/// assert_eq!((found.id, found.hit.t), (7, 4.75));
/// // The vanilla method replaces a sphere by a disc through its center.
/// assert_eq!(tree.closest(&ray, Method::Vanilla).map(|found| found.hit.t), Some(5.0));
/// assert!(!tree.any(&Ray { t_max: 4.0, ..ray }, Method::Enhanced));
/// ```
pub type SphereTree = Packed<Sphere>;

/// A tree over rounded cones; vanilla: lines, ribbons that face the ray.
pub type ConeTree = Packed<RoundedCone>;

/// A tree over bilinear patches; vanilla: quads of two triangles.
pub type PatchTree = Packed<BilinearPatch>;

/// A tree over triangles, which are the same with both methods.
pub type TriangleTree = Packed<Triangle>;

/// A tree over primitives of one kind, written as [`SphereTree`], [`ConeTree`], [`PatchTree`] or
/// [`TriangleTree`].
///
/// The id of a primitive is its index in the slice given to [`build`](Self::build). The tree has
/// its own copy of the primitives, so the slice need not be kept. The [`Method`] is chosen for each
/// query, and the same tree serves both.
///
/// # Range
///
/// The answers are those of a loop over all primitives in the whole range of `f32`, with every
/// instruction set. The wide test of a leaf works in `f32`, where products of three lengths must
/// not overflow. So it is used for coordinates, with radii, and origins of rays of up to
/// `2³⁸ = 2.7e11` in absolute value. For rays from farther away, and for all rays if one primitive
/// reaches farther, each primitive of a leaf gets the exact test, which is slower.
#[derive(Clone, Debug)]
pub struct Packed<P: Kernel> {
    tree: Tree,
    /// The primitives of each leaf.
    blocks: Vec<P::Block>,
    isa: Isa,
}

impl<P: Kernel> Packed<P> {
    /// Builds a tree on all threads of the current rayon pool. The tree does not depend on their
    /// number.
    ///
    /// Primitives that no ray can hit (with a number that is not finite, or spheres without radius)
    /// are left out; [`Self::left_out`] counts them.
    ///
    /// # Panics
    ///
    /// If there are more than [`crate::MAX_PRIMITIVES`].
    #[must_use]
    pub fn build(primitives: &[P]) -> Self {
        let bounds = |id: u32| primitives[id as usize].tree_bounds();
        let built = build(primitives.len(), bounds, WIDTH as u32);
        let pack = |range: &std::ops::Range<u32>| {
            let leaf_ids = &built.ids[range.start as usize..range.end as usize];
            let ids: [u32; WIDTH] =
                std::array::from_fn(|lane| leaf_ids.get(lane).copied().unwrap_or(NO_ID));
            let lane = |id: u32| primitives[if id == NO_ID { ids[0] } else { id } as usize];
            P::pack(&ids.map(lane), ids)
        };
        let mut blocks = huge_pages::vec_with_capacity(built.leaves.len());
        if primitives.len() <= SEQUENTIAL_LIMIT {
            blocks.extend(built.leaves.iter().map(pack));
        } else {
            built.leaves.par_iter().map(pack).collect_into_vec(&mut blocks);
        }
        Self { tree: built.tree, blocks, isa: Isa::default_set() }
    }

    /// The box of all primitives; [`Aabb::EMPTY`] if there is none.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// The number of primitives that were given to [`Self::build`] and are not in the tree, because
    /// no ray can hit them.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.tree.left_out()
    }

    /// The instruction set of traversal.
    #[must_use]
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// The same tree, traversed with another instruction set. The answers are the same.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// Returns the primitive that the ray hits with the smallest `t` in `ray.t_min..=ray.t_max`,
    /// and the hit. A tie goes to the lowest id: the answer is that of a loop over all primitives,
    /// to the bit.
    ///
    /// A ray whose origin or direction is not finite, or whose direction is zero, hits nothing.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray, method: Method) -> Option<PrimitiveHit> {
        if let Some(lone) = self.lone() {
            let mut found = None;
            self.lone_hit(lone, ray, method, &mut found);
            return found;
        }
        match method {
            Method::Enhanced => self.isa.run(FindClosest::<P, Enhanced>::new(self, ray)),
            Method::Vanilla => self.isa.run(FindClosest::<P, Vanilla>::new(self, ray)),
        }
    }

    /// Writes the result of [`Packed::closest`] to `place`, for a caller that keeps it there: that
    /// is faster than to copy it.
    #[inline]
    pub fn closest_to(&self, ray: &Ray, method: Method, place: &mut Option<PrimitiveHit>) {
        if let Some(lone) = self.lone() {
            return self.lone_hit(lone, ray, method, place);
        }
        match method {
            Method::Enhanced => {
                let query = FindClosest::<P, Enhanced>::new(self, ray);
                self.isa.run(WriteTo { place, query });
            }
            Method::Vanilla => {
                let query = FindClosest::<P, Vanilla>::new(self, ray);
                self.isa.run(WriteTo { place, query });
            }
        }
    }

    /// Returns whether the ray hits any primitive, that is, whether [`Packed::closest`] finds one.
    #[must_use]
    #[inline]
    pub fn any(&self, ray: &Ray, method: Method) -> bool {
        if let Some(lone) = self.lone() {
            let mut found = None;
            self.lone_hit(lone, ray, method, &mut found);
            return found.is_some();
        }
        match method {
            Method::Enhanced => self.isa.run(FindAny::<P, Enhanced>::new(self, ray)),
            Method::Vanilla => self.isa.run(FindAny::<P, Vanilla>::new(self, ray)),
        }
    }

    #[inline(never)]
    fn lone_hit(
        &self,
        lone: (u32, &P::Block),
        ray: &Ray,
        method: Method,
        place: &mut Option<PrimitiveHit>,
    ) {
        match method {
            Method::Enhanced => {
                let query = TestLone::<P, Enhanced>::new(lone, ray);
                self.isa.run(WriteTo { place, query });
            }
            Method::Vanilla => {
                let query = TestLone::<P, Vanilla>::new(lone, ray);
                self.isa.run(WriteTo { place, query });
            }
        }
    }
}
