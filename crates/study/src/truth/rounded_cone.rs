//! A line and a rounded cone: the hull of two balls, the balls and the frustum between them.
//!
//! The hull is convex, so the line is inside it from the first entry into one of the three parts to
//! the last exit, and the parts cover it. With `a = p1 - p0`, `L² = a·a`, `δ = r0 - r1` and
//! `g = L² - δ²`, a plane across the axis holds the circle where the cone touches a ball; with
//! `y = (x - p0)·a` these are `y = r0 δ` and `y = L² + r1 δ`, and between them the frustum is
//! `|(x - p0) × a|² g <= (r0 L² - y δ)²`.

use glam::Vec3;
use rotund_geometry::RoundedCone;

use super::{Crossing, Exact, sphere::ball};
use crate::wide::{Wide, Wide3};

impl Exact for RoundedCone {
    const NAME: &'static str = "cone";
    const NUMBERS: usize = 8;
    const CONVEX: bool = true;

    fn numbers(&self) -> Vec<f32> {
        let Self { p0, r0, p1, r1 } = self;
        vec![p0.x, p0.y, p0.z, *r0, p1.x, p1.y, p1.z, *r1]
    }

    fn from_numbers(n: &[f32]) -> Self {
        Self {
            p0: Vec3::new(n[0], n[1], n[2]),
            r0: n[3],
            p1: Vec3::new(n[4], n[5], n[6]),
            r1: n[7],
        }
    }

    fn crossings(&self, origin: Wide3, direction: Wide3) -> Vec<Crossing> {
        let (p0, p1) = (Wide3::from(self.p0), Wide3::from(self.p1));
        let (r0, r1) = (Wide::from(self.r0), Wide::from(self.r1));
        // Relative to a point of the line near the shape, so that no long distance is squared.
        let middle = (p0 + p1) * Wide::from(0.5);
        let near = (middle - origin).dot(direction) / direction.dot(direction);
        let start = origin + direction * near;

        let parts = [
            ball(start, direction, p0, r0),
            ball(start, direction, p1, r1),
            frustum(start - p0, direction, p1 - p0, r0, r1),
        ];
        let Some((enter, leave)) =
            parts.into_iter().flatten().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        else {
            return Vec::new();
        };
        let at = |t: Wide| {
            let point = start + direction * t;
            let (center, _) = nearest_ball(self, point);
            Crossing {
                t: near + t,
                point,
                normal: (point - center).unit(),
                uv: None,
                on_edge: false,
            }
        };
        vec![at(enter), at(leave)]
    }

    fn distance(&self, point: Wide3, _near: &Crossing) -> f64 {
        let (center, radius) = nearest_ball(self, point);
        ((point - center).length() - radius).abs().to_f64()
    }

    fn size(&self) -> f64 {
        0.5 * self.p0.as_dvec3().distance(self.p1.as_dvec3()) + f64::from(self.r0.max(self.r1))
    }

    fn center(&self) -> Vec3 {
        0.5 * self.p0 + 0.5 * self.p1
    }
}

/// Returns the interval where the line is between the two planes and inside the cone.
fn frustum(x: Wide3, d: Wide3, a: Wide3, r0: Wide, r1: Wide) -> Option<(Wide, Wide)> {
    let (l2, delta) = (a.dot(a), r0 - r1);
    let g = l2 - delta * delta;
    if g <= Wide::ZERO {
        return None; // one ball holds the other
    }
    let (y, dy) = (x.dot(a), d.dot(a));
    let (low, high) = (r0 * delta, l2 + r1 * delta);
    let slab = if dy == Wide::ZERO {
        if y < low || y > high {
            return None;
        }
        (-Wide::INFINITY, Wide::INFINITY)
    } else {
        let (t0, t1) = ((low - y) / dy, (high - y) / dy);
        (t0.min(t1), t0.max(t1))
    };
    // α t² + 2 β t + γ <= 0 inside the double cone.
    let (across, turning) = (x.cross(a), d.cross(a));
    let (radius, slope) = (r0 * l2 - y * delta, -(dy * delta));
    let alpha = turning.dot(turning) * g - slope * slope;
    let beta = across.dot(turning) * g - radius * slope;
    let gamma = across.dot(across) * g - radius * radius;
    let clip = |from: Wide, to: Wide| {
        let (from, to) = (slab.0.max(from), slab.1.min(to));
        (from <= to).then_some((from, to))
    };

    let discriminant = beta * beta - alpha * gamma;
    // A tangent within the resolution counts, as with a ball.
    let terms = turning.dot(turning) * g * (across.dot(across) * g + radius * radius);
    let resolution = Wide::from(2f64.powi(-97)) * terms;
    let touches = discriminant.abs() <= resolution;
    let discriminant = if touches { Wide::ZERO } else { discriminant };
    if alpha == Wide::ZERO && beta == Wide::ZERO {
        return if gamma <= Wide::ZERO { clip(slab.0, slab.1) } else { None };
    }
    if discriminant < Wide::ZERO {
        return None;
    }
    let root = discriminant.sqrt();
    let q = if beta < Wide::ZERO { root - beta } else { -(beta + root) };
    let (t0, t1) = if q == Wide::ZERO {
        (Wide::ZERO, Wide::ZERO)
    } else if alpha == Wide::ZERO {
        // The line is parallel to a generator: it is inside on one side of the only root.
        let t = gamma / q;
        return if beta > Wide::ZERO { clip(-Wide::INFINITY, t) } else { clip(t, Wide::INFINITY) };
    } else {
        let (a, b) = (q / alpha, gamma / q);
        (a.min(b), a.max(b))
    };
    if alpha > Wide::ZERO {
        return clip(t0, t1);
    }
    // The line is steeper than the cone: it is inside before one root and after the other, in two
    // nappes, of which the planes select one.
    match (clip(-Wide::INFINITY, t0), clip(t1, Wide::INFINITY)) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (a, b) => a.or(b),
    }
}

