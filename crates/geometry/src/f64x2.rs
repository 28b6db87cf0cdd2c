//! A SIMD vector of two `f64`.
//!
//! The patch computes everything twice, for `u` and for `v` or for the vertices of two edges, and
//! the compiler does not vectorise this by itself. On x86-64 the vector is an SSE2 register, which
//! every such processor has. Elsewhere, also in kernels that are compiled without these registers,
//! it is an array, with the same results to the last bit.

#[cfg(not(target_feature = "sse2"))]
use portable as lanes;
#[cfg(target_feature = "sse2")]
use sse2 as lanes;

use core::ops::{Add, Div, Mul, Sub};

/// Two numbers, operated on together.
#[derive(Clone, Copy)]
pub(crate) struct F64x2(lanes::Lanes);

/// A truth value for each of two numbers: all bits set, or none.
#[derive(Clone, Copy)]
pub(crate) struct Mask(lanes::Lanes);

impl F64x2 {
    #[inline(always)]
    pub(crate) fn new(first: f64, second: f64) -> Self {
        Self(lanes::new(first, second))
    }

    #[inline(always)]
    pub(crate) fn splat(both: f64) -> Self {
        Self::new(both, both)
    }

    /// Converts two `f32` exactly.
    #[inline(always)]
    pub(crate) fn widen(first: f32, second: f32) -> Self {
        Self(lanes::widen(first, second))
    }

    #[inline(always)]
    pub(crate) fn first(self) -> f64 {
        lanes::first(self.0)
    }

    #[inline(always)]
    pub(crate) fn second(self) -> f64 {
        lanes::second(self.0)
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> [f64; 2] {
        [self.first(), self.second()]
    }

    /// Returns the first numbers of both vectors.
    #[inline(always)]
    pub(crate) fn firsts(self, other: Self) -> Self {
        Self(lanes::firsts(self.0, other.0))
    }

    /// Returns the second numbers of both vectors.
    #[inline(always)]
    pub(crate) fn seconds(self, other: Self) -> Self {
        Self(lanes::seconds(self.0, other.0))
    }

    /// Returns both numbers in the other order.
    #[inline(always)]
    pub(crate) fn swapped(self) -> Self {
        Self(lanes::swapped(self.0))
    }

    /// Returns the minimum of each lane; that of `other` if one of them is NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self(lanes::min(self.0, other.0))
    }

    /// Returns the maximum of each lane; that of `other` if one of them is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(lanes::max(self.0, other.0))
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(lanes::and_not(lanes::new(-0.0, -0.0), self.0))
    }

    /// Negates the lanes in which the mask is false.
    #[inline(always)]
    pub(crate) fn negated_unless(self, mask: Mask) -> Self {
        Self(lanes::xor(self.0, lanes::and_not(mask.0, lanes::new(-0.0, -0.0))))
    }

    /// Negates the lanes in which the sign bit of `sign` is set.
    #[inline(always)]
    pub(crate) fn times_sign_of(self, sign: Self) -> Self {
        Self(lanes::xor(self.0, lanes::and(lanes::new(-0.0, -0.0), sign.0)))
    }

    /// Compares each lane; false where one of them is NaN.
    #[inline(always)]
    pub(crate) fn less(self, other: Self) -> Mask {
        Mask(lanes::less(self.0, other.0))
    }

    /// Compares each lane; false where one of them is NaN.
    #[inline(always)]
    pub(crate) fn less_or_equal(self, other: Self) -> Mask {
        Mask(lanes::less_or_equal(self.0, other.0))
    }
}

