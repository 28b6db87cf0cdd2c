//! A point as a disc that faces every ray.

use glam::{Vec2, Vec3};

use crate::float::{accept, round, rounding_error};
use crate::{Aabb, Hit, Ray};

/// A point that a ray hits where it comes closest, if that is within `radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The point.
    pub center: Vec3,
    /// How near a ray must pass; positive.
    pub radius: f32,
}

impl Point {
    /// The closest approach, if it has `t` in `t_min..=t_max` and lies within `radius` of the point.
    ///
    /// The position of the hit is the point itself, and the normal faces the ray.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let t = self.closest_t(ray)?;
        Some(Hit {
            t,
            position: self.center,
            error: rounding_error(self.center),
            normal: round(-ray.direction.as_dvec3().normalize()),
            parameters: Vec2::ZERO,
        })
    }

    /// The `t` of [`Self::closest`], the same bits, at less cost.
    #[must_use]
    #[inline]
    pub fn closest_t(&self, ray: &Ray) -> Option<f32> {
        let f = self.center.as_dvec3() - ray.origin.as_dvec3();
        let d = ray.direction.as_dvec3();
        let r = f64::from(self.radius);
        let a = d.dot(d);
        let w = f.cross(d);
        // Written so that a NaN fails.
        if !(w.dot(w) <= a * r * r && r > 0.0) {
            return None;
        }
        let t = accept(ray, f.dot(d) / a)?;
        // A ray that has just left the point comes closest where it starts: rounding decides on which
        // side. It must not hit the point again.
        let start = 4.0 * f64::from(rounding_error(self.center));
        (f.dot(f) > start * start).then_some(t)
    }

    /// True if [`Self::closest`] finds a hit.
    #[must_use]
    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        self.closest_t(ray).is_some()
    }

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
