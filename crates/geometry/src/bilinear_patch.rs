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
//! # Too few digits
//!
//! At a root the parabola has the slope `±√D`, `D = b² - 4 a c`, which is also the area that a unit of the
//! square has in the image. With images of size `s`, an `f64` knows the parabola to some `2⁻⁵³ s²`, hence
//! `u` to `2⁻⁵³ s² / √D`, hence `v` to `s / |P1 - P0|` times that, and a depth, of corners as deep as `h`, to
//! `h` times that. If this is no small part of a unit of `t`, which happens at folds, along a ruling, and
//! next to the origin of the ray, `careful_patch.rs` solves with 106 bits.
//!
//! Sources: S. D. Ramsey, K. Potter, C. Hansen, "Ray Bilinear Patch Intersections", journal of graphics
//! tools 9(3), 2004, for the quadratic in the plane; A. Reshetov, "Cool Patches", Ray Tracing Gems,
//! chapter 8, 2019, for the choice of `a, b, c` and for the stable roots.

use glam::{DVec3, Vec2, Vec3};

use crate::float::{accept, round, rounding_error};
use crate::ray_space::{Image, RaySpace, crosses, edge};
use crate::{Aabb, Hit, Ray, careful_patch, widen};

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

/// A crossing, of `T` as it is computed or as it is reported.
pub(crate) struct Root<T = f64> {
    pub(crate) t: T,
    pub(crate) u: f64,
    pub(crate) v: f64,
}

/// The corners as the ray sees them, and a bound on the coordinates of these images.
#[derive(Clone, Copy)]
struct Corners {
    p00: Image,
    p10: Image,
    p01: Image,
    p11: Image,
    size: f64,
}

/// Where a ruling comes nearest to the ray: `v`, the depth there with `v` clamped to the patch, and the
/// square of the length of its image.
struct Ruling {
    v: f64,
    depth: f64,
    square: f64,
}

/// The square of `2⁻²²`, the share of their terms at which `2⁻⁵³` of these are `2⁻³¹` of what is left: an
/// `f32` has 24 bits, so the rounding of the `f64` arithmetic is some hundredth of its own.
const TOO_FEW_DIGITS: f64 = 1.0 / 17_592_186_044_416.0;

