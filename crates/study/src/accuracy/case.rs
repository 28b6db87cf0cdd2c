//! One exact input as a word that can be copied: the shape and the bits of each number.
//!
//! `sphere:3f800000,...` lists the numbers of the shape, then origin, direction, `t_min` and
//! `t_max`, each as the eight hexadecimal digits of its `f32`.

use crate::truth::Exact;
use anyhow::{Context, Result, bail, ensure};
use glam::Vec3;
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Sphere};
use std::{fmt, str::FromStr};

/// A shape and a ray.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Case {
    shape: String,
    numbers: Vec<f32>,
}

/// How many numbers define a ray: origin, direction and both ends of the interval.
const RAY_NUMBERS: usize = 8;

impl Case {
    pub(crate) fn of<S: Exact>(shape: &S, ray: &Ray) -> Self {
        let mut numbers = shape.numbers();
        numbers.extend(ray.origin.to_array());
        numbers.extend(ray.direction.to_array());
        numbers.extend([ray.t_min, ray.t_max]);
        Self { shape: S::NAME.to_owned(), numbers }
    }

    /// Returns the shape and the ray, if the case is of this kind of shape.
    pub(crate) fn as_shape<S: Exact>(&self) -> Option<(S, Ray)> {
        if self.shape != S::NAME || self.numbers.len() != S::NUMBERS + RAY_NUMBERS {
            return None;
        }
        let (shape, ray) = self.numbers.split_at(S::NUMBERS);
        let ray = Ray {
            origin: Vec3::from_slice(&ray[0..3]),
            direction: Vec3::from_slice(&ray[3..6]),
            t_min: ray[6],
            t_max: ray[7],
        };
        Some((S::from_numbers(shape), ray))
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.shape)?;
        for (i, number) in self.numbers.iter().enumerate() {
            write!(f, "{}{:08x}", if i == 0 { "" } else { "," }, number.to_bits())?;
        }
        Ok(())
    }
}

impl FromStr for Case {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (shape, numbers) = text
            .split_once(':')
            .context("a case is a shape, a colon and numbers of eight hexadecimal digits")?;
        let expected = RAY_NUMBERS
            + match shape {
                Sphere::NAME => Sphere::NUMBERS,
                RoundedCone::NAME => RoundedCone::NUMBERS,
                BilinearPatch::NAME => BilinearPatch::NUMBERS,
                _ => bail!("there is no shape {shape:?}: expected sphere, cone or patch"),
            };
        let numbers = numbers
            .split(',')
            .map(|digits| {
                let bits = u32::from_str_radix(digits.trim(), 16);
                let bits = bits.with_context(|| {
                    format!("{digits:?} is not a number of eight hexadecimal digits")
                })?;
                Ok(f32::from_bits(bits))
            })
            .collect::<Result<Vec<f32>>>()?;
        ensure!(
            numbers.len() == expected,
            "a case of a {shape} has {expected} numbers, not {}",
            numbers.len()
        );
        Ok(Self { shape: shape.to_owned(), numbers })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_survives_its_own_text() {
        let sphere = Sphere { center: Vec3::new(1e-40, -0.0, 3.0), radius: 0.1 };
        let ray = Ray::new(Vec3::splat(f32::MIN_POSITIVE), Vec3::new(0.0, 1e30, -1.0));
        let text = Case::of(&sphere, &ray).to_string();
        let (same, same_ray) =
            text.parse::<Case>().expect("parses").as_shape::<Sphere>().expect("a sphere");
        let bits = |s: &Sphere| s.numbers().into_iter().map(f32::to_bits).collect::<Vec<_>>();
        assert_eq!((bits(&same), same_ray), (bits(&sphere), ray), "{text}");
    }

    #[test]
    fn a_wrong_case_says_what_was_expected() {
        for (text, message) in [
            ("sphere", "a case is a shape, a colon"),
            ("disc:00000000", "there is no shape \"disc\""),
            ("sphere:00000000", "a case of a sphere has 12 numbers, not 1"),
            ("sphere:hello", "\"hello\" is not a number of eight hexadecimal digits"),
        ] {
            let error = text.parse::<Case>().expect_err(text).to_string();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
