//! The union of the solids of a tree as one body.
//!
//! A line is inside the union where it is inside any solid. A boundary of the union is where the
//! intervals of the line inside the solids begin to cover it, or cease to. To find the exit from
//! inside, the traversal *hops*: of the intervals that contain the present end, the one that ends
//! last moves it, until none does. Each hop visits what contains one point, so the cost grows with
//! the number of solids on the way, and no list of them is kept.
//!
//! Whether an interval begins before another ends is decided by their `f64` ends if they differ by
//! more than their errors, else with 106 bits. Solids are closed: where two touch, there is no gap.

use super::Packed;
use super::crossings::INLINE;
use super::kernel::{Candidates, HasIds, Kernel, NO_ID};
use super::method_tag::Enhanced;
use super::pieces::{Piece, Pieces, piece};
use crate::found::Crossing;
use crate::node::WIDTH;
use crate::simd::{Simd, WithSimd};
use crate::slab::{Scaling, SlabRay};
use crate::traverse;
use rotund_geometry::glam::Vec3;
use rotund_geometry::{End, Interval, Method, Ray, Solid};
use smallvec::SmallVec;
use std::cmp::Ordering;
use std::ops::ControlFlow;

/// What is known about the start of a ray, at `t_min`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Start {
    /// The position decides: the ray starts inside if an interval begins before `t_min` and ends
    /// there or later.
    #[default]
    ByPosition,
    /// The ray starts outside, because it leaves a boundary of the union. If rounding placed it
    /// inside of another solid nonetheless, as may happen at a concave crease, the boundary of that
    /// solid is reported at once, at `t_min`.
    Outside,
}

impl<P: Kernel + Solid + PartialEq> Packed<P> {
    /// Returns whether the point is in one of the solids or on its surface, decided with a certain
    /// sign.
    #[must_use]
    pub fn contains(&self, point: Vec3) -> bool {
        let ray = Ray { t_max: 0.0, ..Ray::new(point, Vec3::X) };
        self.isa.run(Contains {
            packed: self,
            ray: &ray,
            inside: |_, solid: &P| solid.contains(point),
        })
    }

    /// Returns whether a point of the surface of the solid `id` is covered by other solids, so that
    /// it is not on the boundary of the union. `below` and `above` are the point moved to either
    /// side of the surface by the bound on its error.
    ///
    /// Of solids whose surfaces coincide, the one with the lowest id is not covered, as in
    /// [`Packed::boundary`].
    #[must_use]
    pub fn covers(&self, id: u32, below: Vec3, above: Vec3) -> bool {
        // The ray passes both points, so that the traversal meets what contains either.
        let ray = Ray { t_max: 1.0, ..Ray::new(below, above - below) };
        let inside = |other: u32, solid: &P| {
            other != id && solid.contains(if other < id { below } else { above })
        };
        self.isa.run(Contains { packed: self, ray: &ray, inside })
    }

    /// Returns the next boundary of the union of all solids with `t` in `ray.t_min..=ray.t_max`:
    /// from outside where the ray enters it, from inside where it leaves it. Surfaces inside other
    /// solids do not count.
    ///
    /// Which intervals overlap is decided exactly, to 106 bits, so the answer is that of counting,
    /// over all solids, those that the ray is inside of. It does not depend on the instruction set.
    /// Of solids that share the boundary, the lowest id is reported.
    ///
    /// From outside the cost is that of [`Packed::closest`] plus, if the ray starts inside of
    /// [`Packed::bounds`], that of [`Packed::contains`]. From inside it is some of the latter for
    /// each solid on the way out. There is no allocation.
    ///
    /// ```
    /// use rotund_bvh::geometry::{Ray, Sphere, glam::Vec3};
    /// use rotund_bvh::{SphereTree, Start};
    ///
    /// let spheres = [0.0, 1.0, 2.0].map(|x| Sphere { center: Vec3::X * x, radius: 0.75 });
    /// let tree = SphereTree::build(&spheres);
    /// let ray = Ray::new(Vec3::ZERO, Vec3::X);
    /// let exit = tree.boundary(&ray, Start::ByPosition).expect("the ray starts inside");
    /// assert_eq!((exit.hit.t, exit.id, exit.enters), (2.75, 2, false));
    /// ```
    #[must_use]
    pub fn boundary(&self, ray: &Ray, start: Start) -> Option<Crossing> {
        let pieces = Pieces { packed: self, ray };
        let bounds = self.bounds();
        let in_bounds = bounds.min.cmple(ray.origin).all() && ray.origin.cmple(bounds.max).all();
        let may_start_inside = ray.t_min != 0.0 || in_bounds;
        if may_start_inside {
            let search = match start {
                Start::ByPosition => Search::LastExit,
                Start::Outside => Search::FirstEntry,
            };
            let find = FindAround { pieces, here: ray, end: ray.t_min, best: None, search };
            let around = self.isa.run(find);
            if let Some(piece) = around.best {
                if start == Start::Outside {
                    let entry = pieces.crossing(&piece, End::Entry)?;
                    let hit = rotund_geometry::Hit { t: ray.t_min, ..entry.hit };
                    return Some(Crossing { hit, ..entry });
                }
                return self.exit_after(&pieces, piece, around.is_complete);
            }
        }
        self.entry(ray)
    }

