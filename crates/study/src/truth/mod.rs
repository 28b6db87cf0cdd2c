//! The true crossings of a ray and a shape: the `f32` input is taken as exact and solved in 106
//! bits.
//!
//! None of the formulas is one of the library's: the sphere is solved about the foot of the
//! perpendicular, the cone as the hull of two balls and a frustum, the patch by triple products.
//! Tests check each crossing independently, by its distance from the surface.

mod patch;
mod rounded_cone;
mod sphere;

use glam::{DVec2, DVec3, Vec3};
use rotund_geometry::Ray;

use crate::wide::{Wide, Wide3};

pub(crate) use rounded_cone::nearest_ball;

/// An intersection of the whole line of a ray with the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub(crate) t: Wide,
    pub(crate) point: Wide3,
    /// Normal of unit length, out of the solid; for a patch, the side where `u` and `v` are
    /// counter-clockwise.
    pub(crate) normal: DVec3,
    /// The parameters of a patch.
    pub(crate) uv: Option<DVec2>,
    /// True on the boundary of a patch, where 106 bits do not separate inside from outside.
    pub(crate) on_edge: bool,
}

/// A shape of the library, with its exact solutions.
pub(crate) trait Exact: Copy + Send + Sync + 'static {
    /// Name on the command line and in a replayed case.
    const NAME: &'static str;
    /// How many numbers define the shape.
    const NUMBERS: usize;
    /// Whether the shape is convex, so that an outward ray cannot meet it again.
    const CONVEX: bool;

    fn numbers(&self) -> Vec<f32>;
    fn from_numbers(numbers: &[f32]) -> Self;
    /// Returns all crossings of the line, also behind the origin, in the order of `t`.
    fn crossings(&self, origin: Wide3, direction: Wide3) -> Vec<Crossing>;
    /// Returns the distance of `point` from the surface near the crossing `near`.
    fn distance(&self, point: Wide3, near: &Crossing) -> f64;
    /// Returns the largest extent from the center, to which errors near the origin are relative.
    fn size(&self) -> f64;
    /// Returns the center.
    fn center(&self) -> Vec3;
}

/// The expected answer of a closest-hit query.
#[derive(Clone, Debug)]
pub(crate) struct Truth {
    /// All crossings of the line.
    pub(crate) crossings: Vec<Crossing>,
    /// Index of the first of them in the interval of the ray.
    pub(crate) hit: Option<usize>,
    /// True if a crossing lies within one rounding of an end of the interval, if the line is
    /// tangent to a solid, or if it meets the boundary of a patch. Then both answers are correct.
    pub(crate) either: bool,
}

/// Returns the unit of errors in `t`: 2⁻²⁴ of it, which bounds the error of correct rounding.
pub(crate) fn unit_of(t: f64) -> f64 {
    (t.abs() * 2f64.powi(-24)).max(2f64.powi(-150))
}

impl Truth {
    pub(crate) fn of<S: Exact>(shape: &S, ray: &Ray) -> Self {
        let crossings = if ray.direction == Vec3::ZERO {
            Vec::new()
        } else {
            shape.crossings(ray.origin.into(), ray.direction.into())
        };
        let (t_min, t_max) = (Wide::from(ray.t_min), Wide::from(ray.t_max));
        let hit = crossings.iter().position(|c| c.t >= t_min && c.t <= t_max);
        let at_end = |c: &Crossing| {
            let t = c.t.to_f64();
            [ray.t_min, ray.t_max]
                .into_iter()
                .map(f64::from)
                .any(|end| end.is_finite() && end != 0.0 && (t - end).abs() <= unit_of(t))
        };
        // 106 bits do not separate a tangent line from one that misses by less.
        let touches = |a: &Crossing, b: &Crossing| {
            S::CONVEX && (b.point - a.point).length().to_f64() <= 1e-13 * shape.size()
        };
        let either = crossings.iter().any(|c| at_end(c) || c.on_edge)
            || crossings.windows(2).any(|w| touches(&w[0], &w[1]));
        Self { crossings, hit, either }
    }

    pub(crate) fn first(&self) -> Option<&Crossing> {
        self.hit.map(|i| &self.crossings[i])
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::families;
    use crate::random::Random;

    /// Solves rays of every family and checks each crossing by its distance to the surface.
    pub(super) fn every_crossing_lies_on_the_surface<S: families::Families>() {
        let mut hits = 0;
        for row in families::rows::<S>() {
            for i in 0..100 {
                let (shape, ray) = row.generate(&mut Random::of(7, &row.name(), i));
                let truth = Truth::of(&shape, &ray);
                for crossing in &truth.crossings {
                    let along = Wide3::from(ray.origin) + Wide3::from(ray.direction) * crossing.t;
                    let scale = along.to_f64().length()
                        + ray.origin.as_dvec3().length()
                        + shape.center().as_dvec3().length()
                        + shape.size();
                    let off = shape.distance(along, crossing) / scale;
                    assert!(
                        off < 1e-13,
                        "{} {i}: {off:e} off\n{shape:?}\n{ray:?}",
                        row.name(),
                        shape = shape.numbers()
                    );
                    assert!((crossing.normal.length() - 1.0).abs() < 1e-12, "{} {i}", row.name());
                    hits += 1;
                }
                assert!(truth.crossings.is_sorted_by(|a, b| a.t <= b.t), "{} {i}", row.name());
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}