/// Returns the ball of the sweep whose surface is nearest to `x`: the minimum of
/// `|x - c(s)| - r(s)`, which is a convex function of `s`.
pub(crate) fn nearest_ball(cone: &RoundedCone, x: Wide3) -> (Wide3, Wide) {
    let (p0, p1) = (Wide3::from(cone.p0), Wide3::from(cone.p1));
    let (r0, r1) = (Wide::from(cone.r0), Wide::from(cone.r1));
    let a = p1 - p0;
    let (l2, delta) = (a.dot(a), r0 - r1);
    let g = l2 - delta * delta;
    if g <= Wide::ZERO {
        return if delta >= Wide::ZERO { (p0, r0) } else { (p1, r1) };
    }
    // The normal leans towards p1 by the angle whose sine is δ / L.
    let x = x - p0;
    let s = (x.dot(a) - x.cross(a).length() * delta / g.sqrt()) / l2;
    let s = s.max(Wide::ZERO).min(Wide::ONE);
    (p0 + a * s, r0 - delta * s)
}

#[cfg(test)]
mod tests {
    use rotund_geometry::Ray;

    use super::*;
    use crate::truth::{Truth, tests::every_crossing_lies_on_the_surface};

    #[test]
    fn every_crossing_of_every_family_lies_on_the_cone() {
        every_crossing_lies_on_the_surface::<RoundedCone>();
    }

    #[test]
    fn known_answers() {
        let fat = RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::new(0.0, 0.0, 3.0), r1: 0.5 };
        let even = RoundedCone { r1: 1.0, ..fat };
        let nested = RoundedCone { p1: Vec3::new(0.0, 0.0, 0.3), ..fat };
        let side = (9.0f64 - 0.25).sqrt() / 3.0; // cosine of the half angle
        let table = [
            // why it is hard                       cone    origin             direction         t
            ("along the axis", fat, [0.0, 0.0, -5.0], [0.0, 0.0, 1.0], (4.0, 8.5)),
            ("along the axis, against it", fat, [0.0, 0.0, 5.0], [0.0, 0.0, -1.0], (1.5, 6.0)),
            ("across the body of a cylinder", even, [0.0, -5.0, 1.5], [0.0, 1.0, 0.0], (4.0, 6.0)),
            (
                "across the body",
                fat,
                [0.0, -5.0, 1.5],
                [0.0, 1.0, 0.0],
                (5.0 - 0.75 / side, 5.0 + 0.75 / side),
            ),
            ("along a cylinder's side", even, [1.0, 0.0, -5.0], [0.0, 0.0, 1.0], (5.0, 8.0)),
            ("one ball holds the other", nested, [0.0, -5.0, 0.0], [0.0, 1.0, 0.0], (4.0, 6.0)),
            ("across the cap of p0", fat, [0.0, -5.0, -0.6], [0.0, 1.0, 0.0], (4.2, 5.8)),
            ("a direction of length 2", even, [0.0, -5.0, 1.5], [0.0, 2.0, 0.0], (2.0, 3.0)),
        ];
        for (why, cone, origin, direction, (enter, leave)) in table {
            let truth = Truth::of(&cone, &Ray::new(origin.into(), direction.into()));
            let found: Vec<f64> = truth.crossings.iter().map(|c| c.t.to_f64()).collect();
            assert!(
                found.len() == 2
                    && (found[0] - enter).abs() < 5e-8
                    && (found[1] - leave).abs() < 5e-8,
                "{why}: {found:?} for {enter} {leave}"
            );
        }
        let beside = Truth::of(&even, &Ray::new(Vec3::new(1.0001, 0.0, -5.0), Vec3::Z));
        assert!(beside.crossings.is_empty(), "beside the side of a cylinder");
    }
}
