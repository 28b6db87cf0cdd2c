//! The image of a bilinear patch in ray space, and its two crossings with the ray in `f64`.
//!
//! # Derivation
//!
//! In ray space (`ray_space.rs`) the patch is a map `P` of the unit square to the plane, and the
//! ray is the origin. The origin lies on the line through `P(u, 0)` and `P(u, 1)`, or on that
//! through `P(0, v)` and `P(1, v)`, if
//!
//! ```text
//! f(u) = P(u,0) × P(u,1) = c + b u + a u² = 0
//! g(v) = P(0,v) × P(1,v) = c'+ b'v + a'v² = 0
//!
//! c  = p00 × p01     e  = p10 × p11     a  = (p10-p00) × (p11-p01)
//! c' = p00 × p10     e' = p01 × p11     a' = (p01-p00) × (p11-p10)
//! ```
//!
//! so `c`, `e = a + b + c`, `c'` and `e'` are the areas of the four edges. With `P_u`, `P_v` the
//! derivatives, `f = P × P_v` and `g = P × P_u`: where `P = 0` the slopes are
//! `f' = P_u × P_v = -g'`. So both parabolas have the same discriminant `D`, a root of `f` of slope
//! `σ √D` goes with the root of `g` of slope `-σ √D`, and one square root gives both parameters,
//! side by side.
//!
//! # Watertight edges
//!
//! A rounded root cannot decide on which side of an edge it lies such that the neighbor, which
//! lists its corners in another order, decides the opposite. The outline can: its winding number
//! about the ray has the parity of the number of roots in the square, which is 0, 1 or 2. Whether
//! an edge counts depends on its two vertices alone. Hence: odd means exactly one root, clamped to
//! the square; even means two or none.
//!
//! # Too few digits
//!
//! `√D` is also the area that a unit of the square has in the image. With images of size `s`, an
//! `f64` knows the parabolas to some `2⁻⁵³ s²`, hence `u` and `v` to `2⁻⁵³ s² / √D`, and a depth,
//! of corners as deep as `h`, to `h` times that. If this is a considerable part of a unit of `t`,
//! which happens at folds, along a ruling, and next to the origin of the ray, `exact.rs` solves in
//! double-double.
//!
//! Seen from far, the images are small differences of large products. Let `k` be `h` times the
//! largest component of the direction. A coordinate of an image, `f_x d_z - f_z d_x`, has four
//! roundings of terms of up to `k`, so an image is off by up to `√2 4 · 2⁻⁵³ k`. At a root `f` is
//! then off by `s` times that: `u` and `v` are known to `6 · 2⁻⁵³ k s / √D`. Each of `a`, `b` and
//! `c` is at most 1, 3 and 1 times `s²`, and off by 4, 8 and 2 times `s` and the error of an image:
//! so `D` is off by `408 · 2⁻⁵³ k s³`.
//!
//! Sources: S. D. Ramsey, K. Potter, C. Hansen, "Ray Bilinear Patch Intersections", journal of
//! graphics tools 9(3), 2004, for the quadratic in the plane; A. Reshetov, "Cool Patches", Ray
//! Tracing Gems, chapter 8, 2019, for the choice of `a, b, c` and for the stable roots.

use super::BilinearPatch;
use crate::Ray;
use crate::f64x2::F64x2;
use crate::filter::Filtered;
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::ray_space::RaySpace;

/// A crossing; `t` is an `f64` while it is computed and an `f32` once it is accepted.
pub(crate) struct Root<T = f64> {
    pub(super) t: T,
    pub(super) u: f64,
    pub(super) v: f64,
}

/// The patch in ray space. Pairs hold the coefficients of `f` and `g`.
#[derive(Clone, Copy)]
pub(super) struct PatchImage {
    pub(super) space: RaySpace,
    /// Whether the outline winds around the ray an odd number of times.
    pub(super) odd: bool,
    /// The values of `f` and `g` at 0: the areas of the edges `u = 0` and `v = 0`.
    pub(super) c: F64x2,
    /// The values of `f` and `g` at 1: the areas of the edges `u = 1` and `v = 1`.
    pub(super) e: F64x2,
    pub(super) a: F64x2,
    /// The depths of the corners at `u = 0, 1`, for `v = 0` and for `v = 1`.
    depths: [F64x2; 2],
    /// Bound on the coordinates of the images.
    size: f64,
}

/// The square of `2⁻²²`: if a discriminant keeps less than this share of its terms, `f64` has too
/// few digits.
///
/// At `2⁻²²`, a rounding of `2⁻⁵³` of the terms is `2⁻³¹` of the difference. An `f32` has 24 bits,
/// so that rounding is about a hundredth of the one to `f32`.
const TOO_FEW_DIGITS: f64 = 1.0 / 17_592_186_044_416.0;

