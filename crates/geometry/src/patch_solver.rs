//! Where a ray meets a bilinear patch.
//!
//! # Derivation
//!
//! Seen along the ray (`ray_space.rs`), the patch is a map `P` of the unit square to the plane, and the ray
//! is the origin. The origin lies on the line through `P(u, 0)` and `P(u, 1)`, or on that through `P(0, v)`
//! and `P(1, v)`, if
//!
//! ```text
//! f(u) = P(u,0) × P(u,1) = c + b u + a u² = 0    c = p00 × p01   e = p10 × p11   a = (p10-p00) × (p11-p01)
//! g(v) = P(0,v) × P(1,v) = c'+ b'v + a'v² = 0    c'= p00 × p10   e'= p01 × p11   a'= (p01-p00) × (p11-p10)
//! ```
//!
//! so `c`, `e = a + b + c`, `c'` and `e'` are the areas of the four edges. With `P_u`, `P_v` the derivatives,
//! `f = P × P_v` and `g = P × P_u`: where `P = 0` the slopes are `f' = P_u × P_v = -g'`. So both parabolas have
//! the same discriminant `D`, a root of `f` of slope `σ √D` goes with the root of `g` of slope `-σ √D`, and one
//! square root gives both parameters, side by side.
//!
//! # Watertight edges
//!
//! No rounded root can decide whether it lies on this or that side of an edge so that the neighbour,
//! whose corners come in another order, decides the opposite. The outline does: the number of times it
//! winds around the ray has the parity of the number of roots in the square, which is 0, 1 or 2. Whether
//! an edge counts depends on its two vertices alone. Hence: odd means exactly one root, clamped to the
//! square; even means two or none.
//!
//! # The common hit
//!
//! The outline is odd and one parabola, say `f`, has its ends on two sides of zero: it passes once, in the
//! direction that tells `σ`, and `D = (c + e - a)² - 4 c e` is a sum of what is not negative: no digit of it
//! cancels.
//!
//! # Too few digits
//!
//! `√D` is also the area that a unit of the square has in the image. With images of size `s`, an `f64` knows
//! the parabolas to some `2⁻⁵³ s²`, hence `u` and `v` to `2⁻⁵³ s² / √D`, and a depth, of corners as deep as `h`,
//! to `h` times that. If this is no small part of a unit of `t`, which happens at folds, along a ruling, and
//! next to the origin of the ray, `careful_patch.rs` solves with 106 bits.
//!
//! Sources: S. D. Ramsey, K. Potter, C. Hansen, "Ray Bilinear Patch Intersections", journal of graphics
//! tools 9(3), 2004, for the quadratic in the plane; A. Reshetov, "Cool Patches", Ray Tracing Gems,
//! chapter 8, 2019, for the choice of `a, b, c` and for the stable roots.

#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::pair::Pair;
use crate::queries::Common;
use crate::ray_space::RaySpace;
use crate::{BilinearPatch, Ray, careful_patch};

/// A crossing, of `T` as it is computed or as it is reported.
pub(crate) struct Root<T = f64> {
    pub(crate) t: T,
    pub(crate) u: f64,
    pub(crate) v: f64,
}

/// The patch as the ray sees it.
#[derive(Clone, Copy)]
struct View {
    space: RaySpace,
    /// Whether the outline winds around the ray an odd number of times.
    odd: bool,
    /// The areas at the ends of `f` and `g`.
    c: Pair,
    e: Pair,
    a: Pair,
    /// The depths of the corners at `u = 0, 1`, for `v = 0` and for `v = 1`.
    depths: [Pair; 2],
    /// A bound on the coordinates of the images.
    size: f64,
}

/// The square of `2⁻²²`, the share of their terms at which `2⁻⁵³` of these are `2⁻³¹` of what is left: an
/// `f32` has 24 bits, so the rounding of the `f64` arithmetic is some hundredth of its own.
const TOO_FEW_DIGITS: f64 = 1.0 / 17_592_186_044_416.0;

/// Roots nearer than this to an edge are in the square or not for 106 bits to tell.
///
/// With the digits that are not too few, an `f64` is wrong by `2⁻³¹`; a distance of a thousand sizes costs
/// ten bits of that.
const NEXT_TO_EDGE: f64 = 1.0 / 1_048_576.0;

