//! The conservative slab test: the interval in which a line lies between the planes of a box.
//!
//! On each axis the ray is between two planes for `t` from `n = (near - o) / d` to
//! `f = (far - o) / d`. The ray meets the box if these three intervals and its own have a point in
//! common. An end is computed as `p a + b` for a plane `p`, one instruction if it is fused, with
//! `a ≈ 1 / d` and `b ≈ -o / d` computed once for each ray and moved outwards so that rounding
//! never loses a hit. With `u = 2^-24`:
//!
//! - `a` is `1 / d` with one rounding. An end has three more, of the product and the sum that make
//!   it and of its own value, so that it is off by less than `4 u` of itself. Therefore far ends
//!   are moved by `16 u` of themselves: their `a` and `b` have the factor `1 + 16 u`, which costs
//!   another rounding, and no instruction in the test of a node.
//! - `b` is `-o a`, minus `6 u |o a|` for a near plane and plus that for a far one. The roundings
//!   of the product and of the sum use up `2.1 u |o a|` of it, those of an unfused `p a` one more,
//!   and those of the factor of far planes two more.
//! - So for ends at `t >= 0` the computed near end is not after the true far end, and the far end
//!   not before the near one, with a margin of `2 u t` for the `t` of a hit that was rounded to the
//!   start of the interval. A near end may be late by `4 u t`, which the slack of limits covers.
//! - For ends at `t < 0` the factor `1 + 16 u` moves them the wrong way, by less than `22 u |t|`
//!   with their roundings. That matters only if the interval starts at `s < 0`, and then `b` is
//!   moved by another `24 u |s|`. (If it does not, a near end behind the origin counts as zero, and
//!   a far end behind it is a miss.)
//!
//! In space, a box grows by `6 u |o|`, three units in the last place of the origin, and `16 u` of
//! the distance. Slopes and offsets are finite, so ends are not NaN; [`with_parallel_axes`] handles
//! axes for which `1 / d` or `o / d` is not finite. Where `p a` overflows, a `t` beyond all numbers
//! becomes infinite, with the right sign.
//!
//! Sources: T. Kay, J. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986; T. Ize, "Robust BVH
//! ray traversal", JCGT 2013, for a bound on the form `(p - o) / d`.

use crate::node::{Node, WIDTH};
use crate::simd::Simd;
use rotund_geometry::Ray;
use rotund_geometry::glam::{Vec3, Vec4};

const U: f32 = rotund_geometry::UNIT_ROUNDOFF;

/// Relative distance by which traversal continues beyond a hit: the `t` of the hit is rounded too,
/// and stack entries lose the lowest three bits of their distance.
const LIMIT_SLACK: f32 = 32.0 * U;

/// A ray, prepared for slab tests.
///
/// Its parameter is `t * scale`. The scale is a power of two that brings the longest component of
/// an extreme direction near one; for usual directions and coordinates it is one.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// The slope `a` of each axis. Of vectors of four, the last component is not used.
    slope: Vec4,
    /// The offsets `b` of near planes and of far ones.
    near: Vec4,
    far: Vec4,
    /// The origin for the wide tests of leaves, NaN where their `f32` may overflow: then they keep
    /// every lane, and the exact test decides.
    pub(crate) leaf_origin: Vec3,
    /// The direction of the ray divided by the scale.
    pub(crate) direction: Vec3,
    /// Start of the interval.
    pub(crate) start: f32,
    /// End of the interval, or before: minus infinity if the parameters of hits are not certain.
    pub(crate) end: f32,
    pub(crate) scaling: Scaling,
}

/// The parameters of a [`SlabRay`] that belong to a `t`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scaling {
    /// The parameter per `t`.
    pub(crate) scale: f32,
    /// Bound on the parameter of a `t` that is rounded to zero.
    pub(crate) least: f32,
}

