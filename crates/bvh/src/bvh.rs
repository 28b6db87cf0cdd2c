//! The tree over plain boxes.

use crate::build::build;
use crate::found::Found;
use crate::isa::Isa;
use crate::node::{Child, Tree};
use crate::record::finite_part;
use crate::refit::RefitError;
use crate::simd::{Simd, Task};
use crate::slab::SlabRay;
use crate::traverse;
use rotund_geometry::{Aabb, Ray};

/// A tree over boxes, each known by its index in the slice the tree was built from. What is inside
/// a box is the business of the closures given to [`Bvh::closest`] and [`Bvh::any`].
///
/// Every primitive must lie inside its box; one that reaches out may be missed. A box that is empty
/// or has a NaN is never visited, and so is not in [`Bvh::bounds`]. A tree over trees needs nothing
/// more: the closure moves the ray and asks another tree.
///
/// ```
/// use rotund_bvh::Bvh;
/// use rotund_geometry::{Aabb, Ray, glam::Vec3};
///
/// /// A torus about the z axis. `intersect` marches along the ray.
/// struct Torus { center: Vec3, major: f32, minor: f32 }
///
/// impl Torus {
///     fn bounds(&self) -> Aabb {
///         let half = Vec3::new(self.major + self.minor, self.major + self.minor, self.minor);
///         Aabb { min: self.center - half, max: self.center + half }
///     }
///
///     fn intersect(&self, ray: &Ray) -> Option<f32> {
///         let mut t = ray.t_min;
///         for _ in 0..256 {
///             let p = ray.at(t) - self.center;
///             let distance = (p.truncate().length() - self.major).hypot(p.z) - self.minor;
///             if distance < 1e-5 {
///                 return Some(t);
///             }
///             t += distance / ray.direction.length();
///             if t > ray.t_max {
///                 break;
///             }
///         }
///         None
///     }
/// }
///
/// let tori: Vec<Torus> = (0..100)
///     .map(|i| Torus { center: Vec3::new(3.0 * i as f32, 0.0, 0.0), major: 1.0, minor: 0.25 })
///     .collect();
/// let boxes: Vec<Aabb> = tori.iter().map(Torus::bounds).collect();
/// let bvh = Bvh::build(&boxes);
///
/// let down_at_the_seventh = Ray::new(Vec3::new(22.0, 0.0, 5.0), Vec3::NEG_Z);
/// let found = bvh
///     .closest(&down_at_the_seventh, |id, ray| Some((tori[id as usize].intersect(ray)?, ())))
///     .expect("the ray was aimed at the ring");
/// assert_eq!(found.id, 7);
/// assert!((found.t - 4.75).abs() < 1e-4);
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    tree: Tree,
    isa: Isa,
}

impl Bvh {
    /// Builds a tree over `boxes` on all threads of the current rayon pool. The tree does not depend
    /// on their number.
    ///
    /// # Panics
    ///
    /// If there are more than [`crate::MAX_PRIMITIVES`].
    #[must_use]
    pub fn build(boxes: &[Aabb]) -> Self {
        // A closure may be dear, so each box is looked at before its closure is called.
        let built = build(boxes.len(), |id| boxes[id as usize], 1);
        // A leaf is one box: name the box itself and forget the leaves.
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

    /// The union of all boxes that are not empty; [`Aabb::EMPTY`] if there is none.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds
    }

    /// Moves the boxes of the tree to new places: `boxes[i]` is the new box of the primitive `i`. The bounds of
    /// all nodes are recomputed bottom-up; the topology stays.
    ///
    /// Answers are those of a tree built anew. Their cost is not: neighbours in the tree that move apart make its
    /// nodes overlap, and rays visit more of them. Refit while primitives move together or by less than the size
    /// of a leaf; build a new tree once queries have become slower than a build is worth. A refit takes
    /// a small part of the time of a build.
    ///
    /// # Errors
    ///
    /// If there are more or fewer boxes than the tree was built from, or if a box that was empty is not any more or the
    /// reverse. The tree is then as it was. (A box with a NaN is empty.)
    pub fn refit(&mut self, boxes: &[Aabb]) -> Result<(), RefitError> {
        let leaves = self.tree.nodes.iter().flat_map(|node| &node.children);
        let ids = leaves.filter(|child| child.is_leaf() && **child != Child::NONE);
        let ids = ids.map(|child| child.index() as u32);
        let is_empty = |id: u32| finite_part(boxes[id as usize]).is_none();
        let any_empty = || ids.clone().any(is_empty);
        self.tree.check_refit(boxes.len(), any_empty, ids.clone(), is_empty)?;
        self.tree.refit(|id| finite_part(boxes[id]).unwrap_or(Aabb::EMPTY));
        Ok(())
    }