/// The first crossing of the surface in the interval of the ray.
#[inline(always)]
pub(crate) fn solve(patch: &BilinearPatch, ray: &Ray) -> Common<Root<f32>> {
    let Some(view) = View::new(patch, ray) else { return Common::Miss };
    let ends = view.c * view.e;
    let passes = ends.less(Pair::splat(0.0));
    if !(view.odd & passes.any()) {
        return if view.odd {
            Common::Unsure
        } else if view.may_come_back(ends) {
            // A copy, so that the rest need not be in memory for its sake.
            solve_folded(view, ray)
        } else {
            Common::Miss
        };
    }
    let k = (view.c + view.e) - view.a;
    let discriminants = k * k - Pair::splat(4.0) * ends;
    // Of the parabola that passes.
    let (discriminant, sign) = if passes.bits() & 1 != 0 {
        (discriminants.first(), view.e.first())
    } else {
        (discriminants.second(), -view.e.second())
    };
    let uv = view.roots(discriminant.sqrt(), sign);
    let uv = uv.max(Pair::splat(0.0)).min(Pair::splat(1.0));
    let [u, v] = uv.to_array();
    let depth = view.depth(u, v);
    // Of corners that are not finite the discriminant is infinite or NaN.
    if view.too_few_digits(discriminant, depth) | !discriminant.is_finite() {
        let behind = view.is_behind(ray, discriminant, depth);
        return if behind { Common::Miss } else { Common::Unsure };
    }
    ray.accept(view.space.t(depth)).map(|t| Root { t, u, v }).into()
}

/// The first of two crossings, if there are any. For corners that are not finite there is no such ray:
/// [`View::may_come_back`] is false, because infinities do not compare.
#[cold]
#[inline(never)]
fn solve_folded(view: View, ray: &Ray) -> Common<Root<f32>> {
    view.solve_both(ray)
}

/// The same for every ray: also one that meets the patch twice, or once near a fold or a corner, and one
/// for which 53 bits are too few.
pub(crate) fn solve_carefully(patch: &BilinearPatch, ray: &Ray) -> Option<Root<f32>> {
    let corners = [patch.p00, patch.p10, patch.p01, patch.p11];
    if !corners.iter().all(|p| p.is_finite()) {
        return None;
    }
    let view = View::new(patch, ray)?;
    match view.solve_both(ray) {
        Common::Miss => None,
        Common::Root(root) => Some(root),
        Common::Unsure => {
            nearest(ray, careful_patch::solve(patch, ray, view.space.axes(), view.odd))
        }
    }
}

