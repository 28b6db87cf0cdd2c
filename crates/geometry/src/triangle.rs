//! The triangle.

use glam::{DVec3, Vec2, Vec3};

use crate::f64x2::{F64x2, Mask};
use crate::filter::{Filtered, Solve, queries};
use crate::float::{error, off_hull, round};
use crate::ray_space::{Images, RaySpace};
use crate::{Aabb, Hit, Ray};

/// The flat triangle with the corners `p0`, `p1` and `p2`.
///
/// # Accuracy
///
/// The position is within `1.0 u max(|p|, size)` of the surface, `u = 2⁻²⁴`. `t` and the normal are
/// computed in `f64`, without an exact evaluation behind it, and rounded once: they have the error
/// of that rounding unless the ray is nearly edge-on or the triangle a sliver. A ray at an edge or
/// a corner that several triangles share hits exactly one of them.
///
/// # Degenerate inputs
///
/// A triangle without area misses, and so does one that is seen edge-on or has a corner that is not
/// finite.
///
/// ```
/// use rotund_geometry::glam::{Vec2, Vec3};
/// use rotund_geometry::{Ray, Triangle};
///
/// let triangle = Triangle { p0: Vec3::ZERO, p1: 2.0 * Vec3::X, p2: 2.0 * Vec3::Y };
/// let ray = Ray::new(Vec3::new(0.5, 0.5, 3.0), Vec3::NEG_Z);
/// let hit = triangle.closest(&ray).expect("the ray aims at the inside");
/// assert_eq!((hit.t, hit.normal), (3.0, Vec3::Z));
/// assert_eq!(triangle.uv(&hit), Vec2::splat(0.25));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Triangle {
    /// The corner `u = 0, v = 0`.
    pub p0: Vec3,
    /// The corner `u = 1, v = 0`.
    pub p1: Vec3,
    /// The corner `u = 0, v = 1`.
    pub p2: Vec3,
}

/// Half of the unit square in the plane `z = 0`: the point with parameters `(u, v)` is `(u, v, 0)`.
impl Default for Triangle {
    fn default() -> Self {
        Self { p0: Vec3::ZERO, p1: Vec3::X, p2: Vec3::Y }
    }
}

pub(crate) struct Root {
    t: f32,
    u: f64,
    v: f64,
}

/// The crossings of a ray with two triangles.
pub(crate) struct Crossings {
    /// The triangles that the line of the ray crosses; the other fields are valid for these.
    pub(crate) exist: Mask,
    pub(crate) depth: F64x2,
    /// The weight of the second corner.
    pub(crate) u: F64x2,
    /// The weight of the third corner.
    pub(crate) v: F64x2,
}

impl Crossings {
    /// Computes the crossings from the images of the corners, in the order of each triangle.
    #[inline(always)]
    pub(crate) fn of(p0: &Images, p1: &Images, p2: &Images) -> Self {
        // In ray space the weight of a corner is the signed area of the origin and the opposite
        // edge.
        let (w0, w1, w2) = (p1.areas(p2), p2.areas(p0), p0.areas(p1));
        let odd = p1.crosses(p2, w0).differs(p2.crosses(p0, w1)).differs(p0.crosses(p1, w2));
        let (zero, one) = (F64x2::splat(0.0), F64x2::splat(1.0));
        let sum = w0 + w1 + w2;
        let exist = odd.and(zero.less(sum.abs())).and(sum.abs().less(F64x2::splat(f64::INFINITY)));
        let over = one / sum;
        let depth = (w0 * p0.depth + w1 * p1.depth + w2 * p2.depth) * over;
        let share = |w: F64x2| (w * over).max(zero).min(one);
        Self { exist, depth, u: share(w1), v: share(w2) }
    }
}

queries!(
    Triangle,
    /// Returns the crossing of the triangle with `t` in `t_min..=t_max`, from either side.
);

impl Solve for Triangle {
    type Root = Root;

    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<Root> {
        let space = RaySpace::new(ray);
        // No closure here: it would be compiled without the target features of the tree's kernel
        // that inlines this function, and therefore stay a call.
        let p0 = space.project(&self.p0, &self.p0);
        let p1 = space.project(&self.p1, &self.p1);
        let p2 = space.project(&self.p2, &self.p2);
        let found = Crossings::of(&p0, &p1, &p2);
        if !found.exist.any() {
            return Filtered::Miss;
        }
        let (u, v) = (found.u.first(), found.v.first());
        ray.accept(space.t(found.depth.first())).map(|t| Root { t, u, v }).into()
    }

    #[inline(always)]
    fn t(root: &Root) -> f32 {
        root.t
    }

    #[inline(always)]
    fn hit(&self, _: &Ray, Root { t, u, v }: Root) -> Hit {
        let position = round(self.at(u, v));
        Hit {
            t,
            position,
            error: error(position, self.off()),
            normal: round(self.unit_normal()),
            parameters: Vec2::new(u as f32, v as f32),
        }
    }
}

impl Triangle {
    #[inline]
    pub(crate) fn at(&self, u: f64, v: f64) -> DVec3 {
        let (p0, p1, p2) = (self.p0.as_dvec3(), self.p1.as_dvec3(), self.p2.as_dvec3());
        // The rounded u + v may exceed 1; the point must not leave the box of the triangle.
        (1.0 - u - v).max(0.0) * p0 + u * p1 + v * p2
    }

    /// Returns a bound on the distance of [`Self::at`] from the plane of the triangle.
    ///
    /// The products have a rounding of their own and one of the first sum, of at most the largest
    /// coordinates `A` of the corners. The second sum, and weights whose sum is not 1 by two
    /// roundings, move the point by shares of itself, of at most `A` too: five of `A` at most.
    #[inline(always)]
    pub(crate) fn off(&self) -> f64 {
        off_hull([self.p0, self.p1, self.p2], 6.0)
    }

    #[inline]
    pub(crate) fn unit_normal(&self) -> DVec3 {
        let p0 = self.p0.as_dvec3();
        (self.p1.as_dvec3() - p0).cross(self.p2.as_dvec3() - p0).normalize_or(DVec3::Z)
    }

    /// Returns a box that contains the triangle and every position that [`Self::closest`] reports.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points([self.p0, self.p1, self.p2]).grown_by_rounding()
    }

    /// Returns the surface parameters of a hit: the weights of `p1` and `p2`.
    #[must_use]
    #[inline]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// Returns the point `(1 - u - v) p0 + u p1 + v p2`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.at(f64::from(uv.x), f64::from(uv.y)))
    }

    /// Returns the unit normal, the direction of `(p1 - p0) × (p2 - p0)`. It does not depend on
    /// `uv`.
    #[must_use]
    pub fn normal(&self, _uv: Vec2) -> Vec3 {
        round(self.unit_normal())
    }

    /// Returns the derivatives of [`Self::position`] by `u` and by `v`: the edges at `p0`.
    #[must_use]
    pub fn tangents(&self, _uv: Vec2) -> (Vec3, Vec3) {
        (self.p1 - self.p0, self.p2 - self.p0)
    }
}