    /// Returns the hit with the smallest `t`, of those the one with the smallest id, and what `test`
    /// gave with it.
    ///
    /// `test` is given an id and the ray, and returns where the ray meets that primitive, with
    /// `t` in `ray.t_min..=ray.t_max`; other answers, also NaN, count as a miss. The `t_max` of the
    /// ray it is given shrinks to the closest hit so far. Ids come in no particular order, roughly
    /// from near to far, each at most once.
    ///
    /// A ray whose origin or direction is not finite, or whose direction is zero, meets nothing.
    #[inline]
    pub fn closest<T>(
        &self,
        ray: &Ray,
        mut test: impl FnMut(u32, &Ray) -> Option<(f32, T)>,
    ) -> Option<Found<T>> {
        let slab_ray = SlabRay::new(ray)?;
        let mut visitor =
            FindClosest { slab_ray: &slab_ray, ray, shrinking: *ray, best: None, test: &mut test };
        self.isa.run(WalkClosest { tree: &self.tree, visitor: &mut visitor });
        visitor.best
    }

    /// True if `test` is true for any primitive whose box the ray meets.
    ///
    /// Ids come in no particular order, each at most once, until one answers true.
    #[inline]
    pub fn any(&self, ray: &Ray, mut test: impl FnMut(u32, &Ray) -> bool) -> bool {
        let Some(slab_ray) = SlabRay::new(ray) else { return false };
        let visitor = FindAny { ray, test: &mut test };
        self.isa.run(WalkAny { tree: &self.tree, slab_ray: &slab_ray, visitor })
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
}

struct FindClosest<'a, T, F> {
    slab_ray: &'a SlabRay,
    ray: &'a Ray,
    shrinking: Ray,
    best: Option<Found<T>>,
    test: &'a mut F,
}

impl<S: Simd, T, F> traverse::Leaves<S> for FindClosest<'_, T, F> {}

impl<S: Simd, T, F: FnMut(u32, &Ray) -> Option<(f32, T)>> traverse::Closest<S>
    for FindClosest<'_, T, F>
{
    #[inline(always)]
    fn leaf(&mut self, _: S, index: usize, limit: f32) -> f32 {
        let id = index as u32;
        let Some((t, value)) = (self.test)(id, &self.shrinking) else {
            return limit;
        };
        let wins = match &self.best {
            None => t >= self.ray.t_min && t <= self.ray.t_max,
            // A tie goes to the lower id, so that the order of the walk does not show.
            Some(best) => t >= self.ray.t_min && (t < best.t || (t == best.t && id < best.id)),
        };
        if !wins {
            return limit;
        }
        self.best = Some(Found { id, t, value });
        self.shrinking.t_max = t;
        self.slab_ray.limit(t)
    }
}

struct WalkClosest<'a, 'b, T, F> {
    tree: &'a Tree,
    visitor: &'a mut FindClosest<'b, T, F>,
}

impl<T, F: FnMut(u32, &Ray) -> Option<(f32, T)>> Task for WalkClosest<'_, '_, T, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let ray = self.visitor.slab_ray;
        let limit = ray.limit(self.visitor.ray.t_max);
        traverse::closest(simd, self.tree, ray, limit, self.visitor);
    }
}

struct FindAny<'a, F> {
    ray: &'a Ray,
    test: &'a mut F,
}

impl<S: Simd, F> traverse::Leaves<S> for FindAny<'_, F> {}

impl<S: Simd, F: FnMut(u32, &Ray) -> bool> traverse::Any<S> for FindAny<'_, F> {
    #[inline(always)]
    fn leaf(&mut self, _: S, index: usize) -> bool {
        (self.test)(index as u32, self.ray)
    }
}

struct WalkAny<'a, F> {
    tree: &'a Tree,
    slab_ray: &'a SlabRay,
    visitor: FindAny<'a, F>,
}

impl<F: FnMut(u32, &Ray) -> bool> Task for WalkAny<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> bool {
        let limit = self.slab_ray.limit(self.visitor.ray.t_max);
        traverse::any(simd, self.tree, self.slab_ray, limit, &mut self.visitor)
    }
}
