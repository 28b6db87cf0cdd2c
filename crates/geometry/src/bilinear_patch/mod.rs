//! The bilinear patch: its definition and its points.
//!
//! `image.rs` derives the intersection with a ray, `filter.rs` is its floating-point filter and
//! `exact.rs` its exact evaluation.

mod exact;
mod filter;
mod image;

use glam::{DVec3, Vec2, Vec3};

use crate::filter::{Filtered, Solve, queries};
use crate::float::{error, off_hull, round};
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Aabb, Hit, Ray, widen};
use image::Root;

/// The surface of all points `(1-u)(1-v) p00 + u(1-v) p10 + (1-u)v p01 + uv p11`, `u, v` in
/// `0..=1`.
///
/// # Accuracy
///
/// `t` is the exact root, rounded; for rays that graze to `1e-9` or start on the patch, its error
/// is up to `1e3 u t`, `u = 2⁻²⁴`. The position is always within `1.0 u max(|p|, size)` of the
/// surface, and the normal within `2e-5` degrees, except for such grazing rays and next to a
/// collapsed edge. A ray at an edge or a corner that several patches share hits exactly one of
/// them, in whatever order each lists its corners.
///
/// # Degenerate inputs
///
/// If two corners coincide, the patch is a curved triangle, and its normal at that corner is the
/// limit. A patch without area, a flat patch seen edge-on, and one with a corner that is not finite
/// miss. A ray exactly along a ruling, a straight line in the surface, has no single crossing, and
/// misses like one in the plane of a flat patch. If its rounding moves it off the ruling, it hits
/// where the moved ray crosses the surface, if it does.
///
/// ```
/// use rotund_geometry::glam::{Vec2, Vec3};
/// use rotund_geometry::{BilinearPatch, Ray};
///
/// let saddle = BilinearPatch {
///     p00: Vec3::new(0.0, 0.0, 0.0),
///     p10: Vec3::new(1.0, 0.0, 0.5),
///     p01: Vec3::new(0.0, 1.0, 0.5),
///     p11: Vec3::new(1.0, 1.0, 0.0),
/// };
/// let hit = saddle.closest(&Ray::new(Vec3::new(0.5, 0.5, 3.0), Vec3::NEG_Z)).expect("a hit");
/// assert_eq!(hit.position, Vec3::new(0.5, 0.5, 0.25));
/// assert_eq!(saddle.position(saddle.uv(&hit)), hit.position);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BilinearPatch {
    /// The corner `u = 0, v = 0`.
    pub p00: Vec3,
    /// The corner `u = 1, v = 0`.
    pub p10: Vec3,
    /// The corner `u = 0, v = 1`.
    pub p01: Vec3,
    /// The corner `u = 1, v = 1`.
    pub p11: Vec3,
}

/// The unit square in the plane `z = 0`: the point with parameters `(u, v)` is `(u, v, 0)`.
impl Default for BilinearPatch {
    fn default() -> Self {
        Self { p00: Vec3::ZERO, p10: Vec3::X, p01: Vec3::Y, p11: Vec3::new(1.0, 1.0, 0.0) }
    }
}

queries!(
    BilinearPatch,
    /// Returns the first crossing of the surface with `t` in `t_min..=t_max`, from either side.
);

impl Solve for BilinearPatch {
    type Root = Root<f32>;

    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<Root<f32>> {
        filter::filter(self, ray)
    }

    #[cold]
    #[inline(never)]
    fn solve_exactly(&self, ray: &Ray) -> Option<Root<f32>> {
        exact::solve(self, ray)
    }

    #[inline(always)]
    fn t(root: &Root<f32>) -> f32 {
        root.t
    }

    #[inline(always)]
    fn hit(&self, _: &Ray, Root { t, u, v }: Root<f32>) -> Hit {
        let (point, normal) = self.point_and_normal(u, v);
        let position = round(point);
        Hit {
            t,
            position,
            error: error(position, self.off()),
            normal: round(normal),
            parameters: Vec2::new(u as f32, v as f32),
        }
    }
}

impl BilinearPatch {
    /// Returns the point, and the derivatives by `u` and by `v`.
    #[inline(always)]
    fn at(&self, u: f64, v: f64) -> [DVec3; 3] {
        let (p00, p10) = widen::points(self.p00, self.p10);
        let (p01, p11) = widen::points(self.p01, self.p11);
        let (u0, u1) = (p01 - p00, p11 - p10);
        let (from, to) = (p00 + v * u0, p10 + v * u1);
        let by_u = to - from;
        [from + u * by_u, by_u, u0 + u * (u1 - u0)]
    }

    /// Returns a bound on the rounding of the point of [`Self::at`].
    ///
    /// Let `A` be the largest coordinates of the corners. The ends of the ruling have a rounding of
    /// `2 A` each in the difference and the product, and one of `A` in the sum: five of `A`. The
    /// point averages them, and adds as much by its own difference, product and sum.
    #[inline(always)]
    fn off(&self) -> f64 {
        off_hull([self.p00, self.p10, self.p01, self.p11], 11.0)
    }

    #[inline(always)]
    fn point_and_normal(&self, u: f64, v: f64) -> (DVec3, DVec3) {
        let [point, du, dv] = self.at(u, v);
        let n = du.cross(dv);
        let square = n.dot(n);
        if square > 0.0 {
            (point, n / square.sqrt())
        } else {
            (point, self.normal_of_collapsed(u, v))
        }
    }

    /// Returns the limit of the normal at an edge that has collapsed to a point, where the
    /// derivatives do not span a plane.
    #[cold]
    #[inline(never)]
    fn normal_of_collapsed(&self, u: f64, v: f64) -> DVec3 {
        let inwards = |x: f64| x + (0.5 - x) * f64::from(f32::EPSILON);
        let [_, du, dv] = self.at(inwards(u), inwards(v));
        du.cross(dv).try_normalize().unwrap_or_else(|| {
            let along = if du.length_squared() > dv.length_squared() { du } else { dv };
            along.try_normalize().map_or(DVec3::Z, DVec3::any_orthonormal_vector)
        })
    }

    /// Returns a box that contains the patch and every position that [`Self::closest`] reports.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points([self.p00, self.p10, self.p01, self.p11]).grown_by_rounding()
    }

    /// Returns the surface parameters of a hit, `(u, v)`.
    #[must_use]
    #[inline]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// Returns the point with parameters `(u, v)`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.at(f64::from(uv.x), f64::from(uv.y))[0])
    }

    /// Returns the unit normal at [`Self::position`], the direction of `du × dv`.
    #[must_use]
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        round(self.point_and_normal(f64::from(uv.x), f64::from(uv.y)).1)
    }

    /// Returns the derivatives of [`Self::position`] by `u` and by `v`.
    #[must_use]
    pub fn tangents(&self, uv: Vec2) -> (Vec3, Vec3) {
        let [_, du, dv] = self.at(f64::from(uv.x), f64::from(uv.y));
        (round(du), round(dv))
    }
}
