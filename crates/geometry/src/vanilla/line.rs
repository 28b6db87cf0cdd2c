//! The vanilla line: a ribbon that faces every ray.

use glam::{DVec3, Vec2, Vec3};

use crate::filter::{Filtered, Solve, queries};
use crate::float::{error, off_hull, round, rounding_error};
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Aabb, Hit, Ray, widen};

/// A segment that a ray hits at the closest approach of both, if their distance there is within the
/// radius.
///
/// The closest approach is that of two infinite lines. If its point on the line of the segment lies
/// beyond an end, it is replaced by that end while the point on the ray is kept, as in yocto-gl. So
/// a ribbon ends in a cap that is round seen from the side and shrinks as the ray turns towards the
/// axis, and a ray from one segment of a chain does not hit the cap of the next.
///
/// # Accuracy and degenerate inputs
///
/// `t` is computed in `f64` and rounded once. A ray parallel to the segment misses, and so does a
/// ray that starts on the segment within rounding, as one from [`Hit::spawn`] does. Two equal ends,
/// and a radius that is not positive at the closest approach, miss too: of a line with one negative
/// radius, the part with a positive radius remains.
///
/// ```
/// use rotund_geometry::glam::{Vec2, Vec3};
/// use rotund_geometry::{Ray, vanilla::Line};
///
/// let line = Line { p0: Vec3::ZERO, r0: 0.25, p1: 2.0 * Vec3::X, r1: 0.25 };
/// let ray = Ray::new(Vec3::new(0.5, 0.125, 3.0), Vec3::NEG_Z);
/// let hit = line.closest(&ray).expect("within 0.25");
/// assert_eq!((hit.t, hit.position, hit.normal), (3.0, 0.5 * Vec3::X, Vec3::Z));
/// assert_eq!(line.uv(&hit), Vec2::new(0.25, 0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Line {
    /// The first end.
    pub p0: Vec3,
    /// The radius at the first end.
    pub r0: f32,
    /// The second end.
    pub p1: Vec3,
    /// The radius at the second end.
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
    /// Returns the closest approach of the lines, if its `t` is in `t_min..=t_max` and its distance
    /// within the radius, which is interpolated along the segment.
    ///
    /// The position of the hit is the point on the segment. The normal faces the ray, perpendicular
    /// to the segment.
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
        // The closest points of two lines, clamped to the segment. A NaN stays a NaN.
        let s = (f.cross(d).dot(g) * over).clamp(0.0, 1.0);
        let turned = f.cross(e);
        let t = turned.dot(g) * over;
        // The vector from the point on the ray to the point on the segment.
        let x = f + s * e - t * d;
        let distance2 = x.dot(x);
        let r = r0 + s * (r1 - r0);
        // Written so that a NaN, and with it a zero determinant, fails.
        if !(distance2 <= r * r && r > 0.0 && determinant > 0.0) {
            return Filtered::Miss;
        }
        let Some(t) = ray.accept(t) else { return Filtered::Miss };
        // A ray that leaves the segment has its closest approach near its start: see `Point`.
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
        // Perpendicular to the segment, in the plane of both: e (e·d) - d (e·e).
        let normal = d.cross(axis).cross(axis);
        let square = normal.dot(normal);
        Hit {
            t,
            position,
            // The difference of the ends and its product with `s` have a rounding each, of at most
            // twice their coordinates.
            error: error(position, off_hull([self.p0, self.p1], 5.0)),
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

    /// Returns a box that contains the ribbon from every side: that of the rounded cone.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        crate::RoundedCone { p0: self.p0, r0: self.r0, p1: self.p1, r1: self.r1 }.bounds()
    }

    /// Returns the parameters of a hit: the fraction of the segment, and the distance of the ray
    /// from it over the radius there.
    #[must_use]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// Returns the point at the fraction `uv.x` of the segment.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.at(f64::from(uv.x)))
    }

    /// Returns the unit tangent, since a line has no normal of its own.
    ///
    /// A renderer derives from it a normal that faces the viewer, as yocto-gl does. The normal of a
    /// hit faces the ray.
    #[must_use]
    pub fn normal(&self, _uv: Vec2) -> Vec3 {
        round((self.p1.as_dvec3() - self.p0.as_dvec3()).normalize_or(DVec3::Z))
    }
}
