//! The bilinear patch.
//!
//! # Derivation
//!
//! Seen along the ray (`ray_space.rs`), the patch is a map of the unit square to the plane, and the
//! ray is the origin: we look for `(u, v)` with `(1 - v) P0(u) + v P1(u) = 0`, where `P0(u)` and `P1(u)`
//! run along the edges `v = 0` and `v = 1`. The origin lies on the line through `P0(u)` and `P1(u)` if
//!
//! ```text
//! P0(u) × P1(u) = c + b u + a u² = 0     c = p00 × p01,  a = (p10 - p00) × (p11 - p01),  a + b + c = p10 × p11
//! ```
//!
//! so `c` and `a + b + c` are the areas of the edges `u = 0` and `u = 1`.
//!
//! # Watertight edges
//!
//! No rounded root can decide whether it lies on this or that side of an edge so that the neighbour,
//! whose corners come in another order, decides the opposite. The outline does: the number of times it
//! winds around the ray has the parity of the number of roots in the square, which is 0, 1 or 2. Whether
//! an edge counts depends on its two vertices alone. Hence: odd means exactly one root, clamped to the
//! square; even means two or none.
//!
//! Sources: S. D. Ramsey, K. Potter, C. Hansen, "Ray Bilinear Patch Intersections", journal of graphics
//! tools 9(3), 2004, for the quadratic in the plane; A. Reshetov, "Cool Patches", Ray Tracing Gems,
//! chapter 8, 2019, for the choice of `a, b, c` and for the stable roots.

use glam::{DVec3, Vec2, Vec3};

use crate::float::{UNIT_ROUNDOFF, accept, round, rounding_error};
use crate::ray_space::{Image, RaySpace, crosses, edge};
use crate::{Aabb, Hit, Ray, widen};

/// The surface of all points `(1-u)(1-v) p00 + u(1-v) p10 + (1-u)v p01 + uv p11`, `u, v` in `0..=1`.
///
/// # Accuracy
///
/// `t` is the rounded root, but for rays that graze to `1e-9` or start on the patch: they lose up to
/// `1e3 u t`, `u = 2⁻²⁴`. The position is within `1.0 u max(|p|, size)` of the surface always, and the
/// normal within `2e-5` degrees, except at such grazing rays and next to a collapsed edge. A ray at an edge
/// or a corner that several patches share hits one of them, in whatever order each lists its corners.
///
/// # Degenerate inputs
///
/// Two corners may coincide: then it is a curved triangle, whose normal at that corner is the limit. A
/// patch without area, and a flat patch seen edge-on, miss. Of a ruling seen end-on, which the ray shares
/// with the surface, the middle counts.
///
/// ```
/// use rotund_geometry::glam::{Vec2, Vec3};
/// use rotund_geometry::{BilinearPatch, Ray};
///
/// let [p00, p10, p01, p11] = [[0.0; 3], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [1.0, 1.0, 0.0]].map(Vec3::from);
/// let saddle = BilinearPatch { p00, p10, p01, p11 };
/// let hit = saddle.closest(&Ray::new(Vec3::new(0.5, 0.5, 3.0), Vec3::NEG_Z)).expect("a hit");
/// assert_eq!(hit.position, Vec3::new(0.5, 0.5, 0.25));
/// assert_eq!(saddle.position(saddle.uv(&hit)), hit.position);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
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

struct Root {
    t: f32,
    u: f64,
    v: f64,
}

/// The corners as the ray sees them.
#[derive(Clone, Copy)]
struct Corners {
    p00: Image,
    p10: Image,
    p01: Image,
    p11: Image,
}

/// Below this share of its terms, the discriminant leaves too few digits for two nearby roots.
const NEARLY_DOUBLE: f64 = 1.0 / 4096.0;

