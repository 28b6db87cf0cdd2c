//! A point as a disc that faces every ray.

use glam::{Vec2, Vec3};

use crate::filter::{Filtered, Solve, queries};
use crate::float::{round, rounding_error};
use crate::{Aabb, Hit, Ray, widen};

/// A point that a ray hits where it comes closest, if that is within `radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Point {
    /// The point.
    pub center: Vec3,
    /// How near a ray must pass; positive.
    pub radius: f32,
}

/// The origin with radius 1, as the default [`Sphere`](crate::Sphere).
impl Default for Point {
    fn default() -> Self {
        Self { center: Vec3::ZERO, radius: 1.0 }
    }
}

queries!(
    Point,
    /// The closest approach, if it has `t` in `t_min..=t_max` and lies within `radius` of the point.
    ///
    /// The position of the hit is the point itself, and the normal faces the ray.
);

impl Solve for Point {
    type Root = f32;

    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<f32> {
        let (c, r) = widen::ball(self.center, self.radius);
        let (o, d) = widen::ray(ray);
        let f = c - o;
        let a = d.dot(d);
        let w = f.cross(d);
        // Written so that a NaN fails.
        if !(w.dot(w) <= a * r * r && r > 0.0) {
            return Filtered::Miss;
        }
        // A ray that has just left the point comes closest where it starts: rounding decides on which
        // side. It must not hit the point again.
        let start = 4.0 * f64::from(rounding_error(self.center));
        if f.dot(f) <= start * start {
            return Filtered::Miss;
        }
        ray.accept(f.dot(d) / a).into()
    }

    #[inline(always)]
    fn t(t: &f32) -> f32 {
        *t
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray, t: f32) -> Hit {
        let (_, d) = widen::ray(ray);
        Hit {
            t,
            position: self.center,
            error: rounding_error(self.center),
            normal: round(-d.normalize()),
            parameters: Vec2::ZERO,
        }
    }
}

impl Point {
    /// A box that holds every closest approach that counts.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        crate::Sphere { center: self.center, radius: self.radius }.bounds()
    }

    /// The parameters of a hit: a point has none.
    #[must_use]
    pub fn uv(&self, _hit: &Hit) -> Vec2 {
        Vec2::ZERO
    }

    /// The point itself.
    #[must_use]
    pub fn position(&self, _uv: Vec2) -> Vec3 {
        self.center
    }

    /// A point has no normal of its own: this is `+z`, as in yocto-gl. That of a hit faces the ray.
    #[must_use]
    pub fn normal(&self, _uv: Vec2) -> Vec3 {
        Vec3::Z
    }
}
