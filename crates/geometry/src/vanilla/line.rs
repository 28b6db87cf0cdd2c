//! A line as a ribbon that faces every ray.

use glam::{DVec3, Vec2, Vec3};

use crate::float::{accept, round, rounding_error};
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Aabb, Hit, Ray};

/// A segment that a ray hits where the two come closest, if that is within the radius there.
///
/// "Closest" is between two whole lines. Where that point of the segment's line is beyond an end, the end
/// takes its place but the point of the ray stays, as in yocto-gl. A ribbon so ends in a cap that is
/// round seen from the side and shrinks as the ray turns along the axis, and a ray from one segment of a
/// chain does not meet the cap of the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The first end.
    pub p0: Vec3,
    /// How near a ray must pass at the first end.
    pub r0: f32,
    /// The second end.
    pub p1: Vec3,
    /// How near a ray must pass at the second end.
    pub r1: f32,
}

struct Root {
    t: f32,
    s: f64,
    /// Distance over radius.
    across: f64,
}

impl Line {
    /// Where the ray's line comes closest to the segment's line, if that has `t` in `t_min..=t_max` and
    /// the segment lies within the radius, interpolated along it.
    ///
    /// `parameters` is `(s, d / r)`: the place on the segment, and the distance over the radius there.
    /// The position of the hit is the point of the segment; the normal faces the ray, across the segment.
    /// A ray parallel to the segment misses.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let Root { t, s, across } = self.solve(ray)?;
        let position = round(self.at(s));
        let axis = self.p1.as_dvec3() - self.p0.as_dvec3();
        let d = ray.direction.as_dvec3();
        let normal = axis * (axis.dot(d) / axis.dot(axis)) - d;
        Some(Hit {
            t,
            position,
            error: rounding_error(position),
            normal: round(normal.normalize_or(-d.normalize())),
            parameters: Vec2::new(s as f32, across as f32),
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
        let e = self.p1.as_dvec3() - self.p0.as_dvec3();
        let d = ray.direction.as_dvec3();
        let f = self.p0.as_dvec3() - ray.origin.as_dvec3();
        let g = d.cross(e);
        let determinant = g.dot(g);
        // Closest points of two lines; then the segment ends.
        let s = (f.cross(d).dot(g) / determinant).clamp(0.0, 1.0);
        let t = f.cross(e).dot(g) / determinant;
        // From the point of the ray to the point of the segment.
        let x = f + s * e - t * d;
        let distance2 = x.dot(x);
        let r = f64::from(self.r0) + s * (f64::from(self.r1) - f64::from(self.r0));
        // Written so that a NaN, and with it a zero determinant, fails.
        if !(distance2 <= r * r && r > 0.0 && determinant > 0.0) {
            return None;
        }
        let t = accept(ray, t)?;
        // A ray that has just left the segment comes closest near its start: see `Point`.
        let start = 4.0 * f64::from(rounding_error(self.p0.abs().max(self.p1.abs())));
        let nearest = f + e * (-f.dot(e) / e.dot(e)).clamp(0.0, 1.0);
        (nearest.dot(nearest) > start * start).then(|| Root { t, s, across: distance2.sqrt() / r })
    }

    #[inline]
    fn at(&self, s: f64) -> DVec3 {
        let p0 = self.p0.as_dvec3();
        p0 + s * (self.p1.as_dvec3() - p0)
    }

    /// A box that holds every closest approach that counts.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        crate::RoundedCone { p0: self.p0, r0: self.r0, p1: self.p1, r1: self.r1 }.bounds()
    }

    /// The parameters of a hit: `(s, d / r)`.
    #[must_use]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// The point of the segment at `uv.x`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.at(f64::from(uv.x)))
    }

    /// A line has no normal of its own: this is its unit tangent, from which a renderer makes one that
    /// faces the viewer, as yocto-gl does. That of a hit faces the ray.
    #[must_use]
    pub fn normal(&self, _uv: Vec2) -> Vec3 {
        round((self.p1.as_dvec3() - self.p0.as_dvec3()).normalize_or(DVec3::Z))
    }
}
