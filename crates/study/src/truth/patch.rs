//! A line and a bilinear patch, by triple products.
//!
//! For one `u` the patch is the segment from `A(u)` to `A(u) + E(u)`. It meets the line where `A`,
//! `E` and the direction lie in a plane through a point of the line, `d·(A × E) = 0`: a quadratic
//! in `u`. Where the segment is nearly parallel to the line the same is done with `u` and `v`
//! exchanged.
//!
//! Source: A. Reshetov, "Cool patches: a geometric approach to ray/bilinear patch intersections",
//! in Ray Tracing Gems, 2019, for the quadratic; Newton's method for the last digits.

use glam::{DMat2, DVec2, DVec3, Vec3};
use rotund_geometry::BilinearPatch;

use super::{Crossing, Exact};
use crate::wide::{Wide, Wide3};

/// Parameters nearer than this to 0 or 1 count as on the boundary: with 106 bits a ray exactly
/// through a corner may come out on either side. Only one of two neighbours counts such a ray.
const RIM: f64 = 1e-24;

/// The patch as `q + u e + v f + u v w`.
#[derive(Clone, Copy)]
struct Bilinear {
    q: Wide3,
    e: Wide3,
    f: Wide3,
    w: Wide3,
}

impl Bilinear {
    /// Returns the patch relative to `from`.
    fn of(patch: &BilinearPatch, from: Wide3) -> Self {
        let [p00, p10, p01, p11] = [patch.p00, patch.p10, patch.p01, patch.p11].map(Wide3::from);
        Self { q: p00 - from, e: p10 - p00, f: p01 - p00, w: (p11 - p10) - (p01 - p00) }
    }

    fn exchanged(self) -> Self {
        Self { e: self.f, f: self.e, ..self }
    }

    fn at(self, u: Wide, v: Wide) -> Wide3 {
        self.q + self.e * u + (self.f + self.w * u) * v
    }
}

/// A solution, with the squared sine of the angle between its segment and the line as its quality.
#[derive(Clone, Copy)]
struct Root {
    u: Wide,
    v: Wide,
    t: Wide,
    quality: f64,
}

impl Exact for BilinearPatch {
    const NAME: &'static str = "patch";
    const NUMBERS: usize = 12;
    const CONVEX: bool = false;

    fn numbers(&self) -> Vec<f32> {
        [self.p00, self.p10, self.p01, self.p11].iter().flat_map(Vec3::to_array).collect()
    }

    fn from_numbers(n: &[f32]) -> Self {
        let p = |i: usize| Vec3::new(n[i], n[i + 1], n[i + 2]);
        Self { p00: p(0), p10: p(3), p01: p(6), p11: p(9) }
    }

    fn crossings(&self, origin: Wide3, direction: Wide3) -> Vec<Crossing> {
        let near = (Wide3::from(self.center()) - origin).dot(direction) / direction.dot(direction);
        let start = origin + direction * near;
        let patch = Bilinear::of(self, start);
        let by_u = solve(patch, direction);
        let by_v = solve(patch.exchanged(), direction)
            .map(|root| root.map(|r| Root { u: r.v, v: r.u, ..r }));
        let worst = |roots: &[Option<Root>; 2]| {
            roots.iter().flatten().map(|r| r.quality).fold(f64::INFINITY, f64::min)
        };
        let roots = match (by_u.iter().any(Option::is_some), by_v.iter().any(Option::is_some)) {
            (true, true) if worst(&by_v) > worst(&by_u) => by_v,
            (false, true) => by_v,
            _ => by_u,
        };
        let range = -Wide::from(RIM)..=Wide::ONE + Wide::from(RIM);
        let at_rim =
            |x: Wide| x.abs() <= Wide::from(RIM) || (x - Wide::ONE).abs() <= Wide::from(RIM);
        let mut found: Vec<Crossing> = roots
            .into_iter()
            .flatten()
            .map(|root| polish(patch, direction, root))
            .filter(|root| range.contains(&root.u) && range.contains(&root.v))
            .map(|Root { u, v, t, .. }| Crossing {
                t: near + t,
                point: start + direction * t,
                normal: (patch.e + patch.w * v).cross(patch.f + patch.w * u).unit(),
                uv: Some(DVec2::new(u.to_f64(), v.to_f64())),
                on_edge: at_rim(u) || at_rim(v),
            })
            .filter(|crossing| crossing.t.is_finite() && crossing.normal != DVec3::ZERO)
            .collect();
        found.sort_by(|a, b| a.t.partial_cmp(&b.t).expect("a finite t is ordered"));
        found
    }

