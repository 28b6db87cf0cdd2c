//! The tree over boxes, for any primitive.

use crate::build::build;
use crate::found::{Found, PrimitiveHit};
use crate::isa::Isa;
use crate::node::{Child, Node, Tree, WIDTH};
use crate::prim_ref::finite_part;
use crate::refit::RefitError;
use crate::simd::{Simd, StackEntry, WithSimd};
use crate::slab::{Scaling, SlabRay};
use crate::traverse;
use rotund_geometry::{Aabb, Primitive, Ray};

/// A tree over boxes, for primitives of your own.
///
/// The id of a primitive is its index in the slice given to [`build`](Self::build) or
/// [`build_of`](Self::build_of). A primitive must lie inside its box; the parts outside may be
/// missed. Empty boxes and boxes with a NaN are never visited, and are not in [`Bvh::bounds`];
/// [`Bvh::left_out`] counts them.
///
/// There are two ways to query it:
///
/// - [`closest_of`](Self::closest_of) and [`any_of`](Self::any_of), over a slice of a type that
///   implements [`Primitive`];
/// - [`closest`](Self::closest) and [`any`](Self::any), which call back with ids, over anything
///   else. A tree over trees is an example: the callback transforms the ray and queries another
///   tree.
///
/// For spheres, rounded cones, bilinear patches and triangles, [`crate::SphereTree`],
/// [`crate::ConeTree`], [`crate::PatchTree`] and [`crate::TriangleTree`] are faster.
///
/// ```
/// use rotund_bvh::Bvh;
/// use rotund_bvh::geometry::{Aabb, Ray, glam::Vec3};
///
/// // Cubes about points of the x axis, picked by a ray.
/// let boxes: Vec<Aabb> = (0..100)
///     .map(|i| 3.0 * Vec3::X * i as f32)
///     .map(|center| Aabb { min: center - 1.0, max: center + 1.0 })
///     .collect();
/// let bvh = Bvh::build(&boxes);
///
/// let ray = Ray::new(Vec3::new(21.5, 0.0, 5.0), Vec3::NEG_Z);
/// let top_face = |id: u32, ray: &Ray| {
///     let t = (boxes[id as usize].max.z - ray.origin.z) / ray.direction.z;
///     let point = ray.at(t);
///     let inside = (point - boxes[id as usize].center()).abs().truncate().max_element() <= 1.0;
///     inside.then_some((t, point)) // the tree ignores a `t` outside the interval
/// };
/// let found = bvh.closest(&ray, top_face).expect("the ray is aimed at a cube");
/// assert_eq!((found.id, found.t, found.value), (7, 4.0, Vec3::new(21.5, 0.0, 1.0)));
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    tree: Tree,
    isa: Isa,
}

impl Bvh {
    /// Builds a tree over `boxes` on all threads of the current rayon pool. The tree does not
    /// depend on their number.
    ///
    /// # Panics
    ///
    /// If there are more than [`crate::MAX_PRIMITIVES`].
    #[must_use]
    pub fn build(boxes: &[Aabb]) -> Self {
        Self::build_by(boxes.len(), |id| boxes[id as usize])
    }

    /// Builds a tree over the bounds of `primitives`, for [`Bvh::closest_of`] and [`Bvh::any_of`].
    ///
    /// # Panics
    ///
    /// If there are more than [`crate::MAX_PRIMITIVES`].
    #[must_use]
    pub fn build_of<P: Primitive + Sync>(primitives: &[P]) -> Self {
        Self::build_by(primitives.len(), |id| primitives[id as usize].bounds())
    }

    fn build_by(count: usize, bounds: impl Fn(u32) -> Aabb + Sync) -> Self {
        // Callbacks may be expensive, so each primitive is a leaf whose box is tested before the
        // call.
        let built = build(count, bounds, 1);
        // The index of a leaf becomes the id of its primitive, and the leaves are not needed.
        let id = |child: Child| match child {
            Child::NONE => child,
            leaf if leaf.is_leaf() => {
                Child::leaf(built.ids[built.leaves[leaf.index()].start as usize])
            }
            node => node,
        };
        let mut tree = built.tree;
        for node in &mut tree.nodes {
            node.children = node.children.map(id);
        }
        Self { tree, isa: Isa::default_set() }
    }