    /// Returns the first entry of a ray that starts outside.
    fn entry(&self, ray: &Ray) -> Option<Crossing> {
        let mut ray = *ray;
        loop {
            let found = self.closest(&ray, Method::Enhanced)?;
            let pieces = Pieces { packed: self, ray: &ray };
            let enters = found.hit.normal.dot(ray.direction) < 0.0
                || self.enters(&pieces, found.id, found.hit.t);
            if enters {
                return Some(Crossing { id: found.id, hit: found.hit, enters: true });
            }
            // An exit before `t_min` that was rounded to it.
            ray.t_min = found.hit.t.next_up();
        }
    }

    /// Returns whether a grazing hit whose normal does not tell is an entry.
    #[cold]
    #[inline(never)]
    fn enters(&self, pieces: &Pieces<'_, P>, id: u32, t: f32) -> bool {
        let at = Ray { t_min: t.next_down(), t_max: t.next_up(), ..*pieces.ray };
        let mut enters = false;
        _ = self.crossings(&at, Method::Enhanced, |crossing| {
            enters |= crossing.id == id && crossing.enters;
            ControlFlow::Continue(())
        });
        enters
    }

    /// Returns the exit from the union of a ray that is inside `last`. It is that of `last` if
    /// `is_complete`.
    fn exit_after(
        &self,
        pieces: &Pieces<'_, P>,
        mut last: Piece,
        mut is_complete: bool,
    ) -> Option<Crossing> {
        let ray = pieces.ray;
        while !is_complete {
            let Interval { exit, error, .. } = last.interval;
            let (mut low, mut high) = ((exit - error) as f32, (exit + error) as f32);
            if !(low.is_finite() && high.is_finite()) {
                (low, high) = (ray.t_min, ray.t_max);
            }
            if low > ray.t_max {
                return None;
            }
            let here = Ray { t_min: low.next_down(), ..*ray };
            let (end, search) = (high.next_up(), Search::LastExit);
            let find = FindAround { pieces: *pieces, here: &here, end, best: Some(last), search };
            let next = self.isa.run(find);
            is_complete = next.is_complete;
            match next.best {
                Some(next) if next.id != last.id => last = next,
                _ => break,
            }
        }
        let exit = pieces.crossing(&last, End::Exit)?;
        (exit.hit.t <= ray.t_max).then(|| {
            // An exit at `t_min` or later may have been rounded to a number before it.
            let t = exit.hit.t.max(ray.t_min);
            Crossing { hit: rotund_geometry::Hit { t, ..exit.hit }, ..exit }
        })
    }

