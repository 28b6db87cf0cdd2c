//! The vanilla point: a disc that faces every ray.

use glam::{Vec2, Vec3};

use crate::filter::{Filtered, Solve, queries};
use crate::float::{round, rounding_error};
use crate::{Aabb, Hit, Ray, widen};

/// A point that a ray hits at its closest approach, if that is within `radius`.
///
/// # Accuracy and degenerate inputs
///
/// `t` is computed in `f64` and rounded once. A ray that starts at the point within rounding, as
/// one from [`Hit::spawn`] does, misses, and so does every ray if the radius is not positive.
///
/// ```
/// use rotund_geometry::glam::Vec3;
/// use rotund_geometry::{Ray, vanilla::Point};
///
/// let point = Point { center: Vec3::ZERO, radius: 1.0 };
/// let hit = point.closest(&Ray::new(Vec3::new(0.5, 0.0, 3.0), Vec3::NEG_Z)).expect("within 1");
/// assert_eq!((hit.t, hit.position, hit.normal), (3.0, Vec3::ZERO, Vec3::Z));
/// assert!(!point.any(&Ray::new(Vec3::new(1.5, 0.0, 3.0), Vec3::NEG_Z)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Point {
    /// The point itself.
    pub center: Vec3,
    /// The largest distance at which a ray hits; positive.
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
    /// Returns the closest approach, if its `t` is in `t_min..=t_max` and it lies within `radius`.
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
        // A ray that leaves the point has its closest approach at its start, before or behind it by
        // rounding. It must not hit the point again.
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
    /// Returns a box that contains the disc from every side: that of the sphere.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        crate::Sphere { center: self.center, radius: self.radius }.bounds()
    }

    /// Returns zero, since a point has no parameters.
    #[must_use]
    pub fn uv(&self, _hit: &Hit) -> Vec2 {
        Vec2::ZERO
    }

    /// Returns the point itself.
    #[must_use]
    pub fn position(&self, _uv: Vec2) -> Vec3 {
        self.center
    }

    /// Returns `+z`, as yocto-gl does, since a point has no normal of its own. The normal of a hit
    /// faces the ray.
    #[must_use]
    pub fn normal(&self, _uv: Vec2) -> Vec3 {
        Vec3::Z
    }
}