impl BilinearPatch {
    /// The first crossing of the surface with `t` in `t_min..=t_max`.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let Root { t, u, v } = self.solve(ray)?;
        let position = round(self.at(u, v));
        Some(Hit {
            t,
            position,
            error: rounding_error(position),
            normal: round(self.normal_at(u, v)),
            parameters: Vec2::new(u as f32, v as f32),
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
        let space = RaySpace::new(ray);
        let (p00, p10) = space.project(self.p00, self.p10);
        let (p01, p11) = space.project(self.p01, self.p11);
        // The patch lies in the hull of its corners. A NaN may pass here; it fails below.
        let outside = (low(low(p00.x, p10.x), low(p01.x, p11.x)) > 0.0)
            | (low(low(p00.y, p10.y), low(p01.y, p11.y)) > 0.0)
            | (high(high(p00.x, p10.x), high(p01.x, p11.x)) < 0.0)
            | (high(high(p00.y, p10.y), high(p01.y, p11.y)) < 0.0);
        if outside {
            return None;
        }
        let c = edge(p00, p01);
        let at_one = edge(p10, p11);
        let a = (p10.x - p00.x) * (p11.y - p01.y) - (p11.x - p01.x) * (p10.y - p00.y);
        let b = at_one - c - a;
        let odd = crosses(p00, p01, c)
            ^ crosses(p10, p11, at_one)
            ^ crosses(p00, p10, edge(p00, p10))
            ^ crosses(p01, p11, edge(p01, p11));
        let corners = Corners { p00, p10, p01, p11 };
        // The common hit: one root in the square, and the line through P0(u) and P1(u) passes the ray
        // once on its way from one edge to the other. An infinite product is of infinite corners.
        let ends = c * at_one;
        if !(odd & (ends < 0.0) & (ends > f64::NEG_INFINITY)) {
            // Two roots in 0..=1 need a parabola that has both ends on one side, and comes back.
            let folded =
                odd | ((ends > 0.0) & (c * a > 0.0) & (a * b < 0.0) & (b.abs() < 2.0 * a.abs()));
            return if folded { corners.solve_folded(ray, &space, [c, b, a], odd) } else { None };
        }
        // Of the two roots, the one where the parabola passes in this direction. The discriminant is
        // at least 4 |a c| here, or b², but rounding does not know.
        let root = (b * b - 4.0 * a * c).max(0.0).sqrt().copysign(at_one);
        let same = (b >= 0.0) == (at_one >= 0.0);
        let (over, under) = if same { (-2.0 * c, b + root) } else { (root - b, 2.0 * a) };
        let u = (over / under).clamp(0.0, 1.0);
        let (mut v, mut depth) = corners.along_ruling(u);
        let mut u = u;
        if root * root < NEARLY_DOUBLE * (b * b) {
            (u, v, depth) = corners.refine(u, v);
        }
        let t = accept(ray, space.t(depth))?;
        Some(Root { t, u, v: v.clamp(0.0, 1.0) })
    }

    #[inline(always)]
    fn corners(&self) -> [DVec3; 4] {
        let (p00, p10) = widen::points(self.p00, self.p10);
        let (p01, p11) = widen::points(self.p01, self.p11);
        [p00, p10, p01, p11]
    }

    #[inline(always)]
    fn at(&self, u: f64, v: f64) -> DVec3 {
        let [p00, p10, p01, p11] = self.corners();
        (1.0 - v) * ((1.0 - u) * p00 + u * p10) + v * ((1.0 - u) * p01 + u * p11)
    }

    #[inline(always)]
    fn partials(&self, u: f64, v: f64) -> (DVec3, DVec3) {
        let [p00, p10, p01, p11] = self.corners();
        ((1.0 - v) * (p10 - p00) + v * (p11 - p01), (1.0 - u) * (p01 - p00) + u * (p11 - p10))
    }

    #[inline(always)]
    fn normal_at(&self, u: f64, v: f64) -> DVec3 {
        let (du, dv) = self.partials(u, v);
        let n = du.cross(dv);
        let square = n.dot(n);
        if square > 0.0 && square < f64::INFINITY {
            return n * square.sqrt().recip();
        }
        self.normal_of_collapsed(u, v)
    }

    /// Where an edge is a point the partials do not span a plane, but their limit does.
    #[cold]
    fn normal_of_collapsed(&self, u: f64, v: f64) -> DVec3 {
        let inwards = |x: f64| x + (0.5 - x) * f64::from(f32::EPSILON);
        let (du, dv) = self.partials(inwards(u), inwards(v));
        du.cross(dv).try_normalize().unwrap_or_else(|| {
            let along = if du.length_squared() > dv.length_squared() { du } else { dv };
            along.try_normalize().map_or(DVec3::Z, DVec3::any_orthonormal_vector)
        })
    }

    /// A box that holds the patch, and every position that [`Self::closest`] reports.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points([self.p00, self.p10, self.p01, self.p11]).grown_by_rounding()
    }

    /// The parameters of a hit, `(u, v)`.
    #[must_use]
    #[inline]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        hit.parameters
    }

    /// The point with parameters `(u, v)`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(self.at(f64::from(uv.x), f64::from(uv.y)))
    }

    /// The unit normal at [`Self::position`]: the direction of `du × dv`.
    #[must_use]
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        round(self.normal_at(f64::from(uv.x), f64::from(uv.y)))
    }

    /// The derivatives of [`Self::position`] by `u` and by `v`.
    #[must_use]
    pub fn tangents(&self, uv: Vec2) -> (Vec3, Vec3) {
        let (du, dv) = self.partials(f64::from(uv.x), f64::from(uv.y));
        (round(du), round(dv))
    }
}