    /// Calls `visit` with every boundary of the union with `t` in `ray.t_min..=ray.t_max`, in
    /// order, until it returns [`ControlFlow::Break`]; returns what it returned last.
    ///
    /// Entries and exits alternate. They are decided as by [`Packed::boundary`] with
    /// [`Start::ByPosition`]; one traversal finds all of them. The intervals of up to 64 solids are
    /// collected without allocation.
    pub fn boundaries(
        &self,
        ray: &Ray,
        mut visit: impl FnMut(&Crossing) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let pieces = Pieces { packed: self, ray };
        let mut found = self.isa.run(FindPieces { packed: self, ray });
        found.sort_unstable_by(|a, b| {
            pieces.compare((a, End::Entry), (b, End::Entry)).then(a.id.cmp(&b.id))
        });
        let mut rest = found.iter();
        let mut first = rest.next();
        while let Some(begin) = first {
            let mut last = begin;
            first = rest.find(|piece| {
                let follows =
                    pieces.compare((piece, End::Entry), (last, End::Exit)) == Ordering::Greater;
                if !follows && pieces.ends_later(piece, last) {
                    last = piece;
                }
                follows
            });
            if pieces.compare_with_start(last, End::Exit) == Ordering::Less {
                continue;
            }
            let is_after_start = pieces.compare_with_start(begin, End::Entry) != Ordering::Less;
            let ends = [(begin, End::Entry, is_after_start), (last, End::Exit, true)];
            for (piece, end, counts) in ends {
                let Some(crossing) = pieces.crossing(piece, end).filter(|_| counts) else {
                    continue;
                };
                if crossing.hit.t > ray.t_max {
                    return ControlFlow::Continue(());
                }
                visit(&crossing)?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// What to find among the solids that contain a point of a ray.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Search {
    /// The solid that the ray leaves last.
    LastExit,
    /// The solid that the ray entered first.
    FirstEntry,
}

/// Finds a solid around the start of `here`, the rest of `ray`.
struct FindAround<'a, P: Kernel> {
    pieces: Pieces<'a, P>,
    here: &'a Ray,
    /// What is around all points up to this `t` is wanted.
    end: f32,
    /// The solid whose exit moves; `None` at the start of `ray`.
    best: Option<Piece>,
    search: Search,
}

/// What [`FindAround`] found.
struct Around {
    best: Option<Piece>,
    /// Whether nothing was passed over that begins before `best` ends.
    is_complete: bool,
}

impl<P: Kernel + Solid + PartialEq> WithSimd for FindAround<'_, P> {
    type Output = Around;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Around {
        let Some(slab_ray) = SlabRay::new(self.here, self.pieces.packed.tree.range) else {
            return Around { best: self.best, is_complete: true };
        };
        let (reach, limit) =
            (slab_ray.scaling.limit(self.here.t_max), slab_ray.scaling.limit(self.end));
        let mut visitor = AroundVisitor::<P> {
            leaf_ray: P::leaf_ray(&slab_ray),
            find: self,
            scaling: slab_ray.scaling,
            reach,
            limit,
            skipped: f32::INFINITY,
        };
        let packed = visitor.find.pieces.packed;
        let skipped = traverse::growing(simd, &packed.tree, &slab_ray, reach, limit, &mut visitor);
        Around {
            best: visitor.find.best,
            is_complete: skipped.min(visitor.skipped) > visitor.limit,
        }
    }
}

struct AroundVisitor<'a, P: Kernel> {
    find: FindAround<'a, P>,
    leaf_ray: P::LeafRay,
    scaling: Scaling,
    reach: f32,
    limit: f32,
    /// Where the nearest solid begins that was passed over, or before.
    skipped: f32,
}

impl<S: Simd, P: Kernel> traverse::LeafVisitor<S> for AroundVisitor<'_, P> {
    #[inline(always)]
    fn prefetch(&self, simd: S, index: usize) {
        simd.prefetch(&self.find.pieces.packed.blocks[index]);
    }
}

impl<S: Simd, P: Kernel + Solid + PartialEq> traverse::ClosestVisitor<S> for AroundVisitor<'_, P> {
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize, _: f32) -> f32 {
        let block = &self.find.pieces.packed.blocks[index];
        let Candidates { possible: mut mask, near, .. } =
            P::candidates::<S, Enhanced>(simd, &self.leaf_ray, block, self.reach);
        if mask == 0 {
            return self.limit;
        }
        // What begins behind the limit waits, since the limit moves.
        loop {
            let ready = mask & simd.mask_not_gt(near, simd.splat(self.limit));
            if ready == 0 {
                break;
            }
            mask &= !ready;
            self.test(simd, index, ready);
        }
        let near = simd.to_array(near);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            self.skipped = self.skipped.min(near[lane]);
        }
        self.limit
    }
}