/// The square of `2⁻²⁸`: seen from far, the root of `D` must be this share of `4 k s`. Then `u` and
/// `v` are wrong by `2⁻²⁴` at most, as much as by their rounding to `f32`.
const TOO_FAR: f64 = 1.0 / 72_057_594_037_927_936.0;

/// `2⁻⁴⁶`: bounds the error of `D` as a share of `4 k s³`.
const ERROR_FROM_FAR: f64 = 1.0 / 70_368_744_177_664.0;

/// If a root is nearer than this to an edge, double-double must decide whether it is in the square.
///
/// Where `f64` has enough digits it is wrong by `2⁻³¹`; a distance of a thousand sizes costs ten
/// bits of that.
const NEXT_TO_EDGE: f64 = 1.0 / 1_048_576.0;

/// `2⁻⁸⁸`. A depth that keeps more than its square root, `2⁻⁴⁴`, of its terms has a certain sign:
/// one rounding is `2⁻⁵³` of the terms, and there are fewer than a hundred.
const CERTAIN_SIGN: f64 = 1.0 / 309_485_009_821_345_068_724_781_056.0;

impl PatchImage {
    /// Projects the patch; returns `None` if the ray misses the bounding rectangle of the image.
    #[inline(always)]
    pub(super) fn new(patch: &BilinearPatch, ray: &Ray) -> Option<Self> {
        let space = RaySpace::new(ray);
        // The edges `v = 0` and `v = 1`; each holds the vertices at `u = 0` and `u = 1`.
        let v0 = space.project(&patch.p00, &patch.p10);
        let v1 = space.project(&patch.p01, &patch.p11);
        let zero = F64x2::splat(0.0);
        let (x_min, x_max) = (v0.x.min(v1.x), v0.x.max(v1.x));
        let (y_min, y_max) = (v0.y.min(v1.y), v0.y.max(v1.y));
        // Both hold a bound in x and one in y.
        let low = x_min.firsts(y_min).min(x_min.seconds(y_min));
        let high = x_max.firsts(y_max).max(x_max.seconds(y_max));
        // The patch lies in the hull of its corners. A NaN may pass here; it fails below.
        if zero.less(low).or(high.less(zero)).any() {
            return None;
        }
        let (u0, u1) = (v0.firsts(&v1), v0.seconds(&v1));
        // The areas of the edges u = 0 and u = 1, and of v = 0 and v = 1.
        let (of_u, of_v) = (v0.areas(&v1), u0.areas(&u1));
        let odd = v0.crosses(&v1, of_u).differs(u0.crosses(&u1, of_v)).is_odd();
        let (along_u_x, along_u_y) = (u1.x - u0.x, u1.y - u0.y);
        let (along_v_x, along_v_y) = (v1.x - v0.x, v1.y - v0.y);
        let a = along_u_x.firsts(along_v_x) * along_u_y.seconds(along_v_y)
            - along_u_x.seconds(along_v_x) * along_u_y.firsts(along_v_y);
        let [width, height] = (high - low).to_array();
        Some(Self {
            space,
            odd,
            c: of_u.firsts(of_v),
            e: of_u.seconds(of_v),
            a,
            depths: [v0.depth, v1.depth],
            size: width + height,
        })
    }

    #[inline(always)]
    fn b(&self) -> F64x2 {
        (self.e - self.c) - self.a
    }

    /// Returns `u` and `v` where `f` has the slope `root` times the sign of `sign`, and `g` the
    /// opposite one.
    ///
    /// The root of slope `s` is `(s - b) / 2a`, or `-2c / (s + b)`: whichever sum does not cancel.
    #[inline(always)]
    pub(super) fn roots(&self, root: f64, sign: f64) -> F64x2 {
        let (b, signs) = (self.b(), F64x2::new(sign, -sign));
        let sum = (F64x2::splat(root) + b.abs()).times_sign_of(signs);
        let unlike = (b * signs).less(F64x2::splat(0.0));
        let over = unlike.select(sum, F64x2::splat(-2.0) * self.c);
        let under = unlike.select(self.a + self.a, sum);
        over / under
    }

