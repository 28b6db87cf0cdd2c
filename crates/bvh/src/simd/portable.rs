//! Eight lanes as an array: the reference that the faster versions are tested against, and the
//! implementation where there is no faster one. The compiler turns it into pairs of SSE2 or NEON
//! instructions.

use super::{Simd, StackEntry, WithSimd, order_by_insertion};
use crate::node::{Child, WIDTH};
use std::mem::MaybeUninit;

/// The baseline of the architecture, which every processor supports.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

#[inline(always)]
fn map2<T>(a: [f32; WIDTH], b: [f32; WIDTH], f: impl Fn(f32, f32) -> T) -> [T; WIDTH] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

impl Simd for Portable {
    type Lanes = [f32; WIDTH];

    #[inline(always)]
    fn run<T: WithSimd>(self, task: T) -> T::Output {
        task.run(self)
    }

    #[inline(never)]
    fn run_outlined<T: WithSimd>(self, task: T) -> T::Output {
        task.run(self)
    }

    #[inline(always)]
    fn load(self, from: &[f32; WIDTH]) -> Self::Lanes {
        *from
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Lanes {
        [value; WIDTH]
    }

    #[inline(always)]
    fn to_array(self, a: Self::Lanes) -> [f32; WIDTH] {
        a
    }

    #[inline(always)]
    fn add(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes {
        map2(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes {
        map2(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes {
        map2(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes {
        map2(a, b, |a, b| a / b)
    }

    #[inline(always)]
    fn sqrt(self, a: Self::Lanes) -> Self::Lanes {
        a.map(f32::sqrt)
    }

    #[inline(always)]
    fn mul_add(self, a: Self::Lanes, b: Self::Lanes, c: Self::Lanes) -> Self::Lanes {
        std::array::from_fn(|i| a[i] * b[i] + c[i])
    }

    #[inline(always)]
    fn neg_mul_add(self, a: Self::Lanes, b: Self::Lanes, c: Self::Lanes) -> Self::Lanes {
        std::array::from_fn(|i| c[i] - a[i] * b[i])
    }

    #[inline(always)]
    fn abs(self, a: Self::Lanes) -> Self::Lanes {
        a.map(f32::abs)
    }

    #[inline(always)]
    fn times_sign_of(self, a: Self::Lanes, sign: Self::Lanes) -> Self::Lanes {
        map2(a, sign, |a, sign| f32::from_bits(a.to_bits() ^ sign.to_bits() & 1 << 31))
    }

    #[inline(always)]
    fn nan_unless_le(self, x: Self::Lanes, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes {
        std::array::from_fn(|i| if a[i] <= b[i] { x[i] } else { f32::NAN })
    }

    #[inline(always)]
    fn min(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes {
        map2(a, b, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, a: Self::Lanes, b: Self::Lanes) -> Self::Lanes {
        map2(a, b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn mask_le(self, a: Self::Lanes, b: Self::Lanes) -> u32 {
        let bits = map2(a, b, |a, b| u32::from(a <= b));
        (0..WIDTH).fold(0, |mask, i| mask | bits[i] << i)
    }

    #[inline(always)]
    fn mask_not_gt(self, a: Self::Lanes, b: Self::Lanes) -> u32 {
        let bits = map2(a, b, |a, b| u32::from(a > b));
        (0..WIDTH).fold(255, |mask, i| mask & !(bits[i] << i))
    }

    #[inline(always)]
    fn order(
        self,
        near: Self::Lanes,
        mask: u32,
        children: &[Child; WIDTH],
        out: &mut [MaybeUninit<StackEntry>; WIDTH],
    ) {
        order_by_insertion(near, mask, children, out);
    }
}
