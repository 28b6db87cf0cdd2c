//! Rays and their hits.

use glam::{Vec2, Vec3};

use crate::float::{UNIT_ROUNDOFF, leave_surface, rounding_error};

/// The points `origin + t * direction` with `t` in `t_min..=t_max`.
///
/// `t` counts in units of the direction, which need not have unit length. Results are right for
/// lengths of about `1e-30..=1e30`: beyond, `t` of a hit at an ordinary distance, or the square of
/// the direction, can be outside of the range of `f32`, and such a hit may be missed. A ray whose
/// direction is zero, or whose interval is empty or has a NaN end, misses everything.
///
/// ```
/// use rotund_geometry::{Ray, glam::Vec3};
///
/// let ray = Ray::new(Vec3::ZERO, Vec3::X);
/// assert_eq!((ray.t_min, ray.t_max), (0.0, f32::INFINITY));
/// let segment = Ray { t_max: 2.5, ..ray };
/// assert_eq!(segment.at(segment.t_max), Vec3::new(2.5, 0.0, 0.0));
/// ```
///
/// With the feature `serde`, `t_min` and `t_max` may be omitted: they are then 0 and infinity, as
/// in [`Ray::new`]. A field with another name is an error. A `t_max` of infinity is written as
/// none, in JSON `null`; a `t_max` that is NaN or minus infinity cannot be written.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Ray {
    /// The point at `t = 0`.
    pub origin: Vec3,
    /// The step of `t = 1`; not necessarily of unit length.
    pub direction: Vec3,
    /// The smallest `t` that counts as a hit.
    #[cfg_attr(feature = "serde", serde(default))]
    pub t_min: f32,
    /// The largest `t` that counts as a hit.
    #[cfg_attr(feature = "serde", serde(default = "unbounded::none", with = "unbounded"))]
    pub t_max: f32,
}

/// The ray from the origin along `-z`, the view direction of a camera, on to infinity.
impl Default for Ray {
    fn default() -> Self {
        Self::new(Vec3::ZERO, Vec3::NEG_Z)
    }
}

impl Ray {
    /// Returns the ray from `origin` on to infinity, `t` in `0.0..=f32::INFINITY`.
    #[must_use]
    pub const fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// Returns the point at `t`, rounded at each step; the position of a [`Hit`] is more accurate.
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }

    /// Rounds `t` to `f32`; returns `None` if the result is not finite or not in `t_min..=t_max`.
    ///
    /// All primitives decide by this test whether a root counts. It tests the rounded value, which
    /// is the one that callers see: a hit is always within its interval, and is found again if it
    /// becomes an end of the interval. A NaN, in `t` or at an end of the interval, gives `None`.
    ///
    /// The result may be `-0.0`. To find the closest of several hits, compare by `<` or
    /// `partial_cmp`, for which both zeros are equal, as the trees of `rotund-bvh` do, and not by
    /// `total_cmp`.
    #[must_use]
    #[inline]
    pub fn accept(&self, t: f64) -> Option<f32> {
        let t = t as f32;
        // In this form, unlike `max` and `min`, a NaN end of the interval survives and rejects.
        let first = if f32::MIN > self.t_min { f32::MIN } else { self.t_min };
        let last = if f32::MAX < self.t_max { f32::MAX } else { self.t_max };
        (t >= first && t <= last).then_some(t)
    }
}

/// The point at which a ray hits a primitive.
///
/// The ray enters a solid, or comes from the front of a surface, if `normal.dot(ray.direction)` is
/// negative, and leaves it otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hit {
    /// Position along the ray, in units of `Ray::direction`, which need not have unit length.
    pub t: f32,
    /// The point, more accurate than `ray.at(t)`.
    pub position: Vec3,
    /// Bound on the distance from `position` to the exact surface. [`Hit::spawn`] steps off by it.
    pub error: f32,
    /// Geometric normal: unit length, out of the solid, whichever side the ray came from. A patch,
    /// a triangle or a quad points where its parameters turn counter-clockwise.
    pub normal: Vec3,
    /// Intermediate values of the intersection, from which `uv` of the same primitive computes the
    /// surface parameters. Their meaning depends on the primitive.
    pub parameters: Vec2,
}

