//! The interface of a primitive to packed leaves: its block of eight, its wide test, its exact
//! test.

use super::method_tag::MethodTag;
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, End, Hit, Method, Primitive, Ray, Solid};

/// Up to [`WIDTH`] primitives, one row per number of a primitive, and their ids. Unused lanes
/// repeat the primitive of the first lane and have the id [`NO_ID`].
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Block<const ROWS: usize> {
    pub(crate) rows: [[f32; WIDTH]; ROWS],
    pub(crate) ids: [u32; WIDTH],
}

/// The id of an unused lane.
pub(crate) const NO_ID: u32 = u32::MAX;

impl<const ROWS: usize> Block<ROWS> {
    /// The numbers of one lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> [f32; ROWS] {
        std::array::from_fn(|row| self.rows[row][lane % WIDTH])
    }
}

/// A block aligned to cache lines, so that a block whose size is a multiple of a line does not
/// straddle one more.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Aligned<B>(pub(crate) B);

impl<B: HasIds> HasIds for Aligned<B> {
    #[inline(always)]
    fn ids(&self) -> &[u32; WIDTH] {
        self.0.ids()
    }
}

/// The interface that all blocks share.
pub trait HasIds {
    /// The ids of the lanes.
    fn ids(&self) -> &[u32; WIDTH];

    /// The mask of the used lanes.
    #[inline(always)]
    fn used(&self) -> u32 {
        let bits = self.ids().map(|id| u32::from(id != NO_ID));
        (0..WIDTH).fold(0, |mask, lane| mask | bits[lane] << lane)
    }
}

impl<const ROWS: usize> HasIds for Block<ROWS> {
    #[inline(always)]
    fn ids(&self) -> &[u32; WIDTH] {
        &self.ids
    }
}

/// The result of the wide test of a block. Distances are parameters of the [`SlabRay`].
pub struct Candidates<S: Simd> {
    /// Lanes that the ray may hit: a superset of those that the exact test hits.
    pub(crate) possible: u32,
    /// Lanes that the exact test is certain to hit.
    pub(crate) certain: u32,
    /// Lower bound on the hit of each possible lane.
    pub(crate) near: S::Lanes,
    /// Upper bound on the hit of each certain lane.
    pub(crate) far: S::Lanes,
}

impl<S: Simd> Candidates<S> {
    /// Returns whether no exact test is needed unless another leaf has a nearer hit: at most one
    /// lane is possible, and it is certain.
    #[inline(always)]
    pub(crate) fn is_decided(&self) -> bool {
        self.possible & self.possible.wrapping_sub(1) == 0 && self.possible == self.certain
    }

    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        let zero = simd.splat(0.0);
        Self { possible: 0, certain: 0, near: zero, far: zero }
    }
}

/// A primitive of packed trees. The trait cannot be named outside this crate.
pub trait Kernel: Primitive + Copy + Send + Sync {
    /// The vanilla shape in place of this one.
    type Vanilla: Primitive;
    /// The block of eight primitives.
    type Block: Clone + std::fmt::Debug + Send + Sync + HasIds;
    /// Whether the exact test is an outlined call. Traversal of round primitives gains 10 % from
    /// the registers that this frees; the wide test of flat ones needs so many that saving them
    /// around the call costs as much.
    const OUTLINE_EXACT_TEST: bool;
    /// Whether the exact test of a candidate computes the whole hit, instead of `t` alone and the
    /// hit of the closest one at the end. It does where the wide test finds no hit for certain:
    /// then the exact test of the closest one has run before the end.
    const KEEP_HIT: bool;
    /// Whether the test of a leaf is an outlined call. Then what the test of flat primitives needs
    /// of the ray is broadcast at a leaf, and not for each ray, of which many meet none.
    const OUTLINE_LEAF: bool;
    /// The ray, prepared for [`Kernel::candidates`].
    type LeafRay: Copy;

    /// The box of the primitive; empty if no ray can hit it or one of its numbers is not finite.
    fn tree_bounds(&self) -> Aabb;

    /// Packs `lanes` into a block.
    fn pack(lanes: &[Self; WIDTH], ids: [u32; WIDTH]) -> Self::Block;

    /// Restores the primitive of a lane, to the bit.
    fn unpack(block: &Self::Block, lane: usize) -> Self;

    /// Prepares a ray.
    fn leaf_ray(ray: &SlabRay) -> Self::LeafRay;

    /// The wide test: finds the lanes that the ray may hit before `limit`.
    fn candidates<S: Simd, M: MethodTag>(
        simd: S,
        ray: &Self::LeafRay,
        block: &Self::Block,
        limit: f32,
    ) -> Candidates<S>;

    /// The vanilla shape of this primitive.
    fn vanilla(&self) -> Self::Vanilla;

    /// The exact test.
    #[inline(always)]
    fn exact_hit<M: MethodTag>(&self, ray: &Ray) -> Option<Hit> {
        match M::METHOD {
            Method::Enhanced => self.closest(ray),
            Method::Vanilla => self.vanilla().closest(ray),
        }
    }

    /// The `t` of the exact test.
    #[inline(always)]
    fn exact_t<M: MethodTag>(&self, ray: &Ray) -> Option<f32> {
        match M::METHOD {
            Method::Enhanced => self.closest_t(ray),
            Method::Vanilla => self.vanilla().closest_t(ray),
        }
    }

    /// Calls `visit` with all hits in the interval of the ray, and whether the ray enters there.
    #[inline(always)]
    fn exact_crossings<M: MethodTag>(&self, ray: &Ray, visit: impl FnMut(Hit, bool)) {
        match M::METHOD {
            Method::Enhanced => step(self, ray, visit),
            Method::Vanilla => step(&self.vanilla(), ray, visit),
        }
    }
}

/// Calls `visit` with all hits in the interval of the ray, by starting again behind each.
#[inline(always)]
pub(super) fn step(shape: &impl Primitive, ray: &Ray, mut visit: impl FnMut(Hit, bool)) {
    let mut ray = *ray;
    while let Some(hit) = shape.closest(&ray) {
        visit(hit, hit.normal.dot(ray.direction) < 0.0);
        ray.t_min = hit.t.next_up();
    }
}

/// Calls `visit` with the entry and the exit of a solid, if they are in the interval of the ray.
#[inline(always)]
pub(super) fn both_ends(solid: &impl Solid, ray: &Ray, mut visit: impl FnMut(Hit, bool)) {
    for end in [End::Entry, End::Exit] {
        if let Some(hit) = solid.crossing(ray, end)
            && ray.t_min <= hit.t
            && hit.t <= ray.t_max
        {
            visit(hit, end == End::Entry);
        }
    }
}