    fn distance(&self, point: Wide3, near: &Crossing) -> f64 {
        let start = near.uv.expect("a crossing of a patch has parameters");
        distance_from_zero(Bilinear::of(self, point), start)
    }

    fn size(&self) -> f64 {
        let center = self.center();
        [self.p00, self.p10, self.p01, self.p11]
            .iter()
            .map(|p| p.as_dvec3().distance(center.as_dvec3()))
            .fold(0.0, f64::max)
    }

    fn center(&self) -> Vec3 {
        (0.25 * self.p00 + 0.25 * self.p10) + (0.25 * self.p01 + 0.25 * self.p11)
    }
}

/// Returns the points of `p` on the line through the origin along `d`, by the quadratic in `u`.
fn solve(p: Bilinear, d: Wide3) -> [Option<Root>; 2] {
    let a = d.dot(p.e.cross(p.w));
    let b = d.dot(p.q.cross(p.w)) + d.dot(p.e.cross(p.f));
    let c = d.dot(p.q.cross(p.f));
    let discriminant = b * b - Wide::from(4.0) * a * c;
    if discriminant < Wide::ZERO {
        return [None, None];
    }
    let root = discriminant.sqrt();
    let q = (if b < Wide::ZERO { b - root } else { b + root }) * Wide::from(-0.5);
    // Without a quadratic term one root is infinite and the other is still accurate.
    let us = [(q != Wide::ZERO).then(|| c / q), (a != Wide::ZERO).then(|| q / a)];
    us.map(|u| {
        let u = u.filter(|u| u.is_finite() && u.abs() < Wide::from(1e3))?;
        let (start, edge) = (p.q + p.e * u, p.f + p.w * u);
        let turned = edge.cross(d);
        let square = turned.dot(turned);
        if square == Wide::ZERO {
            return None;
        }
        let v = -(start.cross(d).dot(turned) / square);
        let t = (start + edge * v).dot(d) / d.dot(d);
        let lengths = d.dot(d) * (p.e.dot(p.e) + p.f.dot(p.f) + p.w.dot(p.w));
        Some(Root { u, v, t, quality: (square / lengths).to_f64() })
    })
}

/// Takes one step of Newton's method for `p(u, v) = t d`, and keeps it if the residual shrinks.
fn polish(p: Bilinear, d: Wide3, root: Root) -> Root {
    let rest = |r: &Root| p.at(r.u, r.v) - d * r.t;
    let (along_u, along_v) = (p.e + p.w * root.v, p.f + p.w * root.u);
    let determinant = d.dot(along_u.cross(along_v));
    if determinant == Wide::ZERO {
        return root;
    }
    let r = rest(&root);
    let better = Root {
        u: root.u - d.dot(r.cross(along_v)) / determinant,
        v: root.v - d.dot(along_u.cross(r)) / determinant,
        t: root.t + r.dot(along_u.cross(along_v)) / determinant,
        quality: root.quality,
    };
    let nearer = rest(&better).dot(rest(&better)) < r.dot(r);
    if nearer { better } else { root }
}

