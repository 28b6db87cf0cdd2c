//! The triangle.

use glam::{DVec3, Vec2, Vec3};

use crate::f64x2::{F64x2, Mask};
use crate::filter::{Filtered, Solve, queries};
use crate::float::{round, rounding_error};
use crate::ray_space::{Images, RaySpace};
use crate::{Aabb, Hit, Ray};

/// The flat triangle of three points.
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

/// Where a ray meets two triangles.
pub(crate) struct Crossings {
    /// Which of the two it meets; the rest holds for these.
    pub(crate) exist: Mask,
    pub(crate) depth: F64x2,
    /// The weights of the second and of the third corner.
    pub(crate) u: F64x2,
    pub(crate) v: F64x2,
}

impl Crossings {
    /// From the images of the corners, in the order of each triangle.
    #[inline(always)]
    pub(crate) fn of(p0: &Images, p1: &Images, p2: &Images) -> Self {
        // The weight of each corner is the area that the ray spans with the opposite edge.
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
    /// The crossing of the triangle with `t` in `t_min..=t_max`.
);

impl Solve for Triangle {
    type Root = Root;

    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<Root> {
        let space = RaySpace::new(ray);
        // Not by a closure: it would be compiled without the instructions of the tree that calls this, and be called.
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
            error: rounding_error(position),
            normal: round(self.unit_normal()),
            parameters: Vec2::new(u as f32, v as f32),
        }
    }
}

impl Triangle {
    #[inline]
    pub(crate) fn at(&self, u: f64, v: f64) -> DVec3 {
        let (p0, p1, p2) = (self.p0.as_dvec3(), self.p1.as_dvec3(), self.p2.as_dvec3());
        // The rounded u + v may exceed 1; the point must not leave the triangle's box.
        (1.0 - u - v).max(0.0) * p0 + u * p1 + v * p2
    }

    #[inline]
    pub(crate) fn unit_normal(&self) -> DVec3 {
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