    /// The union of all boxes that are not empty; [`Aabb::EMPTY`] if there is none. Infinite sides
    /// are clamped to the largest finite numbers, `-f32::MAX` and `f32::MAX`.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// The number of boxes that were given to [`Self::build`] and are not in the tree, because they
    /// are empty or have a NaN.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.tree.left_out()
    }

    /// Moves the boxes: `boxes[i]` becomes the box of primitive `i`. The bounds of all nodes are
    /// recomputed bottom-up; the topology of the tree stays.
    ///
    /// Queries return the same results as a rebuilt tree, but may be slower: where neighbors in the
    /// tree move apart, nodes grow and overlap, and rays visit more of them. Refit while primitives
    /// move together, or by a few of their sizes; build a new tree when queries have slowed down by
    /// more than a build costs. A refit takes a small part of the time of a build.
    ///
    /// # Errors
    ///
    /// If the number of boxes is not that of the build, or if a box that was empty at the build is
    /// not empty now or the reverse (a box with a NaN counts as empty). The tree is then as it was
    /// before the call.
    pub fn refit(&mut self, boxes: &[Aabb]) -> Result<(), RefitError> {
        self.refit_by(boxes.len(), |id| boxes[id as usize])
    }

    /// Moves the boxes to the bounds of `primitives`: `primitives[i]` replaces the primitive `i` of
    /// [`Bvh::build_of`]. [`Bvh::refit`] says when a new tree is better.
    ///
    /// # Errors
    ///
    /// Those of [`Bvh::refit`], for the bounds of `primitives`.
    pub fn refit_of<P: Primitive>(&mut self, primitives: &[P]) -> Result<(), RefitError> {
        self.refit_by(primitives.len(), |id| primitives[id as usize].bounds())
    }

    fn refit_by(&mut self, count: usize, bounds: impl Fn(u32) -> Aabb) -> Result<(), RefitError> {
        let leaves = self.tree.nodes.iter().flat_map(|node| &node.children);
        let leaves = leaves.filter(|child| child.is_leaf() && **child != Child::NONE);
        let ids = leaves.map(|leaf| leaf.index() as u32);
        let is_empty = |id: u32| finite_part(bounds(id)).is_none();
        let any_empty = || ids.clone().any(is_empty);
        self.tree.check_refit(count, any_empty, ids.clone(), is_empty)?;
        self.tree.refit(|id| finite_part(bounds(id as u32)).unwrap_or(Aabb::EMPTY));
        Ok(())
    }

    /// Returns the primitive that the ray hits with the smallest `t`, and the hit: the answer of a
    /// loop over all primitives. A tie goes to the lowest id.
    ///
    /// `primitives` are those that the tree was built over, or refitted to, in the same order.
    ///
    /// A ray whose origin or direction is not finite, or whose direction is zero, hits nothing.
    ///
    /// # Panics
    ///
    /// If the number of primitives is not that of the build.
    #[must_use]
    #[inline]
    pub fn closest_of<P: Primitive>(&self, primitives: &[P], ray: &Ray) -> Option<PrimitiveHit> {
        self.check_count(primitives.len());
        let test = |id: u32, ray: &Ray| {
            let hit = primitives[id as usize].closest(ray)?;
            Some((hit.t, hit))
        };
        let found = self.closest(ray, test)?;
        Some(PrimitiveHit { id: found.id, hit: found.value })
    }

    /// Returns whether the ray hits any of `primitives`, that is, whether [`Bvh::closest_of`] finds
    /// one.
    ///
    /// [`Primitive::any`] decides. It must respect the interval of the ray and agree with
    /// [`Primitive::closest`], as the trait requires: its result is not checked, whereas
    /// [`Bvh::closest_of`] ignores a `t` outside the interval.
    ///
    /// # Panics
    ///
    /// If the number of primitives is not that of the build.
    #[must_use]
    #[inline]
    pub fn any_of<P: Primitive>(&self, primitives: &[P], ray: &Ray) -> bool {
        self.check_count(primitives.len());
        self.any(ray, |id, ray| primitives[id as usize].any(ray))
    }

    #[inline]
    fn check_count(&self, given: usize) {
        let built = self.tree.source_count;
        assert!(
            given == built,
            "the tree was built over {built} primitives and is queried with {given}"
        );
    }

    /// Returns the hit with the smallest `t`, and the value that `test` returned with it. A tie
    /// goes to the lowest id.
    ///
    /// `test` is called with the id of a primitive and the ray. It returns the `t` of the first hit
    /// in `ray.t_min..=ray.t_max` and a value of the caller's choice, or `None` for a miss. A `t`
    /// that is outside the interval or not finite counts as a miss. The `t_max` of the ray in the
    /// call is that of the closest hit so far. Ids come in no particular order, roughly from near
    /// to far, each at most once.
    ///
    /// A ray whose origin or direction is not finite, whose direction is zero, or whose interval is
    /// empty or has a NaN, hits nothing, and `test` is not called.
    #[inline]
    pub fn closest<T>(
        &self,
        ray: &Ray,
        mut test: impl FnMut(u32, &Ray) -> Option<(f32, T)>,
    ) -> Option<Found<T>> {
        // A `t` that is not finite is a miss, also where the interval is infinite.
        let (first, last) = (ray.t_min.max(f32::MIN), ray.t_max.min(f32::MAX));
        let mut shrinking = *ray;
        let mut best: Option<Found<T>> = None;
        self.visit(ray, |id| {
            if let Some((t, value)) = test(id, &shrinking) {
                let wins = match &best {
                    None => t >= first && t <= last,
                    // A tie goes to the lower id, so that the answer does not depend on the order
                    // of traversal.
                    Some(best) => t >= first && (t < best.t || (t == best.t && id < best.id)),
                };
                if wins {
                    best = Some(Found { id, t, value });
                    shrinking.t_max = t;
                }
            }
            shrinking.t_max
        });
        best
    }

    /// Calls `visit` with the ids of primitives whose boxes the ray meets, each at most once,
    /// roughly from near to far. `visit` returns the end of the interval from then on: the `t` of
    /// the closest hit so far, or `ray.t_max` if there is none. [`Bvh::closest`] is built on this.
    ///
    /// A ray that hits nothing there visits nothing here.
    #[inline]
    pub fn visit(&self, ray: &Ray, mut visit: impl FnMut(u32) -> f32) {
        if let [node] = self.tree.nodes.as_slice() {
            // Up to eight boxes need no stack, and `visit` no registers of the traversal.
            let range = self.tree.range;
            let mut met = self.isa.run(Meet { node, range, ray });
            let Some(met) = &mut met else { return };
            while let Some(id) = met.next() {
                met.limit = met.scaling.limit(visit(id));
            }
            return;
        }
        let visitor = ClosestVisitor { scaling: Scaling::USUAL, visit: &mut visit };
        self.isa.run(TraverseClosest { tree: &self.tree, ray, visitor });
    }

    /// Returns whether `test` returns true for any primitive whose box the ray meets.
    ///
    /// `test` is called with the id of a primitive and the ray, in no particular order, each id at
    /// most once, until it returns true. It must test the interval `ray.t_min..=ray.t_max` itself:
    /// boxes are conservative, so it is also called for some primitives that lie outside the
    /// interval or beside the ray, and its answer is final.
    ///
    /// A ray whose origin or direction is not finite, whose direction is zero, or whose interval is
    /// empty or has a NaN, hits nothing: the result is false, and `test` is not called.
    #[inline]
    pub fn any(&self, ray: &Ray, mut test: impl FnMut(u32, &Ray) -> bool) -> bool {
        if let [node] = self.tree.nodes.as_slice() {
            let mut mask = self.isa.run(MeetAny { node, range: self.tree.range, ray });
            while mask != 0 {
                let child = node.children[mask.trailing_zeros() as usize % WIDTH];
                mask &= mask - 1;
                if test(child.index() as u32, ray) {
                    return true;
                }
            }
            return false;
        }
        let visitor = AnyVisitor { ray, test: &mut test };
        self.isa.run(TraverseAny { tree: &self.tree, visitor })
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
}