/// Returns the distance of the patch from zero near `start`, by damped Gauss-Newton in the unit
/// square.
///
/// The patch was moved to the point in 106 bits, so `f64` resolves 10⁻¹⁶ of its size.
fn distance_from_zero(p: Bilinear, start: DVec2) -> f64 {
    let [q, e, f, w] = [p.q, p.e, p.f, p.w].map(Wide3::to_f64);
    let at = |uv: DVec2| q + e * uv.x + f * uv.y + w * (uv.x * uv.y);
    let mut uv = start.clamp(DVec2::ZERO, DVec2::ONE);
    let mut best = at(uv).length_squared();
    let mut damping = 1e-9;
    for _ in 0..40 {
        let (rest, along_u, along_v) = (at(uv), e + w * uv.y, f + w * uv.x);
        let gradient = DVec2::new(rest.dot(along_u), rest.dot(along_v));
        let (uu, uv_, vv) = (along_u.dot(along_u), along_u.dot(along_v), along_v.dot(along_v));
        // A parameter at its end stays there if the gradient points beyond it.
        let held_u = (uv.x <= 0.0 && gradient.x > 0.0) || (uv.x >= 1.0 && gradient.x < 0.0);
        let held_v = (uv.y <= 0.0 && gradient.y > 0.0) || (uv.y >= 1.0 && gradient.y < 0.0);
        let floor = damping * (uu + vv) + f64::MIN_POSITIVE;
        let step = match (held_u, held_v) {
            (true, true) => break,
            (true, false) => DVec2::new(0.0, gradient.y / (vv + floor)),
            (false, true) => DVec2::new(gradient.x / (uu + floor), 0.0),
            (false, false) => {
                DMat2::from_cols_array(&[uu + floor, uv_, uv_, vv + floor]).inverse() * gradient
            }
        };
        let next = (uv - step).clamp(DVec2::ZERO, DVec2::ONE);
        let square = at(next).length_squared();
        if square < best {
            (uv, best) = (next, square);
            damping = (damping * 0.1).max(1e-15);
        } else if damping > 1e3 || step.length() < 1e-17 {
            break;
        } else {
            damping *= 30.0;
        }
    }
    best.sqrt()
}

#[cfg(test)]
mod tests {
    use rotund_geometry::Ray;

    use super::*;
    use crate::truth::{Truth, tests::every_crossing_lies_on_the_surface};

    fn saddle() -> BilinearPatch {
        BilinearPatch {
            p00: Vec3::new(-1.0, -1.0, -0.5),
            p10: Vec3::new(1.0, -1.0, 0.5),
            p01: Vec3::new(-1.0, 1.0, 0.5),
            p11: Vec3::new(1.0, 1.0, -0.5),
        }
    }

    #[test]
    fn every_crossing_of_every_family_lies_on_the_patch() {
        every_crossing_lies_on_the_surface::<BilinearPatch>();
    }

    #[test]
    fn known_answers() {
        // The saddle is z = -x y / 2 over the square.
        let table = [
            // why                       origin              direction            t
            ("from above", [0.5, 0.5, 4.0], [0.0, 0.0, -1.0], vec![4.125]),
            ("from below", [0.5, -0.5, -4.0], [0.0, 0.0, 2.0], vec![2.0625]),
            ("the corner", [1.0, 1.0, 4.0], [0.0, 0.0, -1.0], vec![4.5]),
            ("beside the edge", [1.001, 0.0, 4.0], [0.0, 0.0, -1.0], vec![]),
            ("twice", [-1.0, -1.0, -0.125], [1.0, 1.0, 0.0], vec![0.5, 1.5]),
            ("between both", [0.0, 0.0, -0.125], [1.0, 1.0, 0.0], vec![-0.5, 0.5]),
            ("misses the fold", [-1.0, 1.0, -0.001], [1.0, -1.0, 0.0], vec![]),
        ];
        for (why, origin, direction, expected) in table {
            let truth = Truth::of(&saddle(), &Ray::new(origin.into(), direction.into()));
            let found: Vec<f64> = truth.crossings.iter().map(|c| c.t.to_f64()).collect();
            assert_eq!(found, expected, "{why}");
        }
    }

    #[test]
    fn the_distance_of_a_point_beside_the_patch_is_to_its_edge() {
        let flat = BilinearPatch {
            p00: Vec3::ZERO,
            p10: Vec3::X,
            p01: Vec3::Y,
            p11: Vec3::new(1.0, 1.0, 0.0),
        };
        let near = Crossing {
            t: Wide::ZERO,
            point: Wide3::default(),
            normal: DVec3::Z,
            uv: Some(DVec2::splat(0.5)),
            on_edge: false,
        };
        for (point, expected) in [
            (DVec3::new(0.5, 0.5, 2.0), 2.0),
            (DVec3::new(1.5, 0.5, 0.0), 0.5),
            (DVec3::new(4.0, 5.0, 0.0), 5.0),
        ] {
            let found = flat.distance(point.into(), &near);
            assert!((found - expected).abs() < 1e-12, "{point}: {found}");
        }
    }
}
