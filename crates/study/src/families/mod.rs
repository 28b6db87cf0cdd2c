//! Hard cases: tables of families, each with its levels. A new family is an entry of a table and a
//! function that generates one case.
//!
//! Cases are generated in `f64` and rounded to `f32` at the end; the truth uses the rounded
//! numbers.

mod near_origin;
mod patch;
mod rounded_cone;
mod sphere;

use glam::DVec3;
use rotund_geometry::Ray;

use crate::random::Random;
use crate::truth::{Exact, Truth};

/// The meaning of the levels of a family, if the report draws them as a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Curve {
    /// Distance of the origin, in sizes of the shape.
    Distance,
    /// Distance at which the ray passes the surface, in sizes of the shape.
    Grazing,
}

/// One way to generate hard cases.
pub(crate) struct Family<S: 'static> {
    pub(crate) name: &'static str,
    /// Why the cases are hard.
    pub(crate) why: &'static str,
    /// The levels, each of which is a row of the tables.
    pub(crate) levels: &'static [f64],
    pub(crate) curve: Option<Curve>,
    pub(crate) make: fn(&mut Random, f64) -> (S, Ray),
}

/// A shape with families.
pub(crate) trait Families: Exact {
    const FAMILIES: &'static [Family<Self>];
}

/// A family at one level.
pub(crate) struct Row<S: 'static> {
    pub(crate) family: &'static Family<S>,
    pub(crate) level: f64,
}

impl<S: Families> Row<S> {
    /// Returns shape, family and level; the random numbers of the row depend on it.
    pub(crate) fn name(&self) -> String {
        format!("{} {}", S::NAME, self.label())
    }

    /// Returns family and level.
    pub(crate) fn label(&self) -> String {
        if self.family.levels.len() == 1 {
            self.family.name.to_owned()
        } else {
            format!("{} {:e}", self.family.name, self.level)
        }
    }

    pub(crate) fn generate(&self, random: &mut Random) -> (S, Ray) {
        (self.family.make)(random, self.level)
    }
}

/// Returns all rows of a shape.
pub(crate) fn rows<S: Families>() -> impl Iterator<Item = Row<S>> {
    S::FAMILIES
        .iter()
        .flat_map(|family| family.levels.iter().map(move |&level| Row { family, level }))
}

/// Returns the ray that starts `distance` before `target` along `direction`, of unit length.
fn toward(target: DVec3, direction: DVec3, distance: f64) -> Ray {
    Ray::new((target - direction * distance).as_vec3(), direction.as_vec3())
}

/// Returns the same ray with a direction of another length.
fn with_length(mut ray: Ray, length: f64) -> Ray {
    ray.direction = (ray.direction.as_dvec3() * length).as_vec3();
    ray
}

/// Ends the interval where a careless solver selects the wrong root: between the crossings, before
/// the first or after the last.
fn with_interval<S: Exact>(random: &mut Random, shape: &S, mut ray: Ray) -> Ray {
    let ts: Vec<f64> = Truth::of(shape, &ray).crossings.iter().map(|c| c.t.to_f64()).collect();
    let (Some(&first), Some(&last)) = (ts.first(), ts.last()) else { return ray };
    let between = (0.5 * (first + last)) as f32;
    match random.index(6) {
        0 => ray.t_min = between,
        1 => ray.t_max = between,
        2 => ray.t_max = (first * 0.999) as f32,
        3 => ray.t_min = (last * 1.001) as f32,
        4 => (ray.t_min, ray.t_max) = ((first as f32).next_down(), (last as f32).next_up()),
        _ => (ray.t_min, ray.t_max) = ((first as f32).next_up(), (last as f32).next_down()),
    }
    ray
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use rotund_geometry::{BilinearPatch, RoundedCone, Sphere};

    use super::*;

    fn names_are_unique<S: Families>() {
        let mut seen = HashSet::new();
        for row in rows::<S>() {
            assert!(seen.insert(row.name()), "{} twice", row.name());
            assert!(!row.family.why.is_empty(), "{} does not say why", row.name());
        }
    }

    fn cases_are_finite_and_repeatable<S: Families>() {
        for row in rows::<S>() {
            for i in 0..50 {
                let (shape, ray) = row.generate(&mut Random::of(1, &row.name(), i));
                let (again, same) = row.generate(&mut Random::of(1, &row.name(), i));
                assert_eq!((shape.numbers(), ray), (again.numbers(), same), "{}", row.name());
                let finite = shape.numbers().iter().all(|x| x.is_finite())
                    && ray.origin.is_finite()
                    && ray.direction.is_finite();
                assert!(finite, "{} {i}: {:?} {ray:?}", row.name(), shape.numbers());
            }
        }
    }

    #[test]
    fn rows_have_names_of_their_own_and_a_reason() {
        names_are_unique::<Sphere>();
        names_are_unique::<RoundedCone>();
        names_are_unique::<BilinearPatch>();
    }

    #[test]
    fn a_case_is_finite_and_follows_from_its_seed() {
        cases_are_finite_and_repeatable::<Sphere>();
        cases_are_finite_and_repeatable::<RoundedCone>();
        cases_are_finite_and_repeatable::<BilinearPatch>();
    }

    #[test]
    fn an_interval_between_the_crossings_leaves_the_last_one() {
        let row = rows::<Sphere>().find(|row| row.family.name == "interval").expect("a family");
        let mut kinds = [0; 3];
        for i in 0..200 {
            let (shape, ray) = row.generate(&mut Random::of(1, "interval", i));
            kinds[Truth::of(&shape, &ray).hit.map_or(2, |i| i)] += 1;
        }
        assert!(kinds.iter().all(|&count| count > 20), "{kinds:?}");
    }
}