/// Roots nearer than this to an edge are in the square or not for 106 bits to tell.
///
/// With the digits that are not too few, an `f64` is wrong by `2⁻³¹`; a distance of a thousand sizes costs
/// ten bits of that.
const NEXT_TO_EDGE: f64 = 1.0 / 1_048_576.0;

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
    fn solve(&self, ray: &Ray) -> Option<Root<f32>> {
        let space = RaySpace::new(ray);
        let (p00, p10) = space.project(self.p00, self.p10);
        let (p01, p11) = space.project(self.p01, self.p11);
        let (x_min, x_max) = range(p00.x, p10.x, p01.x, p11.x);
        let (y_min, y_max) = range(p00.y, p10.y, p01.y, p11.y);
        // The patch lies in the hull of its corners. A NaN may pass here; it fails below.
        if (x_min > 0.0) | (y_min > 0.0) | (x_max < 0.0) | (y_max < 0.0) {
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
        let size = (x_max - x_min) + (y_max - y_min);
        let corners = Corners { p00, p10, p01, p11, size };
        // The common hit: one root in the square, and the line through P0(u) and P1(u) passes the ray
        // once on its way from one edge to the other. An infinite product is of infinite corners.
        let ends = c * at_one;
        if !(odd & (ends < 0.0) & (ends > f64::NEG_INFINITY)) {
            // Two roots in 0..=1 need a parabola that has both ends on one side, and comes back.
            let folded =
                odd | ((ends > 0.0) & (c * a > 0.0) & (a * b < 0.0) & (b.abs() < 2.0 * a.abs()));
            return if folded { self.solve_folded(ray, &space, &corners, odd) } else { None };
        }
        // Of the two roots, the one where the parabola passes in this direction. The discriminant is
        // at least 4 |a c| here, or b², but rounding does not know.
        let discriminant = (b * b - 4.0 * a * c).max(0.0);
        let root = discriminant.sqrt().copysign(at_one);
        let same = (b >= 0.0) == (at_one >= 0.0);
        let (over, under) = if same { (-2.0 * c, b + root) } else { (root - b, 2.0 * a) };
        let u = (over / under).clamp(0.0, 1.0);
        let ruling = corners.along_ruling(u);
        if corners.too_few_digits(discriminant, &ruling) {
            return self.solve_carefully(ray, &space, odd);
        }
        let t = accept(ray, space.t(ruling.depth))?;
        Some(Root { t, u, v: ruling.v.clamp(0.0, 1.0) })
    }

    /// Two roots in `u` that may count: the ray meets the patch twice, or once near a fold or a corner.
    #[cold]
    #[inline(never)]
    fn solve_folded(
        &self,
        ray: &Ray,
        space: &RaySpace,
        corners: &Corners,
        odd: bool,
    ) -> Option<Root<f32>> {
        let [c, b, a] = corners.parabola();
        let discriminant = b * b - 4.0 * a * c;
        let square = corners.size * corners.size;
        if !odd && discriminant < -TOO_FEW_DIGITS * (square * square) {
            return None;
        }
        let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
        // A corner that is not finite makes a NaN of one of them, or an infinity.
        if !(a.is_finite() && q.is_finite()) {
            return None;
        }
        let roots = [q / a, if q == 0.0 { 0.0 } else { c / q }].map(|raw| {
            let u = raw.clamp(0.0, 1.0);
            let ruling = corners.along_ruling(u);
            let root = Root { t: space.t(ruling.depth), u, v: ruling.v.clamp(0.0, 1.0) };
            // A NaN, of 0 / 0, is not in the square, and not next to its edge.
            let from_center = (raw - 0.5).abs().max((ruling.v - 0.5).abs());
            (root, from_center, corners.too_few_digits(discriminant, &ruling))
        });
        let [(first, first_off, first_poor), (second, second_off, second_poor)] = roots;
        let next_to_edge = |off: f64| (off - 0.5).abs() < NEXT_TO_EDGE;
        if first_poor | second_poor | next_to_edge(first_off) | next_to_edge(second_off) {
            return self.solve_carefully(ray, space, odd);
        }
        if odd {
            // One of them is in the square: the one nearer to its centre.
            let root = if first_off < second_off { first } else { second };
            return nearest(ray, [Some(root), None]);
        }
        // The outline says that both are in the square, or none.
        let both = (first_off <= 0.5) & (second_off <= 0.5);
        if both { nearest(ray, [Some(first), Some(second)]) } else { None }
    }

    #[cold]
    #[inline(never)]
    fn solve_carefully(&self, ray: &Ray, space: &RaySpace, odd: bool) -> Option<Root<f32>> {
        nearest(ray, careful_patch::solve(self, ray, space, odd))
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
    /// `c`, `b` and `a`.
    fn parabola(&self) -> [f64; 3] {
        let Self { p00, p10, p01, p11, .. } = *self;
        let c = edge(p00, p01);
        let a = (p10.x - p00.x) * (p11.y - p01.y) - (p11.x - p01.x) * (p10.y - p00.y);
        [c, edge(p10, p11) - c - a, a]
    }

    /// The ruling of constant `u`.
    #[inline(always)]
    fn along_ruling(&self, u: f64) -> Ruling {
        let (p0, p1) = (between(self.p00, self.p10, u), between(self.p01, self.p11, u));
        let (x, y) = (p1.x - p0.x, p1.y - p0.y);
        let square = x * x + y * y;
        // A ruling seen end-on is a point of the image: take its middle.
        let v = if square > 0.0 { -(p0.x * x + p0.y * y) / square } else { 0.5 };
        let depth = p0.depth + v.clamp(0.0, 1.0) * (p1.depth - p0.depth);
        Ruling { v, depth, square }
    }

    /// True if 53 bits are too few at this root, see above. False for a NaN.
    #[inline(always)]
    fn too_few_digits(&self, discriminant: f64, ruling: &Ruling) -> bool {
        let [p00, p10, p01, p11] = [self.p00, self.p10, self.p01, self.p11].map(|p| p.depth.abs());
        let terms = ((p00 + p10) + (p01 + p11)) * (self.size * self.size * self.size);
        let left = (ruling.depth * ruling.depth) * (discriminant * ruling.square);
        left < TOO_FEW_DIGITS * (terms * terms)
    }
}

/// The first root in the interval of the ray. Two may round to the same `t`: the nearer one is nearer
/// before that.
fn nearest(ray: &Ray, [first, second]: [Option<Root>; 2]) -> Option<Root<f32>> {
    let ordered = match (first, second) {
        (Some(first), Some(second)) if second.t < first.t => [Some(second), Some(first)],
        roots => [roots.0, roots.1],
    };
    ordered.into_iter().flatten().find_map(|Root { t, u, v }| {
        let t = accept(ray, t)?;
        Some(Root { t, u, v })
    })
}

// Functions, not closures: a closure would stay a call of its own where the caller is compiled for more
// instructions than this crate, and `f64::min` minds NaN at a cost.

/// The smallest and the largest.
#[inline(always)]
fn range(a: f64, b: f64, c: f64, d: f64) -> (f64, f64) {
    (low(low(a, b), low(c, d)), high(high(a, b), high(c, d)))
}

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
