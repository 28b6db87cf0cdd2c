//! Eight lanes of `f32`, with the operations that building, traversal and packed leaves need.
//!
//! Results of these operations only decide which boxes and primitives are tested next, with
//! conservative error bounds. So implementations may round differently (one fuses multiplications
//! and additions, another does not), and the answers of a tree are still the same to the bit.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::node::{Child, WIDTH};
use std::mem::MaybeUninit;

pub(crate) use portable::Portable;
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, Avx512};

/// A computation that is compiled once for each instruction set.
pub trait WithSimd {
    type Output;

    /// Implementations are `#[inline(always)]`, and so are all functions that they call with
    /// `simd`: only code that is inlined into [`Simd::run`] is compiled for the instruction set.
    /// Adapters that take closures, as `map` of an array, are not always inlined.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// An instruction set. A value of the type proves that the processor supports it.
///
/// Comparisons are false for a NaN, and `min` and `max` return their **second** argument if either
/// is NaN, as the x86 instructions do.
pub trait Simd: Copy {
    /// Eight lanes.
    type Lanes: Copy;

    /// Runs `task` in a function that is compiled for this instruction set.
    fn run<T: WithSimd>(self, task: T) -> T::Output;

    /// Runs `task` in an outlined function that is compiled for this instruction set.
    fn run_outlined<T: WithSimd>(self, task: T) -> T::Output;

    /// Prefetches the cache lines of `value`.
    #[inline(always)]
    fn prefetch<T>(self, value: &T) {
        _ = value;
    }

    fn load(self, from: &[f32; WIDTH]) -> Self::Lanes;
    fn splat(self, value: f32) -> Self::Lanes;
    fn to_array(self, a: Self::Lanes) -> [f32; WIDTH];
    fn add(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn sub(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn mul(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn div(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn sqrt(self, a: Self::Lanes) -> Self::Lanes;
    /// `a * b + c`, rounded once or twice.
    fn mul_add(self, a: Self::Lanes, b: Self::Lanes, c: Self::Lanes) -> Self::Lanes;
    /// `c - a * b`, rounded once or twice.
    fn neg_mul_add(self, a: Self::Lanes, b: Self::Lanes, c: Self::Lanes) -> Self::Lanes;
    fn abs(self, a: Self::Lanes) -> Self::Lanes;
    /// `a`, negated where the sign bit of `sign` is set.
    fn times_sign_of(self, a: Self::Lanes, sign: Self::Lanes) -> Self::Lanes;
    /// `x`, or a NaN in lanes where `a <= b` is false.
    fn nan_unless_le(self, x: Self::Lanes, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn min(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn max(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    /// Bit `i` is set if `a <= b` in lane `i`.
    fn mask_le(self, a: Self::Lanes, b: Self::Lanes) -> u32;
    /// Bit `i` is set unless `a > b` in lane `i`; so it is set if either is NaN.
    fn mask_not_gt(self, a: Self::Lanes, b: Self::Lanes) -> u32;

    /// Writes stack entries for the children in `mask`, farthest first. The entries of `out` after
    /// them are unspecified.
    fn order(
        self,
        near: Self::Lanes,
        mask: u32,
        children: &[Child; WIDTH],
        out: &mut [MaybeUninit<StackEntry>; WIDTH],
    );
}

/// A child on the traversal stack: the bits of the parameter at which the ray enters it, clamped to
/// zero, above those of the child. Integers compare as the parameters do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct StackEntry(pub(crate) u64);

impl StackEntry {
    /// The content of an array that has not been written to.
    pub(crate) const NONE: Self = Self(0);

    #[inline(always)]
    pub(crate) fn new(near: f32, child: Child) -> Self {
        // Also removes the sign of a negative zero.
        let near = (near.to_bits() as i32).max(0) as u32;
        Self(u64::from(near) << 32 | u64::from(child.0))
    }

    #[inline(always)]
    pub(crate) fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    pub(crate) fn child(self) -> Child {
        Child(self.0 as u32)
    }
}

/// [`Simd::order`] by insertion sort.
#[inline(always)]
fn order_by_insertion(
    near: [f32; WIDTH],
    mut mask: u32,
    children: &[Child; WIDTH],
    out: &mut [MaybeUninit<StackEntry>; WIDTH],
) {
    let mut sorted = [StackEntry::NONE; WIDTH];
    let mut count = 0;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize % WIDTH;
        mask &= mask - 1;
        let entry = StackEntry::new(near[lane], children[lane]);
        let mut at = count;
        while at > 0 && sorted[(at - 1) % WIDTH] < entry {
            sorted[at % WIDTH] = sorted[(at - 1) % WIDTH];
            at -= 1;
        }
        sorted[at % WIDTH] = entry;
        count += 1;
    }
    *out = sorted.map(MaybeUninit::new);
}