struct ClosestVisitor<'a, F> {
    scaling: Scaling,
    visit: &'a mut F,
}

impl<S: Simd, F> traverse::LeafVisitor<S> for ClosestVisitor<'_, F> {}

impl<S: Simd, F: FnMut(u32) -> f32> traverse::ClosestVisitor<S> for ClosestVisitor<'_, F> {
    #[inline(always)]
    fn leaf(&mut self, _: S, index: usize, _: f32) -> f32 {
        self.scaling.limit((self.visit)(index as u32))
    }
}

struct TraverseClosest<'a, F> {
    tree: &'a Tree,
    ray: &'a Ray,
    visitor: ClosestVisitor<'a, F>,
}

impl<F: FnMut(u32) -> f32> WithSimd for TraverseClosest<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let Some(slab_ray) = SlabRay::new(self.ray, self.tree.range) else { return };
        self.visitor.scaling = slab_ray.scaling;
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        traverse::closest(simd, self.tree, &slab_ray, limit, &mut self.visitor);
    }
}

/// Finds the children of the only node of a tree that a ray meets.
struct Meet<'a> {
    node: &'a Node,
    range: f32,
    ray: &'a Ray,
}

impl WithSimd for Meet<'_> {
    type Output = Option<Met>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Met> {
        let slab_ray = SlabRay::new(self.ray, self.range)?;
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        let (near, mask) = slab_ray.lanes(simd).test(simd, self.node, simd.splat(limit));
        let entries = traverse::ordered(simd, near, mask, &self.node.children);
        Some(Met { entries, count: mask.count_ones(), limit, scaling: slab_ray.scaling })
    }
}

