//! A line as a ribbon that faces every ray.

use glam::{DVec3, Vec2, Vec3};

use crate::filter::{Filtered, Solve, queries};
use crate::float::{round, rounding_error};
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Aabb, Hit, Ray, widen};

/// A segment that a ray hits where the two come closest, if that is within the radius there.
///
/// "Closest" is between two whole lines. Where that point of the segment's line is beyond an end, the end
/// takes its place but the point of the ray stays, as in yocto-gl. A ribbon so ends in a cap that is
/// round seen from the side and shrinks as the ray turns along the axis, and a ray from one segment of a
/// chain does not meet the cap of the next.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// The segment from the origin to `(0, 1, 0)` with radius 1, as the default
/// [`RoundedCone`](crate::RoundedCone).
impl Default for Line {
    fn default() -> Self {
        Self { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::Y, r1: 1.0 }
    }
}

pub(crate) struct Root {
    t: f32,
    s: f64,
    distance2: f64,
    r: f64,
}

queries!(
    Line,
    /// Where the ray's line comes closest to the segment's line, if that has `t` in `t_min..=t_max` and
    /// the segment lies within the radius, interpolated along it.
    ///
    /// `parameters` is `(s, d / r)`: the place on the segment, and the distance over the radius there.
    /// The position of the hit is the point of the segment; the normal faces the ray, across the segment.
    /// A ray parallel to the segment misses.
);

impl Solve for Line {
    type Root = Root;

    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<Root> {
        let ((p0, r0), (p1, r1)) = (widen::ball(self.p0, self.r0), widen::ball(self.p1, self.r1));
        let (o, d) = widen::ray(ray);
        let (e, f) = (p1 - p0, p0 - o);
        let g = d.cross(e);
        let determinant = g.dot(g);
        let over = determinant.recip();
        // Closest points of two lines; then the segment ends. A NaN stays one.
        let s = (f.cross(d).dot(g) * over).clamp(0.0, 1.0);
        let turned = f.cross(e);
        let t = turned.dot(g) * over;
        // From the point of the ray to the point of the segment.
        let x = f + s * e - t * d;
        let distance2 = x.dot(x);
        let r = r0 + s * (r1 - r0);
        // Written so that a NaN, and with it a zero determinant, fails.
        if !(distance2 <= r * r && r > 0.0 && determinant > 0.0) {
            return Filtered::Miss;
        }
        let Some(t) = ray.accept(t) else { return Filtered::Miss };
        // A ray that has just left the segment comes closest near its start: see `Point`.
        let start = 4.0 * f64::from(rounding_error(self.p0.abs().max(self.p1.abs())));
        let (along, length2) = (-f.dot(e), e.dot(e));
        let from_start = if along <= 0.0 {
            f.dot(f)
        } else if along >= length2 {
            (f + e).dot(f + e)
        } else {
            turned.dot(turned) / length2
        };
        if from_start <= start * start {
            return Filtered::Miss;
        }
        Filtered::Hit(Root { t, s, distance2, r })
    }

    #[inline(always)]
    fn t(root: &Root) -> f32 {
        root.t
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray, Root { t, s, distance2, r }: Root) -> Hit {
        let (p0, p1) = widen::points(self.p0, self.p1);
        let (_, d) = widen::ray(ray);
        let axis = p1 - p0;
        let position = round(p0 + s * axis);
        // Across the segment, in the plane of both: e (e·d) - d (e·e).
        let normal = d.cross(axis).cross(axis);
        let square = normal.dot(normal);
        Hit {
            t,
            position,
            error: rounding_error(position),
            normal: round(normal * square.sqrt().recip()),
            parameters: Vec2::new(s as f32, (distance2.sqrt() / r) as f32),
        }
    }
}

impl Line {
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