    /// Solves for both crossings with the whole surface, and returns the first one in the square
    /// and in the interval of the ray.
    #[inline(always)]
    pub(super) fn solve_both(&self, ray: &Ray) -> Filtered<Root<f32>> {
        let (a, b, c) = (self.a, self.b(), self.c);
        // Both parabolas have this discriminant; the one with the smaller terms has the smaller
        // error.
        let discriminants = b * b - F64x2::splat(4.0) * a * c;
        let smaller = b.first().abs() <= b.second().abs();
        let discriminant = if smaller { discriminants.first() } else { discriminants.second() };
        let square = self.size * self.size;
        let error = TOO_FEW_DIGITS * square + ERROR_FROM_FAR * (self.size * self.terms_from_far());
        if !self.odd && discriminant < -(square * error) {
            return Filtered::Miss;
        }
        let root = discriminant.max(0.0).sqrt();
        let roots = [1.0, -1.0].map(|sign| {
            let raw = self.roots(root, sign);
            let [u, v] = raw.to_array().map(|x| x.clamp(0.0, 1.0));
            let depth = self.depth(u, v);
            // A NaN, which is 0 / 0, is not in the square, and not next to its edge.
            let [u_off, v_off] = raw.to_array().map(|x| (x - 0.5).abs());
            let root = Root { t: self.space.t(depth), u, v };
            let poor = self.too_few_digits(discriminant, depth)
                && !self.is_behind(ray, discriminant, depth);
            (root, u_off.max(v_off), poor)
        });
        let [(first, first_off, first_poor), (second, second_off, second_poor)] = roots;
        let next_to_edge = |off: f64| (off - 0.5).abs() < NEXT_TO_EDGE;
        if first_poor | second_poor | next_to_edge(first_off) | next_to_edge(second_off) {
            return Filtered::Uncertain;
        }
        let found = if self.odd {
            // One of them is in the square: the one nearer to its center.
            [Some(if first_off < second_off { first } else { second }), None]
        } else if (first_off <= 0.5) & (second_off <= 0.5) {
            [Some(first), Some(second)]
        } else {
            // The outline says that both are in the square, or none.
            [None, None]
        };
        nearest(ray, found).into()
    }

    /// Returns the depth of a point of the patch.
    #[inline(always)]
    pub(super) fn depth(&self, u: f64, v: f64) -> f64 {
        let [v0, v1] = self.depths;
        let at_v = v0 + F64x2::splat(v) * (v1 - v0);
        at_v.first() + u * (at_v.second() - at_v.first())
    }

    /// Returns false if one of the parabolas cannot have two roots in `0..=1`; `ends` is `c e`, the
    /// product of its values at 0 and 1.
    #[inline(always)]
    pub(super) fn may_have_two_roots(&self, ends: F64x2) -> bool {
        let zero = F64x2::splat(0.0);
        let comes_back = zero.less(self.c * self.a).and((self.a * self.b()).less(zero));
        let in_between = self.b().abs().less(F64x2::splat(2.0) * self.a.abs());
        zero.less(ends).and(comes_back).and(in_between).all()
    }

    /// Returns whether 53 bits are too few at this root; the module's page derives it. False for a
    /// NaN.
    #[inline(always)]
    pub(super) fn too_few_digits(&self, discriminant: f64, depth: f64) -> bool {
        let terms = self.deepest() * (self.size * self.size);
        let from_far = depth * self.size * self.terms_from_far();
        let least = (TOO_FEW_DIGITS * (terms * terms)).max(TOO_FAR * (from_far * from_far));
        (depth * depth) * discriminant < least
    }

    /// Returns the sum of the four depths, at most `4 h`.
    #[inline(always)]
    fn deepest(&self) -> f64 {
        let depths = self.depths[0].abs() + self.depths[1].abs();
        depths.first() + depths.second()
    }

    /// Returns the terms whose differences are the images, at most `4 k`.
    #[inline(always)]
    fn terms_from_far(&self) -> f64 {
        self.deepest() * self.space.length()
    }

    /// Returns whether this root certainly lies before the interval of the ray, whatever its last
    /// digits are. A ray that leaves the patch has such a root where it left it.
    ///
    /// Seen from a point of the patch the depths are as small as the patch, and the images are
    /// differences that may cancel; so the terms of the differences are counted and not the images.
    /// The second condition on the discriminant ensures that `u` and `v` have certain digits at
    /// all.
    #[inline(always)]
    pub(super) fn is_behind(&self, ray: &Ray, discriminant: f64, depth: f64) -> bool {
        let terms = self.size * (self.size + self.terms_from_far());
        let kept = self.deepest() * terms;
        let least = |bound: f64| bound.max(f64::MIN_POSITIVE);
        // A `t` nearer to zero than this could be rounded to zero.
        (ray.t_min >= 0.0)
            & (self.space.t(depth) < -f64::from(f32::MIN_POSITIVE))
            & ((depth * depth) * discriminant > least(CERTAIN_SIGN * (kept * kept)))
            & (discriminant > least(TOO_FEW_DIGITS * (terms * terms)))
    }
}

/// Returns the first root in the interval of the ray. Roots are compared in `f64`, because two of
/// them may round to the same `f32`.
#[inline(always)]
pub(super) fn nearest(ray: &Ray, [first, second]: [Option<Root>; 2]) -> Option<Root<f32>> {
    let ordered = match (first, second) {
        (Some(first), Some(second)) if second.t < first.t => [Some(second), Some(first)],
        roots => [roots.0, roots.1],
    };
    ordered.into_iter().flatten().find_map(|Root { t, u, v }| {
        let t = ray.accept(t)?;
        Some(Root { t, u, v })
    })
}
