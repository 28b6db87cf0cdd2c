//! The bilinear patch.
//!
//! # Derivation
//!
//! Seen along the ray (`ray_space.rs`), the patch is a map of the unit square to the plane, and the
//! ray is the origin: we look for `(u, v)` with `(1 - v) P0(u) + v P1(u) = 0`, where `P0(u)` and `P1(u)`
//! run along the edges `v = 0` and `v = 1`. The origin lies on the line through `P0(u)` and `P1(u)` if
//!
//! ```text
//! P0(u) × P1(u) = c + b u + a u² = 0     c = p00 × p01,  a = (p10 - p00) × (p11 - p01),  a + b + c = p10 × p11
//! ```
//!
//! so `c` and `a + b + c` are the areas of the edges `u = 0` and `u = 1`.
//!
//! # Watertight edges
//!
//! No rounded root can decide whether it lies on this or that side of an edge so that the neighbour,
//! whose corners come in another order, decides the opposite. The outline does: the number of times it
//! winds around the ray has the parity of the number of roots in the square, which is 0, 1 or 2. Whether
//! an edge counts depends on its two vertices alone. Hence: odd means exactly one root, clamped to the
//! square; even means two or none.
//!
//! Sources: S. D. Ramsey, K. Potter, C. Hansen, "Ray Bilinear Patch Intersections", journal of graphics
//! tools 9(3), 2004, for the quadratic in the plane; A. Reshetov, "Cool Patches", Ray Tracing Gems,
//! chapter 8, 2019, for the choice of `a, b, c` and for the stable roots.

use glam::{DVec3, Vec2, Vec3};

use crate::float::{accept, round, rounding_error};
use crate::ray_space::{Image, RaySpace, crosses, edge};
use crate::{Aabb, Hit, Ray};

/// The surface of all points `(1-u)(1-v) p00 + u(1-v) p10 + (1-u)v p01 + uv p11`, `u, v` in `0..=1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BilinearPatch {
    /// The corner `u = 0, v = 0`.
    pub p00: Vec3,
    /// The corner `u = 1, v = 0`.
    pub p10: Vec3,
    /// The corner `u = 0, v = 1`.
    pub p01: Vec3,
    /// The corner `u = 1, v = 1`.
    pub p11: Vec3,
}

struct Root {
    t: f32,
    u: f64,
    v: f64,
}