impl<P: Kernel + Solid + PartialEq> AroundVisitor<'_, P> {
    /// Tests the lanes of `mask`.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, index: usize, mut mask: u32) {
        let pieces = &self.find.pieces;
        let block = &pieces.packed.blocks[index];
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            let id = block.ids()[lane];
            if id == NO_ID || self.find.best.is_some_and(|best| best.id == id) {
                continue;
            }
            let Some(piece) = piece::<S, P>(simd, pieces, index, lane) else { continue };
            let contains_start = || pieces.contains_start(&piece);
            let Interval { entry, exit, error } = piece.interval;
            let is_better = match (&self.find.best, self.find.search) {
                (None, _) => {
                    contains_start() || {
                        if exit + error >= f64::from(self.find.here.t_min) {
                            self.skipped = self.skipped.min(self.begin(entry - error));
                        }
                        false
                    }
                }
                (Some(first), Search::FirstEntry) => {
                    contains_start() && pieces.begins_earlier(&piece, first)
                }
                (Some(last), Search::LastExit) => {
                    pieces.ends_later(&piece, last) && {
                        let end = (last, End::Exit);
                        let follows =
                            pieces.compare((&piece, End::Entry), end) == Ordering::Greater;
                        if follows {
                            self.skipped = self.skipped.min(self.begin(entry - error));
                        }
                        !follows
                    }
                }
            };
            if is_better {
                self.find.best = Some(piece);
                if self.find.search == Search::LastExit {
                    let end = (exit + error) as f32;
                    self.limit = self.limit.max(self.scaling.limit(end.next_up()));
                }
            }
        }
    }

    /// Returns the parameter of the traversal at `t` or slightly before; that of a NaN is before
    /// all.
    #[inline(always)]
    fn begin(&self, t: f64) -> f32 {
        let begin = (t as f32).next_down() * self.scaling.scale;
        if begin.is_nan() { f32::NEG_INFINITY } else { begin }
    }
}

/// Collects the intervals of all solids along a ray.
struct FindPieces<'a, P: Kernel> {
    packed: &'a Packed<P>,
    ray: &'a Ray,
}

impl<P: Kernel + Solid> WithSimd for FindPieces<'_, P> {
    type Output = SmallVec<[Piece; INLINE]>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Some(slab_ray) = SlabRay::new(self.ray, self.packed.tree.range) else {
            return SmallVec::new();
        };
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        let mut visitor = PiecesVisitor::<P> {
            pieces: Pieces { packed: self.packed, ray: self.ray },
            leaf_ray: P::leaf_ray(&slab_ray),
            limit,
            found: SmallVec::new(),
        };
        traverse::any(simd, &self.packed.tree, &slab_ray, limit, &mut visitor);
        visitor.found
    }
}

struct PiecesVisitor<'a, P: Kernel> {
    pieces: Pieces<'a, P>,
    leaf_ray: P::LeafRay,
    limit: f32,
    found: SmallVec<[Piece; INLINE]>,
}

impl<S: Simd, P: Kernel> traverse::LeafVisitor<S> for PiecesVisitor<'_, P> {}

impl<S: Simd, P: Kernel + Solid> traverse::AnyVisitor<S> for PiecesVisitor<'_, P> {
    /// Never stops the traversal.
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize) -> bool {
        let block = &self.pieces.packed.blocks[index];
        let Candidates { possible: mut mask, .. } =
            P::candidates::<S, Enhanced>(simd, &self.leaf_ray, block, self.limit);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            if block.ids()[lane] != NO_ID
                && let Some(piece) = piece::<S, P>(simd, &self.pieces, index, lane)
            {
                self.found.push(piece);
            }
        }
        false
    }
}

/// Finds out whether a point is in any solid.
struct Contains<'a, P: Kernel, F> {
    packed: &'a Packed<P>,
    /// A ray that passes the point.
    ray: &'a Ray,
    inside: F,
}

impl<P: Kernel + Solid, F: Fn(u32, &P) -> bool> WithSimd for Contains<'_, P, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let Some(slab_ray) = SlabRay::new(self.ray, self.packed.tree.range) else { return false };
        let limit = slab_ray.scaling.limit(self.ray.t_max);
        let leaf_ray = P::leaf_ray(&slab_ray);
        let mut visitor = ContainsVisitor::<P, F> { find: &self, leaf_ray, limit };
        traverse::any(simd, &self.packed.tree, &slab_ray, limit, &mut visitor)
    }
}

struct ContainsVisitor<'a, P: Kernel, F> {
    find: &'a Contains<'a, P, F>,
    leaf_ray: P::LeafRay,
    limit: f32,
}

impl<S: Simd, P: Kernel, F> traverse::LeafVisitor<S> for ContainsVisitor<'_, P, F> {}

impl<S: Simd, P: Kernel + Solid, F: Fn(u32, &P) -> bool> traverse::AnyVisitor<S>
    for ContainsVisitor<'_, P, F>
{
    #[inline(always)]
    fn leaf(&mut self, simd: S, index: usize) -> bool {
        let block = &self.find.packed.blocks[index];
        let Candidates { possible: mut mask, .. } =
            P::candidates::<S, Enhanced>(simd, &self.leaf_ray, block, self.limit);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            let id = block.ids()[lane];
            if id != NO_ID && (self.find.inside)(id, &P::unpack(block, lane)) {
                return true;
            }
        }
        false
    }
}