impl Corners {
    /// Where the ruling of constant `u` comes nearest to the ray: `v`, and the depth there with `v`
    /// clamped to the patch.
    #[inline(always)]
    fn along_ruling(&self, u: f64) -> (f64, f64) {
        let (p0, p1) = (between(self.p00, self.p10, u), between(self.p01, self.p11, u));
        let (x, y) = (p1.x - p0.x, p1.y - p0.y);
        let square = x * x + y * y;
        // A ruling seen end-on is a point of the image: take its middle.
        let v = if square > 0.0 { -(p0.x * x + p0.y * y) / square } else { 0.5 };
        (v, p0.depth + v.clamp(0.0, 1.0) * (p1.depth - p0.depth))
    }

    /// One step of Newton in both parameters, and the depth there.
    ///
    /// Two roots may nearly agree in `u` and differ in `v`, if a ruling is nearly parallel to the ray.
    /// Half of the digits of `u` are lost then, and `v` follows; but both are well determined together.
    #[cold]
    #[inline(never)]
    fn refine(&self, u: f64, v: f64) -> (f64, f64, f64) {
        type Coordinate = fn(Image) -> f64;
        let Self { p00, p10, p01, p11 } = *self;
        let v = v.clamp(0.0, 1.0);
        let mix = |a: f64, b: f64, s: f64| (1.0 - s) * a + s * b;
        let at =
            |f: Coordinate, u: f64, v: f64| mix(mix(f(p00), f(p10), u), mix(f(p01), f(p11), u), v);
        let by_u = |f: Coordinate| mix(f(p10) - f(p00), f(p11) - f(p01), v);
        let by_v = |f: Coordinate| mix(f(p01) - f(p00), f(p11) - f(p10), u);
        let (fx, fy): (Coordinate, Coordinate) = (|p| p.x, |p| p.y);
        let (x, y) = (at(fx, u, v), at(fy, u, v));
        let ((xu, yu), (xv, yv)) = ((by_u(fx), by_u(fy)), (by_v(fx), by_v(fy)));
        let determinant = xu * yv - xv * yu;
        let step = ((xv * y - yv * x) / determinant, (yu * x - xu * y) / determinant);
        // A step that an `f32` could see is no correction of rounding: this is a fold, and there is no
        // better point than the one at hand.
        let small = step.0.abs().max(step.1.abs()) < f64::from(UNIT_ROUNDOFF);
        let moved = |x: f64, step: f64| if small { (x + step).clamp(0.0, 1.0) } else { x };
        let (u, v) = (moved(u, step.0), moved(v, step.1));
        (u, v, at(|p| p.depth, u, v))
    }

    /// Two roots in `u` that may count: the ray meets the patch twice, or once near a fold or a corner.
    #[cold]
    #[inline(never)]
    fn solve_folded(
        &self,
        ray: &Ray,
        space: &RaySpace,
        [c, b, a]: [f64; 3],
        odd: bool,
    ) -> Option<Root> {
        let discriminant = b * b - 4.0 * a * c;
        if !odd && discriminant < 0.0 {
            return None;
        }
        let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
        // A corner that is not finite makes a NaN of one of them, or an infinity.
        if !(a.is_finite() && q.is_finite()) {
            return None;
        }
        let roots = [q / a, if q == 0.0 { 0.0 } else { c / q }];
        let root = |u: f64| {
            let u = u.clamp(0.0, 1.0);
            let v = self.along_ruling(u).0;
            let (u, refined, depth) = self.refine(u, v);
            let t64 = space.t(depth);
            (v, t64, accept(ray, t64).map(|t| Root { t, u, v: refined }))
        };
        if odd {
            // One of them is in the square: the one nearer to its centre. A NaN, of 0 / 0, is not.
            let from_center = |u: f64| {
                let v = self.along_ruling(u.clamp(0.0, 1.0)).0;
                (u - 0.5).abs().max((v - 0.5).abs())
            };
            let first = from_center(roots[0]) < from_center(roots[1]);
            return root(if first { roots[0] } else { roots[1] }).2;
        }
        // The ends of the parabola say that both `u` are in the square; the outline says that both `v`
        // are, or none.
        let [(v0, t0, first), (v1, t1, second)] = roots.map(root);
        if !((0.0..=1.0).contains(&v0) && (0.0..=1.0).contains(&v1)) {
            return None;
        }
        match (first, second) {
            // They may round to the same `t`: the nearer one is nearer before that.
            (Some(first), Some(second)) => Some(if t1 < t0 { second } else { first }),
            (first, second) => first.or(second),
        }
    }
}

// Functions, not closures: a closure would stay a call of its own where the caller is compiled for more
// instructions than this crate, and `f64::min` minds NaN at a cost.

#[inline(always)]
fn low(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn high(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn between(a: Image, b: Image, s: f64) -> Image {
    Image {
        x: a.x + s * (b.x - a.x),
        y: a.y + s * (b.y - a.y),
        depth: a.depth + s * (b.depth - a.depth),
    }
}
