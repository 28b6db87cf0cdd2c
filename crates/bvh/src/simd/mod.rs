//! Eight lanes of `f32`: the few operations that traversal and packed leaves need.
//!
//! Everything computed here only decides what to look at next, with errors on the safe side; so
//! implementations may round differently (one fuses multiplications, another does not) and the
//! answers of a tree are still the same bits.

mod portable;

pub(crate) use portable::Portable;

use crate::node::WIDTH;

/// An instruction set. A value of the type is the proof that the processor has it.
///
/// Comparisons are false for a NaN, and `min` and `max` return their **second** argument if either
/// is NaN, as the x86 instructions do.
pub(crate) trait Simd: Copy {
    /// Eight lanes.
    type Lanes: Copy;

    fn load(self, from: &[f32; WIDTH]) -> Self::Lanes;
    fn splat(self, value: f32) -> Self::Lanes;
    fn to_array(self, a: Self::Lanes) -> [f32; WIDTH];
    fn sub(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn mul(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    /// `a * b + c`, rounded once or twice.
    fn mul_add(self, a: Self::Lanes, b: Self::Lanes, c: Self::Lanes) -> Self::Lanes;
    fn abs(self, a: Self::Lanes) -> Self::Lanes;
    fn min(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    fn max(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes;
    /// Bit `i` is set if `a <= b` in lane `i`.
    fn mask_le(self, a: Self::Lanes, b: Self::Lanes) -> u32;
}