impl Hit {
    /// Returns the ray from this point in `direction`, of any length, which rounding alone cannot
    /// make hit the same surface again.
    ///
    /// The origin is [`leave_surface`] of this hit, on the side that `direction` points to: outside
    /// for a reflection, inside for a refraction. The interval is `0.0..=f32::INFINITY`.
    ///
    /// ```
    /// use rotund_geometry::{Ray, Sphere, glam::Vec3};
    ///
    /// let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
    /// let ray = Ray::new(Vec3::new(0.6, 0.0, 5.0), Vec3::NEG_Z);
    /// let hit = ball.closest(&ray).expect("the ray passes 0.6 from the center");
    ///
    /// let reflected = hit.spawn(ray.direction.reflect(hit.normal));
    /// assert!(!ball.any(&reflected));
    /// let exit = ball.closest(&hit.spawn(ray.direction)).expect("the far side");
    /// assert!((exit.t - 1.6).abs() < 1e-6);
    /// ```
    #[must_use]
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        Ray::new(leave_surface(self.position, self.error, self.normal, direction), direction)
    }

    /// Returns the ray from this point towards `point`, for visibility tests: `any` is true if a
    /// primitive lies in between. `t = 1` is `point`.
    ///
    /// It starts as [`Hit::spawn`] does. It ends before `point`, so that a surface on which `point`
    /// lies does not count: at `t_max = 1 - max(32 u, 16 e / l)`, where `u` is [`UNIT_ROUNDOFF`],
    /// `e` the [`rounding_error`] of `point`, and `l` the longest component of the direction. This
    /// is `1 - 32 u = 1 - 2⁻¹⁹` unless the coordinates of `point` are larger than the distance.
    ///
    /// It suffices if
    ///
    /// - `point` lies within `e` of the surface, as the position of a hit and a point that was
    ///   computed in `f64` and rounded once do;
    /// - the cosine between the ray and the normal of the surface is at least 0.1 in absolute
    ///   value;
    /// - the radius of curvature of the surface is large compared with `e / 0.1²`.
    ///
    /// A distance below `16 e` cannot be resolved: the interval is empty, and nothing lies between.
    /// For grazing rays between two hits, step off both surfaces:
    ///
    /// ```
    /// use rotund_geometry::{Ray, Sphere, glam::Vec3};
    ///
    /// let balls = [-2.0, 2.0].map(|x| Sphere { center: Vec3::new(x, 0.0, 0.0), radius: 1.0 });
    /// let down = |x: f32| Ray::new(Vec3::new(x, 0.0, 5.0), Vec3::NEG_Z);
    /// let a = balls[0].closest(&down(-1.5)).expect("above the first ball");
    /// let b = balls[1].closest(&down(1.5)).expect("above the second ball");
    ///
    /// let end = b.spawn(a.position - b.position).origin;
    /// let segment = a.spawn_to(end);
    /// assert!(!balls.iter().any(|ball| ball.any(&segment)), "they see each other");
    /// ```
    #[must_use]
    #[inline]
    pub fn spawn_to(&self, point: Vec3) -> Ray {
        let origin = leave_surface(self.position, self.error, self.normal, point - self.position);
        let direction = point - origin;
        // The surface lies within `e` of the point, and the point within `u` times the length of
        // the end of the ray, whose direction is rounded. Along the ray the cosine divides both,
        // and `t` is rounded by another `u`. For a cosine of 0.1 this is `10 (e / l + u) + u`,
        // which is less than the larger of `32 u` and `16 e / l`; the rest is for the curvature.
        // The longest component bounds the length from below and neither overflows nor underflows.
        let share = rounding_error(point) / direction.abs().max_element();
        let margin = (16.0 * share).max(32.0 * UNIT_ROUNDOFF);
        Ray { t_max: 1.0 - margin, ..Ray::new(origin, direction) }
    }
}

/// Serializes `t_max` as an option that is none, in JSON `null`, for infinity.
#[cfg(feature = "serde")]
mod unbounded {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, ser};

    pub(super) fn none() -> f32 {
        f32::INFINITY
    }

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    pub(super) fn serialize<S: Serializer>(t_max: &f32, serializer: S) -> Result<S::Ok, S::Error> {
        if t_max.is_nan() || *t_max == f32::NEG_INFINITY {
            // JSON writes it as `null`, which would come back as infinity.
            return Err(ser::Error::custom(format_args!("t_max is {t_max}")));
        }
        (*t_max != f32::INFINITY).then_some(*t_max).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f32, D::Error> {
        Ok(Option::deserialize(from)?.unwrap_or(f32::INFINITY))
    }
}
