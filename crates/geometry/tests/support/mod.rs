//! Shared by the integration tests: seeded random numbers, and double-double arithmetic.
#![allow(dead_code, unused_imports, reason = "each test file uses a part")]

#[path = "../../src/test_random.rs"]
mod random;

use core::ops::{Add, Mul, Neg, Sub};

use rotund_geometry::Ray;
use rotund_geometry::glam::{DVec3, Vec3};

pub(crate) use random::Random;

pub(crate) fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray::new(origin.as_vec3(), direction.as_vec3())
}

/// A double-double, `high + low`, with 106 bits.
///
/// It is written independently of the one under test: the error of a product comes from a fused
/// multiply-add.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(crate) struct Wide(pub(crate) f64, pub(crate) f64);

impl From<f32> for Wide {
    fn from(x: f32) -> Self {
        Self(f64::from(x), 0.0)
    }
}

impl From<f64> for Wide {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

fn two_sum(a: f64, b: f64) -> Wide {
    let sum = a + b;
    let b_part = sum - a;
    Wide(sum, (a - (sum - b_part)) + (b - b_part))
}

impl Add for Wide {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.0, other.0), two_sum(self.1, other.1));
        let high = two_sum(high.0, high.1 + low.0);
        two_sum(high.0, high.1 + low.1)
    }
}

impl Neg for Wide {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
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
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product);
        two_sum(product, error + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Wide {
    pub(crate) fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self(0.0, 0.0);
        }
        let root = Self(self.0.sqrt(), 0.0);
        let rest = self - root * root;
        root + Self(rest.0 / (2.0 * root.0), 0.0)
    }

    pub(crate) fn over(self, other: Self) -> Self {
        let first = Self(self.0 / other.0, 0.0);
        let rest = self - first * other;
        let second = Self(rest.0 / other.0, 0.0);
        let rest = rest - second * other;
        first + second + Self(rest.0 / other.0, 0.0)
    }
}

pub(crate) type Wide3 = [Wide; 3];

pub(crate) fn wide(p: Vec3) -> Wide3 {
    p.to_array().map(Wide::from)
}

pub(crate) fn minus(a: Wide3, b: Wide3) -> Wide3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Wide3, b: Wide3) -> Wide {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the point of a ray at an exact `t`.
pub(crate) fn at(ray: &Ray, t: Wide) -> Wide3 {
    let (o, d) = (wide(ray.origin), wide(ray.direction));
    [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
}

/// Returns the smallest and the largest real that round to `t`, slightly widened.
pub(crate) fn rounding_interval(t: f32) -> [Wide; 2] {
    let (t, below, above) = (f64::from(t), f64::from(t.next_down()), f64::from(t.next_up()));
    let slack = 1e-12 * (above - below);
    [Wide::from(0.5 * (t + below) - slack), Wide::from(0.5 * (t + above) + slack)]
}

/// Returns `2⁻²⁴` times the larger of the length of `p` and `size`.
pub(crate) fn local_unit(p: Vec3, size: f32) -> f64 {
    f64::from(p.length().max(size)) * 2.0_f64.powi(-24)
}

/// Returns the angle in degrees between a rounded normal and an exact direction of any length.
pub(crate) fn degrees(normal: Vec3, exact: DVec3) -> f64 {
    let n = normal.as_dvec3();
    n.cross(exact).length().atan2(n.dot(exact)).to_degrees()
}