impl View {
    /// `None` if the ray passes by the box about the images.
    #[inline(always)]
    fn new(patch: &BilinearPatch, ray: &Ray) -> Option<Self> {
        let space = RaySpace::new(ray);
        // Of `v = 0` and `v = 1`; in each the vertices of `u = 0` and `u = 1`.
        let v0 = space.project(&patch.p00, &patch.p10);
        let v1 = space.project(&patch.p01, &patch.p11);
        let zero = Pair::splat(0.0);
        let (x_min, x_max) = (v0.x.min(v1.x), v0.x.max(v1.x));
        let (y_min, y_max) = (v0.y.min(v1.y), v0.y.max(v1.y));
        // Of x, and of y.
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
    fn b(&self) -> Pair {
        (self.e - self.c) - self.a
    }

    /// `u` and `v` where `f` has the slope `root` times the sign of `sign`, and `g` the opposite one.
    ///
    /// The root of slope `s` is `(s - b) / 2a`, or `-2c / (s + b)`: whichever sum does not cancel.
    #[inline(always)]
    fn roots(&self, root: f64, sign: f64) -> Pair {
        let (b, signs) = (self.b(), Pair::new(sign, -sign));
        let sum = (Pair::splat(root) + b.abs()).times_sign_of(signs);
        let unlike = (b * signs).less(Pair::splat(0.0));
        let over = unlike.select(sum, Pair::splat(-2.0) * self.c);
        let under = unlike.select(self.a + self.a, sum);
        over / under
    }

    /// The first crossing, of both that the whole surface has.
    #[inline(always)]
    fn solve_both(&self, ray: &Ray) -> Common<Root<f32>> {
        let (a, b, c) = (self.a, self.b(), self.c);
        // The same twice: of the two, the one with the smaller terms is the better one.
        let discriminants = b * b - Pair::splat(4.0) * a * c;
        let smaller = b.first().abs() <= b.second().abs();
        let discriminant = if smaller { discriminants.first() } else { discriminants.second() };
        let square = self.size * self.size;
        if !self.odd && discriminant < -TOO_FEW_DIGITS * (square * square) {
            return Common::Miss;
        }
        let root = discriminant.max(0.0).sqrt();
        let roots = [1.0, -1.0].map(|sign| {
            let raw = self.roots(root, sign);
            let [u, v] = raw.to_array().map(|x| x.clamp(0.0, 1.0));
            let depth = self.depth(u, v);
            // A NaN, of 0 / 0, is not in the square, and not next to its edge.
            let [u_off, v_off] = raw.to_array().map(|x| (x - 0.5).abs());
            let root = Root { t: self.space.t(depth), u, v };
            let poor = self.too_few_digits(discriminant, depth)
                && !self.is_behind(ray, discriminant, depth);
            (root, u_off.max(v_off), poor)
        });
        let [(first, first_off, first_poor), (second, second_off, second_poor)] = roots;
        let next_to_edge = |off: f64| (off - 0.5).abs() < NEXT_TO_EDGE;
        if first_poor | second_poor | next_to_edge(first_off) | next_to_edge(second_off) {
            return Common::Unsure;
        }
        let found = if self.odd {
            // One of them is in the square: the one nearer to its centre.
            [Some(if first_off < second_off { first } else { second }), None]
        } else if (first_off <= 0.5) & (second_off <= 0.5) {
            [Some(first), Some(second)]
        } else {
            // The outline says that both are in the square, or none.
            [None, None]
        };
        nearest(ray, found).into()
    }

    /// The depth of a point of the patch.
    #[inline(always)]
    fn depth(&self, u: f64, v: f64) -> f64 {
        let [v0, v1] = self.depths;
        let at_v = v0 + Pair::splat(v) * (v1 - v0);
        at_v.first() + u * (at_v.second() - at_v.first())
    }

    /// False if one of the parabolas cannot have two roots in the square; `ends` is the product of its
    /// ends.
    #[inline(always)]
    fn may_come_back(&self, ends: Pair) -> bool {
        let zero = Pair::splat(0.0);
        let comes_back = zero.less(self.c * self.a).and((self.a * self.b()).less(zero));
        let in_between = self.b().abs().less(Pair::splat(2.0) * self.a.abs());
        zero.less(ends).and(comes_back).and(in_between).all()
    }

    /// True if 53 bits are too few at this root, see above. False for a NaN.
    #[inline(always)]
    fn too_few_digits(&self, discriminant: f64, depth: f64) -> bool {
        let depths = self.depths[0].abs() + self.depths[1].abs();
        let terms = (depths.first() + depths.second()) * (self.size * self.size);
        (depth * depth) * discriminant < TOO_FEW_DIGITS * (terms * terms)
    }

    /// True if this root is before the interval of the ray for certain, whatever its last digits are: where a
    /// ray that leaves the patch left it.
    ///
    /// Seen from a patch the depths are its size and the images may cancel in the differences that they
    /// are, so the terms are counted, not the images. The second condition says that `u` and `v` are known at all.
    #[inline(always)]
    fn is_behind(&self, ray: &Ray, discriminant: f64, depth: f64) -> bool {
        let depths = self.depths[0].abs() + self.depths[1].abs();
        let deepest = depths.first() + depths.second();
        let terms = self.size * (self.size + deepest * self.space.length());
        let kept = deepest * terms;
        let least = |bound: f64| bound.max(f64::MIN_POSITIVE);
        // Not by so little that it could be rounded to zero.
        (ray.t_min >= 0.0)
            & (self.space.t(depth) < -f64::from(f32::MIN_POSITIVE))
            & ((depth * depth) * discriminant > least(CERTAIN_SIGN * (kept * kept)))
            & (discriminant > least(TOO_FEW_DIGITS * (terms * terms)))
    }
}

/// `2⁻⁸⁸`, of which the root is the share of its terms that a depth keeps when its sign is certain: `2⁻⁵³` of
/// them is one rounding, and there are fewer than a hundred.
const CERTAIN_SIGN: f64 = 1.0 / 309_485_009_821_345_068_724_781_056.0;

/// The first root in the interval of the ray. Two may round to the same `t`: the nearer one is nearer
/// before that.
#[inline(always)]
fn nearest(ray: &Ray, [first, second]: [Option<Root>; 2]) -> Option<Root<f32>> {
    let ordered = match (first, second) {
        (Some(first), Some(second)) if second.t < first.t => [Some(second), Some(first)],
        roots => [roots.0, roots.1],
    };
    ordered.into_iter().flatten().find_map(|Root { t, u, v }| {
        let t = ray.accept(t)?;
        Some(Root { t, u, v })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_rays::{Random, aimed, spawned};
    use glam::Vec3;

    #[test]
    fn rays_that_are_told_to_leave_a_patch_meet_it_behind_in_106_bits() {
        let mut random = Random(0x2545_F491_4F6C_DD1D);
        let (mut behind, mut count) = (0, 0);
        while count < 200_000 {
            let size = random.power(3.0);
            let center = random.point() * random.power(3.0);
            let twist = 0.3 * random.power(1.0);
            let mut corner =
                |x: f32, y: f32| center + size * (Vec3::new(x, y, 0.0) + twist * random.point());
            let [p00, p10] = [corner(-1.0, -1.0), corner(1.0, -1.0)];
            let [p01, p11] = [corner(-1.0, 1.0), corner(1.0, 1.0)];
            let patch = BilinearPatch { p00, p10, p01, p11 };
            let Some(hit) = patch.closest(&aimed(&mut random, center, size)) else { continue };
            count += 1;
            let ray = spawned(&mut random, &hit);
            let Some(view) = View::new(&patch, &ray) else { continue };
            let missed = match solve(&patch, &ray) {
                Common::Miss => true,
                Common::Root(_) => false,
                Common::Unsure => solve_carefully(&patch, &ray).is_none(),
            };
            let exact = careful_patch::solve(&patch, &ray, view.space.axes(), view.odd);
            let found = nearest(&ray, exact);
            assert_eq!(missed, found.is_none(), "{patch:?} {ray:?}");
            behind += u32::from(missed && view.odd);
        }
        assert!(behind > 100_000, "{behind}");
    }
}
