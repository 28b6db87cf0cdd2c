//! A quad as two triangles.

use glam::{Vec2, Vec3};

use crate::{Aabb, Hit, Ray, Triangle};

/// The triangles `p0 p1 p3` and `p2 p3 p1`, which share the diagonal `p1 p3`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// The corner `u = 0, v = 0`.
    pub p0: Vec3,
    /// The corner `u = 1, v = 0`.
    pub p1: Vec3,
    /// The corner `u = 1, v = 1`.
    pub p2: Vec3,
    /// The corner `u = 0, v = 1`.
    pub p3: Vec3,
}

impl Quad {
    fn first(&self) -> Triangle {
        Triangle { p0: self.p0, p1: self.p1, p2: self.p3 }
    }

    fn second(&self) -> Triangle {
        Triangle { p0: self.p2, p1: self.p3, p2: self.p1 }
    }

    /// The triangles would each ignore a corner of the other.
    #[inline]
    fn is_finite(&self) -> bool {
        // An infinity times zero is a NaN, and so is all that it is added to.
        let sum = (self.p0 + self.p1 * 0.0) * 0.0 + (self.p2 * 0.0 + self.p3 * 0.0);
        sum == Vec3::ZERO
    }

    /// The first crossing with `t` in `t_min..=t_max`.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        if !self.is_finite() {
            return None;
        }
        let first = self.first().closest(ray);
        let second = self.second().closest(ray).map(|mut hit| {
            hit.parameters = Vec2::ONE - hit.parameters;
            hit
        });
        match (first, second) {
            (Some(first), Some(second)) => Some(if second.t < first.t { second } else { first }),
            (first, second) => first.or(second),
        }
    }

    /// The `t` of [`Self::closest`], the same bits, at less cost.
    #[must_use]
    #[inline]
    pub fn closest_t(&self, ray: &Ray) -> Option<f32> {
        if !self.is_finite() {
            return None;
        }
        match (self.first().closest_t(ray), self.second().closest_t(ray)) {
            (Some(first), Some(second)) => Some(first.min(second)),
            (first, second) => first.or(second),
        }
    }

    /// True if [`Self::closest`] finds a hit.
    #[must_use]
    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        self.is_finite() && (self.first().any(ray) || self.second().any(ray))
    }

    /// A box that holds both triangles, and every position that [`Self::closest`] reports.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.first().bounds().union(self.second().bounds())
    }

    /// The parameters of a hit, those of the quad: the second triangle has `u + v > 1`.
    #[must_use]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// The point with parameters `(u, v)`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        if uv.x + uv.y <= 1.0 {
            self.first().position(uv)
        } else {
            self.second().position(Vec2::ONE - uv)
        }
    }

    /// The unit normal of the triangle that holds `(u, v)`.
    #[must_use]
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        if uv.x + uv.y <= 1.0 { self.first().normal(uv) } else { self.second().normal(uv) }
    }
}
