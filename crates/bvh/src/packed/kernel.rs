//! What a primitive brings to be packed: eight at a time, one after the other in memory.

use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::{Aabb, Hit, Ray};

/// Numbers of up to [`WIDTH`] primitives, one row per number. Lanes that are not used repeat the
/// first.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Block<const ROWS: usize> {
    pub(crate) rows: [[f32; WIDTH]; ROWS],
}

impl<const ROWS: usize> Block<ROWS> {
    /// The numbers of one lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> [f32; ROWS] {
        std::array::from_fn(|row| self.rows[row][lane % WIDTH])
    }
}

/// A kind of primitive. The trait cannot be named outside this crate.
pub trait Kernel: Copy + Send + Sync {
    /// Its block.
    type Block: Clone + Send + Sync;
    /// What [`Kernel::candidates`] needs of a ray.
    type Lanes<S: Simd>: Copy;

    /// A box around it, empty if one of its numbers is not finite.
    fn bounds(&self) -> Aabb;

    /// Packs `lanes`, of which only the first are different primitives.
    fn pack(lanes: &[Self; WIDTH]) -> Self::Block;

    /// The primitive of a lane, to the bit.
    fn unpack(block: &Self::Block, lane: usize) -> Self;

    /// Prepares a ray.
    fn lanes<S: Simd>(simd: S, ray: &SlabRay) -> Self::Lanes<S>;

    /// Which lanes the ray may hit before `limit`, in either form, and bounds below the parameter at
    /// which it does. Conservative: every lane that the exact test hits is among them.
    fn candidates<S: Simd>(
        simd: S,
        ray: &Self::Lanes<S>,
        block: &Self::Block,
        limit: f32,
    ) -> (u32, S::Lanes);

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
}

impl<S: Simd> RoundLanes<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &SlabRay) -> Self {
        let inverse_square = ray.direction.length_squared().recip();
        Self {
            origin: ray.origin.to_array().map(|x| simd.splat(x)),
            direction: ray.direction.to_array().map(|x| simd.splat(x)),
            inverse_square: simd.splat(inverse_square),
            inverse_length: simd.splat(inverse_square.sqrt()),
            start: simd.splat(ray.start),
        }
    }

    /// Where `p` is seen from the ray: the squared distance from the origin, the parameter of the point
    /// of the line closest to it, and the vector from there to `p`.
    #[inline(always)]
    pub(crate) fn project(&self, simd: S, p: [S::Lanes; 3]) -> Projection<S> {
        let [x, y, z]: [S::Lanes; 3] = std::array::from_fn(|i| simd.sub(p[i], self.origin[i]));
        let [dx, dy, dz] = self.direction;
        let along = simd.mul_add(x, dx, simd.mul_add(y, dy, simd.mul(z, dz)));
        let t = simd.mul(along, self.inverse_square);
        let square = simd.mul_add(x, x, simd.mul_add(y, y, simd.mul(z, z)));
        let beside = [(x, dx), (y, dy), (z, dz)].map(|(from, d)| simd.neg_mul_add(t, d, from));
        Projection { square, t, beside }
    }
}

pub(crate) struct Projection<S: Simd> {
    pub(crate) square: S::Lanes,
    pub(crate) t: S::Lanes,
    pub(crate) beside: [S::Lanes; 3],
}

/// `a · b`.
#[inline(always)]
pub(crate) fn dot<S: Simd>(simd: S, a: [S::Lanes; 3], b: [S::Lanes; 3]) -> S::Lanes {
    simd.mul_add(a[0], b[0], simd.mul_add(a[1], b[1], simd.mul(a[2], b[2])))
}