/// Children that a ray meets, farthest first.
struct Met {
    entries: [StackEntry; WIDTH],
    /// The number of entries that are left.
    count: u32,
    /// The parameter beyond which entries are not visited.
    limit: f32,
    scaling: Scaling,
}

impl Met {
    /// Returns the id of the next entry before the limit.
    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        self.count = self.count.checked_sub(1)?;
        let entry = self.entries[self.count as usize % WIDTH];
        // As in `traverse::closest`.
        (entry.near() <= self.limit.max(f32::MIN_POSITIVE)).then(|| entry.child().index() as u32)
    }
}

/// Finds the children of the only node of a tree that a ray meets, as a mask.
struct MeetAny<'a> {
    node: &'a Node,
    range: f32,
    ray: &'a Ray,
}

impl WithSimd for MeetAny<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u32 {
        let Some(slab_ray) = SlabRay::new(self.ray, self.range) else { return 0 };
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        slab_ray.lanes(simd).test(simd, self.node, simd.splat(limit)).1
    }
}

struct AnyVisitor<'a, F> {
    ray: &'a Ray,
    test: &'a mut F,
}

impl<S: Simd, F> traverse::LeafVisitor<S> for AnyVisitor<'_, F> {}

impl<S: Simd, F: FnMut(u32, &Ray) -> bool> traverse::AnyVisitor<S> for AnyVisitor<'_, F> {
    #[inline(always)]
    fn leaf(&mut self, _: S, index: usize) -> bool {
        (self.test)(index as u32, self.ray)
    }
}

struct TraverseAny<'a, F> {
    tree: &'a Tree,
    visitor: AnyVisitor<'a, F>,
}

impl<F: FnMut(u32, &Ray) -> bool> WithSimd for TraverseAny<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> bool {
        let ray = self.visitor.ray;
        let Some(slab_ray) = SlabRay::new(ray, self.tree.range) else { return false };
        let limit = slab_ray.scaling.limit(ray.t_max);
        traverse::any(simd, self.tree, &slab_ray, limit, &mut self.visitor)
    }
}