impl Mask {
    /// Returns the lanes of `yes` where the mask is true, and those of `no` elsewhere.
    #[inline(always)]
    pub(crate) fn select(self, yes: F64x2, no: F64x2) -> F64x2 {
        F64x2(lanes::or(lanes::and(self.0, yes.0), lanes::and_not(self.0, no.0)))
    }

    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self(lanes::and(self.0, other.0))
    }

    #[inline(always)]
    pub(crate) fn or(self, other: Self) -> Self {
        Self(lanes::or(self.0, other.0))
    }

    /// Returns the exclusive or of both masks.
    #[inline(always)]
    pub(crate) fn differs(self, other: Self) -> Self {
        Self(lanes::xor(self.0, other.0))
    }

    /// Returns the first lane in both lanes.
    #[inline(always)]
    pub(crate) fn first_in_both(self) -> Self {
        Self(lanes::firsts(self.0, self.0))
    }

    /// Returns the mask as bit 0 for the first lane and bit 1 for the second.
    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        lanes::bits(self.0)
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.bits() != 0
    }

    #[inline(always)]
    pub(crate) fn all(self) -> bool {
        self.bits() == 3
    }

    /// Returns whether exactly one lane is true.
    #[inline(always)]
    pub(crate) fn is_odd(self) -> bool {
        let bits = self.bits();
        (bits ^ (bits >> 1)) & 1 != 0
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident) => {
        impl $trait for F64x2 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(lanes::$name(self.0, other.0))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

#[cfg(target_feature = "sse2")]
mod sse2 {
    #![expect(unsafe_code, reason = "intrinsics need a processor feature")]

    #[cfg(target_arch = "x86")]
    use core::arch::x86 as arch;
    #[cfg(target_arch = "x86_64")]
    use core::arch::x86_64 as arch;

    pub(super) type Lanes = arch::__m128d;

    macro_rules! lanes {
        ($($name:ident($($argument:ident: $type:ty),+) -> $result:ty = $value:expr;)+) => {
            $(
                #[inline(always)]
                pub(super) fn $name($($argument: $type),+) -> $result {
                    // SAFETY: the intrinsics need SSE2, and this module is compiled only with it.
                    unsafe { $value }
                }
            )+
        };
    }

    lanes! {
        new(a: f64, b: f64) -> Lanes = arch::_mm_set_pd(b, a);
        widen(a: f32, b: f32) -> Lanes = arch::_mm_cvtps_pd(arch::_mm_set_ps(0.0, 0.0, b, a));
        first(a: Lanes) -> f64 = arch::_mm_cvtsd_f64(a);
        second(a: Lanes) -> f64 = arch::_mm_cvtsd_f64(arch::_mm_unpackhi_pd(a, a));
        firsts(a: Lanes, b: Lanes) -> Lanes = arch::_mm_unpacklo_pd(a, b);
        seconds(a: Lanes, b: Lanes) -> Lanes = arch::_mm_unpackhi_pd(a, b);
        swapped(a: Lanes) -> Lanes = arch::_mm_shuffle_pd(a, a, 1);
        min(a: Lanes, b: Lanes) -> Lanes = arch::_mm_min_pd(a, b);
        max(a: Lanes, b: Lanes) -> Lanes = arch::_mm_max_pd(a, b);
        add(a: Lanes, b: Lanes) -> Lanes = arch::_mm_add_pd(a, b);
        sub(a: Lanes, b: Lanes) -> Lanes = arch::_mm_sub_pd(a, b);
        mul(a: Lanes, b: Lanes) -> Lanes = arch::_mm_mul_pd(a, b);
        div(a: Lanes, b: Lanes) -> Lanes = arch::_mm_div_pd(a, b);
        and(a: Lanes, b: Lanes) -> Lanes = arch::_mm_and_pd(a, b);
        and_not(a: Lanes, b: Lanes) -> Lanes = arch::_mm_andnot_pd(a, b);
        or(a: Lanes, b: Lanes) -> Lanes = arch::_mm_or_pd(a, b);
        xor(a: Lanes, b: Lanes) -> Lanes = arch::_mm_xor_pd(a, b);
        less(a: Lanes, b: Lanes) -> Lanes = arch::_mm_cmplt_pd(a, b);
        less_or_equal(a: Lanes, b: Lanes) -> Lanes = arch::_mm_cmple_pd(a, b);
        bits(a: Lanes) -> u32 = arch::_mm_movemask_pd(a) as u32;
    }
}

/// The same operations on arrays.
#[cfg(any(test, not(target_feature = "sse2")))]
mod portable {
    pub(super) type Lanes = [f64; 2];

    #[inline(always)]
    fn each(a: Lanes, b: Lanes, f: impl Fn(f64, f64) -> f64) -> Lanes {
        [f(a[0], b[0]), f(a[1], b[1])]
    }

    #[inline(always)]
    fn bitwise(a: Lanes, b: Lanes, f: impl Fn(u64, u64) -> u64) -> Lanes {
        each(a, b, |a, b| f64::from_bits(f(a.to_bits(), b.to_bits())))
    }

    #[inline(always)]
    fn truth(yes: bool) -> f64 {
        f64::from_bits(if yes { u64::MAX } else { 0 })
    }

    macro_rules! lanes {
        ($($name:ident($($argument:ident: $type:ty),+) -> $result:ty = $value:expr;)+) => {
            $(
                #[inline(always)]
                pub(super) fn $name($($argument: $type),+) -> $result {
                    $value
                }
            )+
        };
    }

    lanes! {
        new(a: f64, b: f64) -> Lanes = [a, b];
        widen(a: f32, b: f32) -> Lanes = [f64::from(a), f64::from(b)];
        first(a: Lanes) -> f64 = a[0];
        second(a: Lanes) -> f64 = a[1];
        firsts(a: Lanes, b: Lanes) -> Lanes = [a[0], b[0]];
        seconds(a: Lanes, b: Lanes) -> Lanes = [a[1], b[1]];
        swapped(a: Lanes) -> Lanes = [a[1], a[0]];
        min(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| if a < b { a } else { b });
        max(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| if a > b { a } else { b });
        add(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| a + b);
        sub(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| a - b);
        mul(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| a * b);
        div(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| a / b);
        and(a: Lanes, b: Lanes) -> Lanes = bitwise(a, b, |a, b| a & b);
        and_not(a: Lanes, b: Lanes) -> Lanes = bitwise(a, b, |a, b| !a & b);
        or(a: Lanes, b: Lanes) -> Lanes = bitwise(a, b, |a, b| a | b);
        xor(a: Lanes, b: Lanes) -> Lanes = bitwise(a, b, |a, b| a ^ b);
        less(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| truth(a < b));
        less_or_equal(a: Lanes, b: Lanes) -> Lanes = each(a, b, |a, b| truth(a <= b));
        bits(a: Lanes) -> u32 = {
            let [first, second] = a.map(|lane| (lane.to_bits() >> 63) as u32);
            first | second << 1
        };
    }
}

#[cfg(all(test, target_feature = "sse2"))]
mod tests {
    use super::{portable, sse2};

    const NUMBERS: [f32; 9] =
        [0.0, -0.0, 1.0, -2.5, 1e-40, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1e30];

    macro_rules! bits {
        ($lanes:ident, $name:ident, $($argument:expr),+) => {{
            let found = $lanes::$name($($argument),+);
            // A NaN has many bit patterns.
            let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
            [bits($lanes::first(found)), bits($lanes::second(found))]
        }};
    }

    #[test]
    fn sse2_and_arrays_give_the_same_bits() {
        macro_rules! same {
            ($($name:ident),+) => {
                for (a, b) in NUMBERS.iter().flat_map(|&a| NUMBERS.map(|b| (a, b))) {
                    let (p, q) = (sse2::widen(a, b), sse2::new(f64::from(b), 0.75));
                    let (r, s) = (portable::widen(a, b), portable::new(f64::from(b), 0.75));
                    $(assert_eq!(
                        bits!(sse2, $name, p, q), bits!(portable, $name, r, s),
                        "{} of {a} and {b}", stringify!($name)
                    );)+
                    assert_eq!(bits!(sse2, swapped, p), bits!(portable, swapped, r));
                    let (p, r) = (sse2::less(p, q), portable::less(r, s));
                    assert_eq!(sse2::bits(p), portable::bits(r), "{a} {b}");
                }
            };
        }
        same!(firsts, seconds, min, max, add, sub, mul, div, and, and_not, or, xor);
        same!(less, less_or_equal);
    }
}
