//! The triangle.

use glam::{DVec3, Vec2, Vec3};

use crate::float::{accept, round, rounding_error};
use crate::ray_space::{RaySpace, crosses, edge};
use crate::{Aabb, Hit, Ray};

/// The flat triangle of three points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corner `u = 0, v = 0`.
    pub p0: Vec3,
    /// The corner `u = 1, v = 0`.
    pub p1: Vec3,
    /// The corner `u = 0, v = 1`.
    pub p2: Vec3,
}

struct Root {
    t: f32,
    u: f64,
    v: f64,
}

impl Triangle {
    /// The crossing of the triangle with `t` in `t_min..=t_max`.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let Root { t, u, v } = self.solve(ray)?;
        let position = round(self.at(u, v));
        Some(Hit {
            t,
            position,
            error: rounding_error(position),
            normal: round(self.unit_normal()),
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
        let (p0, p1) = space.project(self.p0, self.p1);
        let (p2, _) = space.project(self.p2, self.p2);
        // The weight of each corner is the area that the ray spans with the opposite edge.
        let (w0, w1, w2) = (edge(p1, p2), edge(p2, p0), edge(p0, p1));
        if !(crosses(p1, p2, w0) ^ crosses(p2, p0, w1) ^ crosses(p0, p1, w2)) {
            return None;
        }
        let sum = w0 + w1 + w2;
        if !(sum != 0.0 && sum.is_finite()) {
            return None;
        }
        let (u, v) = (w1 / sum, w2 / sum);
        let depth = (w0 * p0.depth + w1 * p1.depth + w2 * p2.depth) / sum;
        let t = accept(ray, space.t(depth))?;
        Some(Root { t, u: u.clamp(0.0, 1.0), v: v.clamp(0.0, 1.0) })
    }

    #[inline]
    fn at(&self, u: f64, v: f64) -> DVec3 {
        let (p0, p1, p2) = (self.p0.as_dvec3(), self.p1.as_dvec3(), self.p2.as_dvec3());
        // The rounded u + v may exceed 1; the point must not leave the triangle's box.
        (1.0 - u - v).max(0.0) * p0 + u * p1 + v * p2
    }

    #[inline]
    fn unit_normal(&self) -> DVec3 {
        let p0 = self.p0.as_dvec3();
        (self.p1.as_dvec3() - p0).cross(self.p2.as_dvec3() - p0).normalize_or(DVec3::Z)
    }

    /// A box that holds the triangle, and every position that [`Self::closest`] reports.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points([self.p0, self.p1, self.p2]).grown_by_rounding()
    }

    /// The parameters of a hit: the weights of `p1` and `p2`.
    #[must_use]
    #[inline]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// The point `(1 - u - v) p0 + u p1 + v p2`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.at(f64::from(uv.x), f64::from(uv.y)))
    }

    /// The unit normal, the same everywhere: the direction of `(p1 - p0) × (p2 - p0)`.
    #[must_use]
    pub fn normal(&self, _uv: Vec2) -> Vec3 {
        round(self.unit_normal())
    }

    /// The derivatives of [`Self::position`] by `u` and by `v`: the edges at `p0`.
    #[must_use]
    pub fn tangents(&self, _uv: Vec2) -> (Vec3, Vec3) {
        (self.p1 - self.p0, self.p2 - self.p0)
    }
}