impl BilinearPatch {
    /// The first crossing of the surface with `t` in `t_min..=t_max`.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let Root { t, u, v } = self.solve(ray)?;
        let position = round(self.at(u, v));
        Some(Hit {
            t,
            position,
            error: rounding_error(position),
            normal: round(self.normal_at(u, v)),
            parameters: Vec2::new(u as f32, v as f32),
        })
    }

    /// The `t` of [`Self::closest`], the same bits, at less cost.
    #[must_use]
    #[inline]
    pub fn closest_t(&self, ray: &Ray) -> Option<f32> {
        self.solve(ray).map(|root| root.t)
    }

    /// True if [`Self::closest`] finds a hit.
    #[must_use]
    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        self.solve(ray).is_some()
    }

    #[inline(always)]
    fn solve(&self, ray: &Ray) -> Option<Root> {
        let space = RaySpace::new(ray);
        let (p00, p10) = (space.project(self.p00), space.project(self.p10));
        let (p01, p11) = (space.project(self.p01), space.project(self.p11));
        // The patch lies in the hull of its corners. A NaN passes here and fails below.
        let (min_x, max_x) =
            (p00.x.min(p10.x).min(p01.x).min(p11.x), p00.x.max(p10.x).max(p01.x).max(p11.x));
        let (min_y, max_y) =
            (p00.y.min(p10.y).min(p01.y).min(p11.y), p00.y.max(p10.y).max(p01.y).max(p11.y));
        if min_x > 0.0 || max_x < 0.0 || min_y > 0.0 || max_y < 0.0 {
            return None;
        }
        let c = edge(p00, p01);
        let at_one = edge(p10, p11);
        let a = (p10.x - p00.x) * (p11.y - p01.y) - (p11.x - p01.x) * (p10.y - p00.y);
        let b = at_one - c - a;
        let odd = crosses(p00, p01, c)
            ^ crosses(p10, p11, at_one)
            ^ crosses(p00, p10, edge(p00, p10))
            ^ crosses(p01, p11, edge(p01, p11));
        if !odd {
            // Two roots or none: a parabola with both ends on the same side that comes back.
            let same_side = if c > 0.0 {
                at_one > 0.0 && a > 0.0 && b < 0.0 && -b < 2.0 * a
            } else {
                c < 0.0 && at_one < 0.0 && a < 0.0 && b > 0.0 && -b > 2.0 * a
            };
            if !same_side {
                return None;
            }
        }
        let discriminant = b * b - 4.0 * a * c;
        if !odd && discriminant < 0.0 {
            return None;
        }
        let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
        // Finite: a corner that is not would make all of these NaN or infinite.
        if !(a.is_finite() && q.is_finite()) {
            return None;
        }
        let finish = |u: f64| -> (f64, f64, f64) {
            let lerp = |a: Image, b: Image| Image {
                x: a.x + u * (b.x - a.x),
                y: a.y + u * (b.y - a.y),
                depth: a.depth + u * (b.depth - a.depth),
            };
            let (p0, p1) = (lerp(p00, p10), lerp(p01, p11));
            let (x, y) = (p1.x - p0.x, p1.y - p0.y);
            let square = x * x + y * y;
            // A ruling seen end-on is a point of the image: take its middle.
            let v = if square > 0.0 { -(p0.x * x + p0.y * y) / square } else { 0.5 };
            (u, v, p0.depth + v.clamp(0.0, 1.0) * (p1.depth - p0.depth))
        };
        let (u0, u1) = (q / a, if q != 0.0 { c / q } else { 0.0 });
        if odd {
            let outside = |x: f64| (x - 0.5).abs();
            let candidate = |u: f64| {
                let (_, v, _) = finish(u.clamp(0.0, 1.0));
                outside(u).max(outside(v))
            };
            let u = if a == 0.0 || candidate(u1) <= candidate(u0) { u1 } else { u0 };
            let (u, v, depth) = finish(u.clamp(0.0, 1.0));
            let t = accept(ray, space.t(depth))?;
            return Some(Root { t, u, v: v.clamp(0.0, 1.0) });
        }
        let roots = [finish(u0), finish(u1)];
        if roots.iter().any(|&(_, v, _)| !(0.0..=1.0).contains(&v)) {
            return None;
        }
        let hit =
            |(u, v, depth): (f64, f64, f64)| accept(ray, space.t(depth)).map(|t| Root { t, u, v });
        let [first, second] = roots.map(hit);
        match (first, second) {
            (Some(first), Some(second)) => Some(if second.t < first.t { second } else { first }),
            (first, second) => first.or(second),
        }
    }

    #[inline]
    fn at(&self, u: f64, v: f64) -> DVec3 {
        let (p00, p10) = (self.p00.as_dvec3(), self.p10.as_dvec3());
        let (p01, p11) = (self.p01.as_dvec3(), self.p11.as_dvec3());
        (1.0 - v) * ((1.0 - u) * p00 + u * p10) + v * ((1.0 - u) * p01 + u * p11)
    }

    #[inline]
    fn partials(&self, u: f64, v: f64) -> (DVec3, DVec3) {
        let (p00, p10) = (self.p00.as_dvec3(), self.p10.as_dvec3());
        let (p01, p11) = (self.p01.as_dvec3(), self.p11.as_dvec3());
        ((1.0 - v) * (p10 - p00) + v * (p11 - p01), (1.0 - u) * (p01 - p00) + u * (p11 - p10))
    }

    #[inline]
    fn normal_at(&self, u: f64, v: f64) -> DVec3 {
        let (du, dv) = self.partials(u, v);
        let n = du.cross(dv);
        let square = n.dot(n);
        if square > 0.0 && square.is_finite() {
            return n / square.sqrt();
        }
        self.normal_of_collapsed(u, v)
    }

    /// Where an edge is a point the partials do not span a plane, but their limit does.
    #[cold]
    fn normal_of_collapsed(&self, u: f64, v: f64) -> DVec3 {
        let inwards = |x: f64| x + (0.5 - x) * f64::from(f32::EPSILON);
        let (du, dv) = self.partials(inwards(u), inwards(v));
        du.cross(dv).try_normalize().unwrap_or_else(|| {
            let along = if du.length_squared() > dv.length_squared() { du } else { dv };
            along.try_normalize().map_or(DVec3::Z, DVec3::any_orthonormal_vector)
        })
    }

    /// A box that holds the patch, and every position that [`Self::closest`] reports.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points([self.p00, self.p10, self.p01, self.p11]).grown_by_rounding()
    }

    /// The parameters of a hit, `(u, v)`.
    #[must_use]
    #[inline]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// The point with parameters `(u, v)`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.at(f64::from(uv.x), f64::from(uv.y)))
    }

    /// The unit normal at [`Self::position`]: the direction of `du × dv`.
    #[must_use]
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        round(self.normal_at(f64::from(uv.x), f64::from(uv.y)))
    }

    /// The derivatives of [`Self::position`] by `u` and by `v`.
    #[must_use]
    pub fn tangents(&self, uv: Vec2) -> (Vec3, Vec3) {
        let (du, dv) = self.partials(f64::from(uv.x), f64::from(uv.y));
        (round(du), round(dv))
    }
}
