//! Double-double arithmetic of 106 bits for oracles: the expected results of the tests, and the
//! truth of the study of accuracy in `crates/study`, which includes this file by its path.
//!
//! It shares no code with the double-double of the product, so that an error there cannot hide.
//! A [`Wide`] is the unevaluated sum of two `f64`, the second at most half a unit in the last place
//! of the first. Sum, product, quotient and root are accurate to a few units of 2⁻¹⁰⁴ over the
//! whole range that products of four `f32` reach, also without fused multiply-add.
//!
//! Source: T. J. Dekker, "A floating-point technique for extending the available precision",
//! Numerische Mathematik 18, 1971; Y. Hida, X. Li, D. Bailey, "Algorithms for quad-double precision
//! floating point arithmetic", ARITH-15, 2001.

use std::{
    cmp::Ordering,
    ops::{Add, Div, Mul, Neg, Sub},
};

use glam::{DVec3, Vec3};

/// A number with a significand of 106 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wide {
    hi: f64,
    lo: f64,
}

/// Returns the sum and its rounding error, for any two numbers.
fn two_sum(a: f64, b: f64) -> Wide {
    let hi = a + b;
    let b_part = hi - a;
    Wide { hi, lo: (a - (hi - b_part)) + (b - b_part) }
}

/// Returns the sum and its rounding error, if `|a| >= |b|`.
fn quick_two_sum(a: f64, b: f64) -> Wide {
    let hi = a + b;
    Wide { hi, lo: b - (hi - a) }
}

/// Splits `a` into two numbers of 26 bits, the sum of which is `a`.
fn split(a: f64) -> (f64, f64) {
    let scaled = 134_217_729.0 * a; // 2²⁷ + 1
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// Returns the product and its rounding error.
fn two_product(a: f64, b: f64) -> Wide {
    let hi = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Wide { hi, lo: ((ah * bh - hi) + ah * bl + al * bh) + al * bl }
}

impl Wide {
    pub(crate) const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    pub(crate) const ONE: Self = Self { hi: 1.0, lo: 0.0 };
    pub(crate) const INFINITY: Self = Self { hi: f64::INFINITY, lo: 0.0 };

    /// Rounds to the nearest `f64`.
    pub(crate) fn to_f64(self) -> f64 {
        self.hi + self.lo
    }

    pub(crate) fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// Returns the square root, or zero for a negative number, which only rounding produces here.
    pub(crate) fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Self::ZERO;
        }
        // One step of Newton's method from the root of the leading part doubles its digits.
        let guess = self.hi.sqrt();
        let rest = (self - two_product(guess, guess)).to_f64();
        quick_two_sum(guess, rest / (2.0 * guess))
    }

    pub(crate) fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    pub(crate) fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    pub(crate) fn is_finite(self) -> bool {
        self.hi.is_finite() && self.lo.is_finite()
    }
}

impl From<f64> for Wide {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl From<f32> for Wide {
    fn from(value: f32) -> Self {
        f64::from(value).into()
    }
}

impl Neg for Wide {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Wide {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        // This variant ("accurate" in Hida et al.) keeps its digits if the leading parts cancel.
        let (high, low) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let high = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(high.hi, high.lo + low.lo)
    }
}

impl Sub for Wide {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.hi, other.hi);
        quick_two_sum(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Div for Wide {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        // Long division, three digits of 53 bits.
        let first = self.hi / other.hi;
        if !first.is_finite() {
            return first.into();
        }
        let rest = self - other * first.into();
        let second = rest.hi / other.hi;
        let rest = rest - other * second.into();
        let third = rest.hi / other.hi;
        quick_two_sum(first, second) + third.into()
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.hi.partial_cmp(&other.hi) {
            Some(Ordering::Equal) => self.lo.partial_cmp(&other.lo),
            order => order,
        }
    }
}

/// A vector of [`Wide`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wide3 {
    pub(crate) x: Wide,
    pub(crate) y: Wide,
    pub(crate) z: Wide,
}

impl Wide3 {
    pub(crate) fn dot(self, other: Self) -> Wide {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    pub(crate) fn length(self) -> Wide {
        self.dot(self).sqrt()
    }

    /// Returns the vector of unit length, rounded to `f64`; zero stays zero.
    pub(crate) fn unit(self) -> DVec3 {
        let length = self.length();
        if length == Wide::ZERO { DVec3::ZERO } else { (self * (Wide::ONE / length)).to_f64() }
    }

    pub(crate) fn to_f64(self) -> DVec3 {
        DVec3::new(self.x.to_f64(), self.y.to_f64(), self.z.to_f64())
    }
}

impl From<Vec3> for Wide3 {
    fn from(v: Vec3) -> Self {
        Self { x: v.x.into(), y: v.y.into(), z: v.z.into() }
    }
}

impl From<DVec3> for Wide3 {
    fn from(v: DVec3) -> Self {
        Self { x: v.x.into(), y: v.y.into(), z: v.z.into() }
    }
}

impl Add for Wide3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Wide3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul<Wide> for Wide3 {
    type Output = Self;
    fn mul(self, scale: Wide) -> Self {
        Self { x: self.x * scale, y: self.y * scale, z: self.z * scale }
    }
}
