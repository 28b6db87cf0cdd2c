//! What a primitive brings to be packed: eight at a time, one after the other in memory.

use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::glam::Vec3;
use rotund_geometry::{Aabb, Hit, Ray};

/// Numbers of up to [`WIDTH`] primitives, one row per number, and their ids. Lanes that are not used
/// repeat the numbers of the first, with [`NO_ID`].
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Block<const ROWS: usize> {
    pub(crate) rows: [[f32; WIDTH]; ROWS],
    pub(crate) ids: [u32; WIDTH],
}

/// The id of a lane that is not used.
pub(crate) const NO_ID: u32 = u32::MAX;

impl<const ROWS: usize> Block<ROWS> {
    /// The numbers of one lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> [f32; ROWS] {
        std::array::from_fn(|row| self.rows[row][lane % WIDTH])
    }
}

/// A block that starts where a cache line does: one whose size is a multiple of that would else reach into one more.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Aligned<B>(pub(crate) B);

impl<B: HasIds> HasIds for Aligned<B> {
    #[inline(always)]
    fn ids(&self) -> &[u32; WIDTH] {
        self.0.ids()
    }
}

/// What all blocks have.
pub trait HasIds {
    /// The ids of the lanes.
    fn ids(&self) -> &[u32; WIDTH];
}

impl<const ROWS: usize> HasIds for Block<ROWS> {
    #[inline(always)]
    fn ids(&self) -> &[u32; WIDTH] {
        &self.ids
    }
}

/// What the wide test knows of a block. Bounds are on the parameter of the ray.
pub struct Candidates<S: Simd> {
    /// Lanes that the ray may hit. Every lane that the exact test hits is among them.
    pub(crate) maybe: u32,
    /// Lanes that the exact test is sure to hit.
    pub(crate) surely: u32,
    /// No hit is nearer.
    pub(crate) near: S::Lanes,
    /// The hit is not farther, if it is sure.
    pub(crate) far: S::Lanes,
}

impl<S: Simd> Candidates<S> {
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        let nothing = simd.splat(0.0);
        Self { maybe: 0, surely: 0, near: nothing, far: nothing }
    }
}

/// A kind of primitive. The trait cannot be named outside this crate.
pub trait Kernel: Copy + Send + Sync {
    /// Its block.
    type Block: Clone + std::fmt::Debug + Send + Sync + HasIds;
    /// Whether the exact test is called and not inlined. A walk over round primitives gains a tenth from the
    /// registers that are left to it; the wide test of flat ones needs so many that saving them costs as much.
    const APART: bool;
    /// What [`Kernel::candidates`] needs of a ray.
    type Lanes<S: Simd>: Copy;

    /// A box around it, empty if no ray can hit it or one of its numbers is not finite.
    fn bounds(&self) -> Aabb;

    /// Packs `lanes`, of which only the first are different primitives.
    fn pack(lanes: &[Self; WIDTH], ids: [u32; WIDTH]) -> Self::Block;

    /// The primitive of a lane, to the bit.
    fn unpack(block: &Self::Block, lane: usize) -> Self;

    /// Prepares a ray.
    fn lanes<S: Simd>(simd: S, ray: &SlabRay) -> Self::Lanes<S>;

    /// Sorts out what the ray may hit before `limit`.
    fn candidates<S: Simd, const VANILLA: bool>(
        simd: S,
        ray: &Self::Lanes<S>,
        block: &Self::Block,
        limit: f32,
    ) -> Candidates<S>;

    /// The exact test.
    fn closest<const VANILLA: bool>(&self, ray: &Ray) -> Option<Hit>;

    /// The `t` of the exact test.
    fn closest_t<const VANILLA: bool>(&self, ray: &Ray) -> Option<f32>;
}

/// A ray as round primitives see it.
#[derive(Clone, Copy)]
pub struct RoundLanes<S: Simd> {
    pub(crate) origin: [S::Lanes; 3],
    pub(crate) direction: [S::Lanes; 3],
    /// One over the squared length of the direction, and over the length.
    pub(crate) inverse_square: S::Lanes,
    pub(crate) inverse_length: S::Lanes,
    pub(crate) start: S::Lanes,
    pub(crate) end: S::Lanes,
}

impl<S: Simd> RoundLanes<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &SlabRay) -> Self {
        let inverse_square = ray.direction.length_squared().recip();
        Self {
            origin: splat(simd, ray.origin),
            direction: splat(simd, ray.direction),
            inverse_square: simd.splat(inverse_square),
            inverse_length: simd.splat(inverse_square.sqrt()),
            start: simd.splat(ray.start),
            end: simd.splat(ray.end),
        }
    }

    /// Where `p` is seen from the ray: the squared distance from the origin, the parameter of the point
    /// of the line closest to it, and the vector from there to `p`.
    #[inline(always)]
    pub(crate) fn project(&self, simd: S, p: [S::Lanes; 3]) -> Projection<S> {
        let [x, y, z] = sub(simd, p, self.origin);
        let [dx, dy, dz] = self.direction;
        let along = simd.mul_add(x, dx, simd.mul_add(y, dy, simd.mul(z, dz)));
        let t = simd.mul(along, self.inverse_square);
        let square = dot(simd, [x, y, z], [x, y, z]);
        let beside = neg_mul_add(simd, t, self.direction, [x, y, z]);
        Projection { square, t, beside }
    }
}

pub(crate) struct Projection<S: Simd> {
    pub(crate) square: S::Lanes,
    pub(crate) t: S::Lanes,
    pub(crate) beside: [S::Lanes; 3],
}

// No closures here, as in all that is compiled once for each instruction set: a closure is compiled by
// itself, without the instructions, and may then be found too large to inline.

/// `a · b`.
#[inline(always)]
pub(crate) fn dot<S: Simd>(simd: S, a: [S::Lanes; 3], b: [S::Lanes; 3]) -> S::Lanes {
    simd.mul_add(a[0], b[0], simd.mul_add(a[1], b[1], simd.mul(a[2], b[2])))
}

/// `a - b`.
#[inline(always)]
pub(crate) fn sub<S: Simd>(simd: S, a: [S::Lanes; 3], b: [S::Lanes; 3]) -> [S::Lanes; 3] {
    [simd.sub(a[0], b[0]), simd.sub(a[1], b[1]), simd.sub(a[2], b[2])]
}

/// `c - a b`.
#[inline(always)]
pub(crate) fn neg_mul_add<S: Simd>(
    simd: S,
    a: S::Lanes,
    b: [S::Lanes; 3],
    c: [S::Lanes; 3],
) -> [S::Lanes; 3] {
    [
        simd.neg_mul_add(a, b[0], c[0]),
        simd.neg_mul_add(a, b[1], c[1]),
        simd.neg_mul_add(a, b[2], c[2]),
    ]
}

/// One coordinate in all lanes, for each.
#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, v: Vec3) -> [S::Lanes; 3] {
    [simd.splat(v.x), simd.splat(v.y), simd.splat(v.z)]
}

/// Three rows.
#[inline(always)]
pub(crate) fn load3<S: Simd>(simd: S, rows: [&[f32; WIDTH]; 3]) -> [S::Lanes; 3] {
    [simd.load(rows[0]), simd.load(rows[1]), simd.load(rows[2])]
}