impl SlabRay {
    /// Prepares a ray for a tree of this [`range`](crate::node::Tree::range). Returns `None` for
    /// one that cannot hit anything: with an origin or direction that is not finite, a zero
    /// direction, an empty interval, or a NaN.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, range: f32) -> Option<Self> {
        match Self::usual(ray, range) {
            Some(ray) => Some(ray),
            None => {
                let mut unusual = Self::NOTHING;
                if !unusual.set_unusual(ray, range) {
                    return None;
                }
                Some(unusual)
            }
        }
    }

    /// Prepares a ray of usual numbers; returns `None` for any other. On most rays a fifth of the
    /// time of a traversal is spent here, so it works on the three axes at once.
    #[inline(always)]
    fn usual(ray: &Ray, range: f32) -> Option<Self> {
        let (origin, direction) = (ray.origin.extend(0.0), ray.direction.extend(0.0));
        let (mut inverse, size) = (Vec4::ONE / direction, direction.abs());
        let (start, end) = (ray.t_min, ray.t_max);
        // A NaN fails these comparisons.
        let usual = origin.abs().cmple(Vec4::splat(range)) & size.cmple(Vec4::splat(1e12));
        let usual = usual.bitmask() & AXES == AXES && !size.cmplt(Vec4::splat(1e-12)).all();
        if !(usual & (start <= end)) {
            return None;
        }
        let mut margin = Vec4::splat(margin(start));
        let not_parallel = (origin * inverse).abs().cmple(Vec4::splat(LARGE));
        if not_parallel.bitmask() & AXES != AXES {
            let farthest = start.abs().max(end.abs());
            (inverse, margin) = with_parallel_axes(origin, direction, farthest, margin);
        }
        let [near, far] = offsets(origin, inverse, margin);
        let (leaf_origin, direction) = (ray.origin, ray.direction);
        let (slope, scaling) = (inverse, Scaling::USUAL);
        Some(Self { slope, near, far, leaf_origin, direction, start, end, scaling })
    }

    /// A ray that is still to be prepared.
    const NOTHING: Self = Self {
        slope: Vec4::ZERO,
        near: Vec4::ZERO,
        far: Vec4::ZERO,
        leaf_origin: Vec3::NAN,
        direction: Vec3::ZERO,
        start: 0.0,
        end: 0.0,
        scaling: Scaling::USUAL,
    };

    /// Prepares a ray that is extreme in some way. Returns false for one that hits nothing.
    ///
    /// It writes to a given place, because a result that is returned in memory would keep the usual
    /// one in memory too, instead of in registers.
    #[cold]
    #[inline(never)]
    fn set_unusual(&mut self, ray: &Ray, range: f32) -> bool {
        let longest = ray.direction.abs().max_element();
        // `max_element` may ignore a NaN, so finiteness is tested too.
        let finite = ray.origin.is_finite() && ray.direction.is_finite() && longest > 0.0;
        if !(finite && ray.t_min <= ray.t_max) {
            return false;
        }
        let in_range = ray.origin.abs().max_element() <= range;
        let (direction, scale) = scaled(ray.direction, longest, in_range);
        // Many parameters belong to a `t` of zero, or to none if it overflows: the exact test of
        // each primitive decides.
        let least = f32::MIN_POSITIVE * scale.max(1.0);
        let (start, end) = ((ray.t_min * scale).next_down() - least, f32::NEG_INFINITY);
        let (origin, direction4) = (ray.origin.extend(0.0), direction.extend(0.0));
        let (inverse, margin) =
            with_parallel_axes(origin, direction4, f32::INFINITY, Vec4::splat(margin(start)));
        let [near, far] = offsets(origin, inverse, margin);
        let leaf_origin = if in_range { ray.origin } else { Vec3::NAN };
        let slope = inverse;
        let scaling = Scaling { scale, least };
        *self = Self { slope, near, far, leaf_origin, direction, start, end, scaling };
        true
    }

    /// Broadcasts the slopes and offsets of all planes.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S) -> SlabLanes<S> {
        let far_slope = self.slope * OUTWARDS;
        SlabLanes {
            axes: [
                Axis::new(simd, self, far_slope, 0),
                Axis::new(simd, self, far_slope, 1),
                Axis::new(simd, self, far_slope, 2),
            ],
            start: simd.splat(self.start),
        }
    }
}

impl Scaling {
    /// That of directions and coordinates that are not extreme.
    pub(crate) const USUAL: Self = Self { scale: 1.0, least: f32::MIN_POSITIVE };

    /// The parameter at which traversal may stop if hits beyond `t` are not needed.
    #[inline(always)]
    pub(crate) fn limit(&self, t: f32) -> f32 {
        // The rounding error of a subnormal `t` is absolute, not relative.
        let end = t * self.scale;
        end + (LIMIT_SLACK * end.abs()).max(self.least)
    }

    /// The parameter at which traversal may stop if there is a hit at the parameter `end` or
    /// before.
    #[inline(always)]
    pub(crate) fn beyond(end: f32) -> f32 {
        // The rounding error of a subnormal parameter is absolute, not relative.
        end + (LIMIT_SLACK * end.abs()).max(f32::MIN_POSITIVE)
    }
}

/// The factor that moves far ends outwards.
const OUTWARDS: f32 = 1.0 + 16.0 * U;

/// The mask of the three axes.
const AXES: u32 = 0b111;

/// Absolute part of the error bound of an offset `b`, for an interval that starts at `start`.
#[inline(always)]
fn margin(start: f32) -> f32 {
    (-24.0 * U * start).clamp(f32::MIN_POSITIVE, LARGE)
}

