//! One exact input as a word that can be pasted: the shape and the bits of each number.
//!
//! `sphere:3f800000,...` lists the numbers of the shape, then origin, direction, t_min and t_max, each
//! as the eight hexadecimal digits of its `f32`.

use std::{fmt, str::FromStr};

use anyhow::{Context, Result, bail, ensure};
use glam::Vec3;
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Sphere};

use super::{
    methods::Measured,
    tally::Collector,
    truth::{Exact, Truth},
};
use rotund_report::console::{Table, say};

/// A shape and a ray.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Case {
    shape: String,
    numbers: Vec<f32>,
}

/// Origin, direction and both ends of the interval.
const RAY_NUMBERS: usize = 8;

impl Case {
    pub(crate) fn of<S: Exact>(shape: &S, ray: &Ray) -> Self {
        let mut numbers = shape.numbers();
        numbers.extend(ray.origin.to_array());
        numbers.extend(ray.direction.to_array());
        numbers.extend([ray.t_min, ray.t_max]);
        Self { shape: S::NAME.to_owned(), numbers }
    }

    /// The shape and the ray, if the case is of this shape.
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

/// Prints the case in decimals, the true crossings and the answer of every method.
pub(crate) fn run(case: &str) -> Result<()> {
    let case: Case = case.parse()?;
    show::<Sphere>(&case)?;
    show::<RoundedCone>(&case)?;
    show::<BilinearPatch>(&case)
}

fn show<S: Measured>(case: &Case) -> Result<()> {
    let Some((shape, ray)) = case.as_shape::<S>() else { return Ok(()) };
    say(format!("{} {:?}\n{ray:?}\n", S::NAME, shape.numbers()))?;
    let truth = Truth::of(&shape, &ray);
    let mut table = Table::new(&["truth", "t", "x", "y", "z", "normal", "uv"]);
    for (i, crossing) in truth.crossings.iter().enumerate() {
        let point = crossing.point.to_f64();
        table.row([
            if truth.hit == Some(i) { "the hit" } else { "crossing" }.to_owned(),
            format!("{:.17e}", crossing.t.to_f64()),
            format!("{:.17e}", point.x),
            format!("{:.17e}", point.y),
            format!("{:.17e}", point.z),
            format!("{:.9}", crossing.normal),
            crossing.uv.map_or(String::new(), |uv| format!("{uv:.9}")),
        ]);
    }
    say(format!("{table}\n"))?;
    if truth.hit.is_none() {
        say("truth: a miss\n")?;
    }
    if truth.either {
        say("a crossing at an end of the interval, or a tangent: both answers are right\n")?;
    }
    let mut table =
        Table::new(&["method", "verdict", "t", "t error", "position error", "normal error, deg"]);
    for method in S::METHODS {
        let mut collector = Collector::default();
        let right = collector.add(method, &shape, &ray, &truth);
        let tally = collector.finish();
        let answer = (method.closest)(&shape, &ray);
        let verdict = match (tally.worst.first().map(|w| w.what), answer, right) {
            (_, _, Some(_)) => "hit",
            (None, None, _) => "miss",
            (Some(what), _, _) => what,
            (None, Some(_), None) => "hit beside a tie",
        };
        let number = |value: f64| right.map_or(String::new(), |_| format!("{value:.3e}"));
        table.row([
            method.name.to_owned(),
            verdict.to_owned(),
            answer.map_or("-".to_owned(), |hit| format!("{:e}", hit.t)),
            number(tally.t.max),
            number(tally.position.max),
            number(tally.normal.max),
        ]);
    }
    say(format!("{table}\n\nt error in units of 2^-24 t, position error of 2^-24 max(|p|, size)"))
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
