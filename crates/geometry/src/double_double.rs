//! Double-double arithmetic: numbers of 106 bits as the unevaluated sum of two `f64`.
//!
//! The exact evaluations use it for the few rays whose answer depends on digits that an `f64` does
//! not have: those that graze, and those that start next to the surface. It is some twenty times
//! slower than `f64`.
//!
//! Source: T. J. Dekker, "A floating-point technique for extending the available precision",
//! Numerische Mathematik 18, 1971. It uses no fused multiply-add, so that every processor computes
//! the same bits.

#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// `2⁻⁹⁰`. A ray that starts nearer to a surface than this share of the terms of its root starts on
/// it, and the root is zero: 106 bits compute it as some `2⁻¹⁰⁰` of the terms, of either sign.
pub(crate) const ON_SURFACE: f64 = 1.0 / (1_u128 << 90) as f64;

/// The operations of a solver, so that it is written once for `f64` and [`DoubleDouble`].
pub(crate) trait Real:
    Copy
    + PartialOrd
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    const ZERO: Self;
    fn exact(x: f32) -> Self;
    fn square_root(self) -> Self;
    fn nearest(self) -> f64;
    fn widen(self) -> DoubleDouble;
}

impl Real for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn exact(x: f32) -> Self {
        Self::from(x)
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn nearest(self) -> f64 {
        self
    }

    #[inline(always)]
    fn widen(self) -> DoubleDouble {
        DoubleDouble { high: self, low: 0.0 }
    }
}

/// The number `high + low`, where `high` is the sum rounded to `f64`.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(crate) struct DoubleDouble {
    high: f64,
    low: f64,
}

/// Returns `a + b` and the rounding error of that sum, which is an `f64`.
#[inline]
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let b_part = high - a;
    DoubleDouble { high, low: (a - (high - b_part)) + (b - b_part) }
}

/// Returns the same as [`two_sum`] for `|a| >= |b|`.
#[inline]
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble { high, low: b - (high - a) }
}

/// Returns `a b` and the rounding error of that product, by splitting both factors into halves of
/// 26 bits.
#[inline]
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let split = |x: f64| {
        let scaled = 134_217_729.0 * x;
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let high = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    DoubleDouble { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
}

impl Add for DoubleDouble {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let (sum, low) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let sum = quick_two_sum(sum.high, sum.low + low.high);
        quick_two_sum(sum.high, sum.low + low.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.high, other.high);
        let low = product.low + (self.high * other.low + self.low * other.high);
        quick_two_sum(product.high, low)
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        if !first.is_finite() {
            return Self { high: first, low: 0.0 };
        }
        let step = |quotient: f64| Self { high: quotient, low: 0.0 } * other;
        let rest = self - step(first);
        let second = rest.high / other.high;
        let third = (rest - step(second)).high / other.high;
        quick_two_sum(first, second) + Self { high: third, low: 0.0 }
    }
}

impl Real for DoubleDouble {
    const ZERO: Self = Self { high: 0.0, low: 0.0 };

    #[inline]
    fn exact(x: f32) -> Self {
        Self { high: f64::from(x), low: 0.0 }
    }

    /// Improves the rounded root by one Newton step, which doubles its digits.
    #[inline]
    fn square_root(self) -> Self {
        let root = self.high.sqrt();
        if !(root > 0.0 && root.is_finite()) {
            return Self { high: root, low: 0.0 };
        }
        let rest = self - two_product(root, root);
        quick_two_sum(root, rest.high / (2.0 * root))
    }

    #[inline]
    fn nearest(self) -> f64 {
        self.high
    }

    #[inline]
    fn widen(self) -> DoubleDouble {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_far_below_the_leading_ones_survive() {
        let one = DoubleDouble::exact(1.0);
        let tiny = DoubleDouble::exact(2.0_f32.powi(-80));
        assert_eq!(((one + tiny) - one).nearest(), 2.0_f64.powi(-80));
        assert_eq!(((one + tiny) * (one - tiny) - one).nearest(), 0.0);
        let square = (one + tiny) * (one + tiny);
        assert_eq!((square - one).nearest(), 2.0_f64.powi(-79));
    }

    #[test]
    fn quotients_and_roots_undo_products() {
        for (x, y) in [(3.0, 7.0), (1e-20, 1e20), (0.1, 1e-3), (5e30, 0.3)] {
            let (x, y) = (DoubleDouble::exact(x), DoubleDouble::exact(y));
            let back = (x / y) * y - x;
            assert!(back.nearest().abs() <= 1e-31 * x.nearest(), "{back:?}");
            let back = x.square_root() * x.square_root() - x;
            assert!(back.nearest().abs() <= 1e-31 * x.nearest(), "{back:?}");
        }
    }

    #[test]
    fn the_root_of_zero_is_zero_and_only_zero_over_zero_is_nan() {
        let (zero, one) = (DoubleDouble::ZERO, DoubleDouble::exact(1.0));
        assert_eq!(zero.square_root().nearest(), 0.0);
        assert_eq!((one / zero).nearest(), f64::INFINITY);
        assert!((zero / zero).nearest().is_nan());
    }
}
