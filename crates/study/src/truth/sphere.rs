//! A line and a sphere, about the foot of the perpendicular from the center.

use glam::Vec3;
use rotund_geometry::Sphere;

use super::{Crossing, Exact};
use crate::wide::{Wide, Wide3};

impl Exact for Sphere {
    const NAME: &'static str = "sphere";
    const NUMBERS: usize = 4;
    const CONVEX: bool = true;

    fn numbers(&self) -> Vec<f32> {
        vec![self.center.x, self.center.y, self.center.z, self.radius]
    }

    fn from_numbers(n: &[f32]) -> Self {
        Self { center: Vec3::new(n[0], n[1], n[2]), radius: n[3] }
    }

    fn crossings(&self, origin: Wide3, direction: Wide3) -> Vec<Crossing> {
        let Some((near, far)) = ball(origin, direction, self.center.into(), self.radius.into())
        else {
            return Vec::new();
        };
        let at = |t: Wide| {
            let point = origin + direction * t;
            Crossing {
                t,
                point,
                normal: (point - self.center.into()).unit(),
                uv: None,
                on_edge: false,
            }
        };
        vec![at(near), at(far)]
    }

    fn distance(&self, point: Wide3, _near: &Crossing) -> f64 {
        ((point - self.center.into()).length() - self.radius.into()).abs().to_f64()
    }

    fn size(&self) -> f64 {
        self.radius.into()
    }

    fn center(&self) -> Vec3 {
        self.center
    }
}

/// Returns where the line enters and leaves a ball.
///
/// The foot of the perpendicular lies at `t = (c - o)·d / d·d`; half the chord follows by
/// Pythagoras, as a product of sum and difference so that a grazing chord keeps its digits.
pub(super) fn ball(
    origin: Wide3,
    direction: Wide3,
    center: Wide3,
    radius: Wide,
) -> Option<(Wide, Wide)> {
    let to_center = center - origin;
    let squared = direction.dot(direction);
    let foot = to_center.dot(direction) / squared;
    let away = to_center - direction * foot;
    let (apart, square) = (away.length(), away.dot(away));
    // A tangent within the resolution counts as a crossing here, and `Truth` accepts either answer.
    if square > radius * radius * (Wide::ONE + Wide::from(2f64.powi(-98))) {
        return None;
    }
    let half = ((radius - apart) * (radius + apart) / squared).sqrt();
    Some((foot - half, foot + half))
}

#[cfg(test)]
mod tests {
    use rotund_geometry::Ray;

    use super::*;
    use crate::truth::{Truth, tests::every_crossing_lies_on_the_surface};

    #[test]
    fn every_crossing_of_every_family_lies_on_the_sphere() {
        every_crossing_lies_on_the_surface::<Sphere>();
    }

    #[test]
    fn known_answers() {
        let unit = Sphere { center: Vec3::ZERO, radius: 1.0 };
        let table = [
            // why origin direction t of both crossings
            ("through the middle", [-5.0, 0.0, 0.0], [1.0, 0.0, 0.0], Some((4.0, 6.0))),
            ("a direction of length 2", [-5.0, 0.0, 0.0], [2.0, 0.0, 0.0], Some((2.0, 3.0))),
            ("the 3-4-5 triangle", [-5.0, 0.6, 0.0], [1.0, 0.0, 0.0], Some((4.2, 5.8))),
            ("from inside", [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], Some((-1.0, 1.0))),
            ("touches", [-5.0, 1.0, 0.0], [1.0, 0.0, 0.0], Some((5.0, 5.0))),
            ("passes by one rounding", [-5.0, 1.0 + f32::EPSILON, 0.0], [1.0, 0.0, 0.0], None),
        ];
        for (why, origin, direction, expected) in table {
            let truth = Truth::of(&unit, &Ray::new(origin.into(), direction.into()));
            let found: Vec<f64> = truth.crossings.iter().map(|c| c.t.to_f64()).collect();
            let expected = expected.map_or(vec![], |(a, b)| vec![a, b]);
            assert_eq!(found.len(), expected.len(), "{why}");
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() < 2e-8, "{why}: {found:?}"); // 0.6 is not an f32
            }
        }
    }

    #[test]
    fn a_root_that_f64_cannot_resolve_is_resolved() {
        // The ray passes 1 - 2⁻²⁴ radii from the center of a sphere at a distance of 2³⁰ radii; in
        // f64 the squares of both cancel to nothing. Half the chord is √(2⁻²³ - 2⁻⁴⁸).
        let sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };
        let origin = Vec3::new(-(2f32.powi(30)), 1.0 - 2f32.powi(-24), 0.0);
        let truth = Truth::of(&sphere, &Ray::new(origin, Vec3::X));
        let half = (2f64.powi(-23) - 2f64.powi(-48)).sqrt();
        let chord = (truth.crossings[1].t - truth.crossings[0].t).to_f64();
        assert!((chord - 2.0 * half).abs() < 1e-20, "{chord}");
    }
}
