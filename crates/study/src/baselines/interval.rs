//! Intervals of `f32` that contain the exact result, by rounding both ends outwards.

use std::ops::{Add, Div, Mul, Sub};

/// The numbers `low..=high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) low: f32,
    pub(crate) high: f32,
}

impl Interval {
    pub(crate) const fn exact(value: f32) -> Self {
        Self { low: value, high: value }
    }

    pub(crate) fn middle(self) -> f32 {
        0.5 * (self.low + self.high)
    }

    pub(crate) fn sqrt(self) -> Self {
        Self {
            low: self.low.max(0.0).sqrt().next_down().max(0.0),
            high: self.high.sqrt().next_up(),
        }
    }

    fn around(values: [f32; 4]) -> Self {
        let low = values.into_iter().fold(f32::INFINITY, f32::min);
        let high = values.into_iter().fold(f32::NEG_INFINITY, f32::max);
        Self { low: low.next_down(), high: high.next_up() }
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { low: (self.low + other.low).next_down(), high: (self.high + other.high).next_up() }
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { low: (self.low - other.high).next_down(), high: (self.high - other.low).next_up() }
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::around([
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ])
    }
}

impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if other.low <= 0.0 && other.high >= 0.0 {
            return Self { low: f32::NEG_INFINITY, high: f32::INFINITY };
        }
        Self::around([
            self.low / other.low,
            self.low / other.high,
            self.high / other.low,
            self.high / other.high,
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn an_interval_contains_the_exact_result() {
        let mut random = Random::new(1);
        for _ in 0..10_000 {
            let (x, y) = (random.range(-9.0, 9.0) as f32, random.range(0.1, 9.0) as f32);
            let (a, b) = (Interval::exact(x), Interval::exact(y));
            let (x, y) = (f64::from(x), f64::from(y));
            for (found, exact) in [
                (a + b, x + y),
                (a - b, x - y),
                (a * b, x * y),
                (a / b, x / y),
                (b.sqrt(), y.sqrt()),
            ] {
                let range = f64::from(found.low)..=f64::from(found.high);
                assert!(range.contains(&exact), "{exact} in {found:?}");
            }
        }
    }
}
