//! The vanilla quad: two triangles.

use glam::{Vec2, Vec3};

use crate::filter::{Filtered, Solve, queries};
use crate::float::{error, round};
use crate::ray_space::RaySpace;
use crate::triangle::Crossings;
use crate::{Aabb, Hit, Ray, Triangle};

/// The triangles `p0 p1 p3` and `p2 p3 p1`, which share the diagonal `p1 p3`.
///
/// # Accuracy and degenerate inputs
///
/// Both are those of [`Triangle`]. If `p2` and `p3` coincide, the quad is the first triangle. If a
/// corner is not finite, every ray misses.
///
/// ```
/// use rotund_geometry::glam::{Vec2, Vec3};
/// use rotund_geometry::{Ray, vanilla::Quad};
///
/// let [p0, p1, p2] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.5)];
/// let quad = Quad { p0, p1, p2, p3: Vec3::Y };
/// let hit = quad.closest(&Ray::new(Vec3::new(0.75, 0.75, 3.0), Vec3::NEG_Z)).expect("a hit");
/// assert_eq!((hit.t, quad.uv(&hit)), (2.75, Vec2::splat(0.75)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Quad {
    /// The corner `u = 0, v = 0`.
    pub p0: Vec3,
    /// The corner `u = 1, v = 0`.
    pub p1: Vec3,
    /// The corner `u = 1, v = 1`.
    pub p2: Vec3,
    /// The corner `u = 0, v = 1`.
    pub p3: Vec3,
}

/// The unit square in the plane `z = 0`, as the default [`BilinearPatch`](crate::BilinearPatch).
impl Default for Quad {
    fn default() -> Self {
        Self { p0: Vec3::ZERO, p1: Vec3::X, p2: Vec3::new(1.0, 1.0, 0.0), p3: Vec3::Y }
    }
}

pub(crate) struct Root {
    t: f32,
    u: f64,
    v: f64,
    /// Whether the second triangle is the one that is hit.
    second: bool,
}

queries!(
    Quad,
    /// Returns the first crossing with `t` in `t_min..=t_max`, from either side.
);

impl Solve for Quad {
    type Root = Root;

    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<Root> {
        let space = RaySpace::new(ray);
        // The first lane is for the first triangle, the second lane for the second one.
        let (p0, p1) = (space.project(&self.p0, &self.p2), space.project(&self.p1, &self.p3));
        let Crossings { exist, depth, u, v } = Crossings::of(&p0, &p1, &p1.swapped());
        let exist = exist.bits();
        if exist == 0 || !self.is_finite() {
            return Filtered::Miss;
        }
        let [first, second] = depth.to_array().map(|depth| ray.accept(space.t(depth)));
        let (first, second) = (first.filter(|_| exist & 1 != 0), second.filter(|_| exist & 2 != 0));
        let (t, second) = match (first, second) {
            (Some(first), Some(second)) => (Some(first.min(second)), second < first),
            (first, second) => (first.or(second), first.is_none()),
        };
        let [u, v] = if second { [u.second(), v.second()] } else { [u.first(), v.first()] };
        t.map(|t| Root { t, u, v, second }).into()
    }

    #[inline(always)]
    fn t(root: &Root) -> f32 {
        root.t
    }

    #[inline(always)]
    fn hit(&self, _: &Ray, Root { t, u, v, second }: Root) -> Hit {
        let triangle = if second { self.second() } else { self.first() };
        let position = round(triangle.at(u, v));
        let uv = Vec2::new(u as f32, v as f32);
        Hit {
            t,
            position,
            error: error(position, triangle.off()),
            normal: round(triangle.unit_normal()),
            parameters: if second { Vec2::ONE - uv } else { uv },
        }
    }
}

impl Quad {
    fn first(&self) -> Triangle {
        Triangle { p0: self.p0, p1: self.p1, p2: self.p3 }
    }

    fn second(&self) -> Triangle {
        Triangle { p0: self.p2, p1: self.p3, p2: self.p1 }
    }

    /// Returns whether all four corners are finite; each triangle by itself would ignore one of
    /// them.
    #[inline]
    fn is_finite(&self) -> bool {
        // An infinity times zero is a NaN, and so is every sum with it.
        let sum = (self.p0 + self.p1 * 0.0) * 0.0 + (self.p2 * 0.0 + self.p3 * 0.0);
        sum == Vec3::ZERO
    }

    /// Returns a box that contains both triangles and every position that [`Self::closest`]
    /// reports.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.first().bounds().union(self.second().bounds())
    }

    /// Returns the parameters of a hit on the quad; `u + v > 1` on the second triangle.
    #[must_use]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// Returns the point with parameters `(u, v)`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        if uv.x + uv.y <= 1.0 {
            self.first().position(uv)
        } else {
            self.second().position(Vec2::ONE - uv)
        }
    }

    /// Returns the unit normal of the triangle that contains `(u, v)`.
    #[must_use]
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        if uv.x + uv.y <= 1.0 { self.first().normal(uv) } else { self.second().normal(uv) }
    }
}