/// The offsets of near planes and of far planes.
#[inline(always)]
fn offsets(origin: Vec4, inverse: Vec4, margin: Vec4) -> [Vec4; 2] {
    let from = origin * inverse;
    let error = from.abs() * (6.0 * U) + margin;
    [-(from + error), (error - from) * OUTWARDS]
}

/// Bound on `|o / d|` on each axis, so that the sum of a few such numbers is finite.
const LARGE: f32 = f32::MAX / 16.0;

/// The inverse direction and the margins of a ray for which `1 / d` or `o / d` is too large on an
/// axis.
///
/// On such an axis `|d| < 1 / a` with `a = LARGE / 4 max(|o|, 1)`, so the ray moves by less than
/// `t / a`. The slope `a` replaces `1 / d`, and the offsets move by four times the farthest `t`.
/// Then the axis does not restrict a ray within `t / a` of the space between the planes, and other
/// rays miss. The farthest `t` is clamped to `2^96`, by which the boxes grow by less than
/// `2 u max(|o|, 1)`.
#[cold]
#[inline(never)]
fn with_parallel_axes(origin: Vec4, direction: Vec4, farthest: f32, margin: Vec4) -> (Vec4, Vec4) {
    let farthest = 4.0 * farthest.min(2f32.powi(96));
    let (mut inverses, mut margins) = (direction.recip(), margin);
    for i in 0..3 {
        if (origin[i] * inverses[i]).abs() <= LARGE {
            continue;
        }
        let steep = 0.25 * LARGE / origin[i].abs().max(1.0);
        inverses[i] = steep.copysign(direction[i]);
        margins[i] += farthest;
    }
    (inverses, margins)
}

/// The direction divided by a power of two, and that power.
///
/// The longest component becomes one or, for coordinates beyond [`RANGE`](crate::node::RANGE),
/// `2^100`: then the parameters of all points are below `2^29`. As the power must be a number, tiny
/// directions stay below; their rays do not get that far.
#[cold]
#[inline(never)]
fn scaled(direction: Vec3, longest: f32, in_range: bool) -> (Vec3, f32) {
    let target = if in_range { 0.0 } else { 100.0 };
    let exponent = (target - f64::from(longest).log2().floor()).clamp(-126.0, 126.0) as f32;
    (direction * exponent.exp2(), (-exponent).exp2())
}

/// A [`SlabRay`], broadcast to all lanes.
#[derive(Clone, Copy)]
pub(crate) struct SlabLanes<S: Simd> {
    axes: [Axis<S>; 3],
    start: S::Lanes,
}

/// The map from the planes across one axis to parameters.
#[derive(Clone, Copy)]
struct Axis<S: Simd> {
    slope: S::Lanes,
    far_slope: S::Lanes,
    near: S::Lanes,
    far: S::Lanes,
    /// 1 if the direction is negative, so that the upper plane is the near one, else 0.
    negative: usize,
}

impl<S: Simd> Axis<S> {
    #[inline(always)]
    fn new(simd: S, ray: &SlabRay, far_slope: Vec4, axis: usize) -> Self {
        Self {
            slope: simd.splat(ray.slope[axis]),
            far_slope: simd.splat(far_slope[axis]),
            near: simd.splat(ray.near[axis]),
            far: simd.splat(ray.far[axis]),
            negative: usize::from(ray.slope[axis].is_sign_negative()),
        }
    }

    /// The parameters at which the ray meets the near and the far planes.
    #[inline(always)]
    fn ends(&self, simd: S, planes: &[[f32; WIDTH]; 2]) -> (S::Lanes, S::Lanes) {
        let near = simd.load(&planes[self.negative & 1]);
        let far = simd.load(&planes[self.negative & 1 ^ 1]);
        (simd.mul_add(near, self.slope, self.near), simd.mul_add(far, self.far_slope, self.far))
    }
}

impl<S: Simd> SlabLanes<S> {
    /// Returns the parameters at which the ray enters the boxes of the children, and the mask of
    /// those it meets before `limit`.
    #[inline(always)]
    pub(crate) fn test(&self, simd: S, node: &Node, limit: S::Lanes) -> (S::Lanes, u32) {
        // Their cache line is read once the mask is known, and is fetched along with the planes.
        simd.prefetch(&node.children);
        let [x, y, z] = &self.axes;
        let (near_x, far_x) = x.ends(simd, &node.planes[0]);
        let (near_y, far_y) = y.ends(simd, &node.planes[1]);
        let (near_z, far_z) = z.ends(simd, &node.planes[2]);
        // In pairs: the latency from one node to its child is most of the time of a traversal.
        let near = simd.max(simd.max(near_x, near_y), simd.max(near_z, self.start));
        let far = simd.min(simd.min(far_x, far_y), simd.min(far_z, limit));
        (near, simd.mask_le(near, far))
    }
}
