//! The conservative slab test: the interval in which a line lies between the planes of a box.
//!
//! On each axis the ray is between two planes for `t` from `n = (near - o) / d` to
//! `f = (far - o) / d`. The ray meets the box if these three intervals and its own have a point in
//! common. An end is computed as `p a + b` for a plane `p`, one instruction if it is fused, with
//! `a ≈ 1 / d` and `b ≈ -o / d` computed once for each ray and moved outwards so that rounding
//! never loses a hit. With `u = 2^-24`:
//!
//! - `a` is `1 / d`, times `1 - 8 u` for a near plane and `1 + 8 u` for a far one. Each has two
//!   roundings, so it differs from `1 / d` by at least `6 u` and at most `10 u`.
//! - `b` is `-o a`, minus `4 u |o a|` for a near plane and plus that for a far one. The roundings
//!   of the product and of the sum use up `2.1 u |o a|` of it and those of an unfused `p a` one
//!   more, besides `u |(p - o) a|`.
//! - So for ends at `t >= 0` the computed near end is not after the true one, and the far end not
//!   before it, with a margin of `2 u t` for the `t` of a hit that was rounded to the start of the
//!   interval.
//! - For ends at `t < 0` the factors `1 ± 8 u` move them the wrong way, by less than `13 u |t|`.
//!   That matters only if the interval starts at `s < 0`, and then `b` is moved by another
//!   `16 u |s|`. (If it does not, a near end behind the origin counts as zero, and a far end behind
//!   it is a miss.)
//!
//! In space, a box grows by `4 u |o|`, two units in the last place of the origin, and `8 u` of the
//! distance. Slopes and offsets are finite, so ends are not NaN; [`with_parallel_axes`] handles
//! axes for which `1 / d` or `o / d` is not finite. Where `p a` overflows, a `t` beyond all numbers
//! becomes infinite, with the right sign.
//!
//! Sources: T. Kay, J. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986; T. Ize, "Robust BVH
//! ray traversal", JCGT 2013, for a bound on the form `(p - o) / d`.

use crate::node::{Node, RANGE, WIDTH};
use crate::simd::Simd;
use rotund_geometry::Ray;
use rotund_geometry::glam::Vec3;

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
    origin: Vec3,
    /// The origin for the wide tests of leaves, NaN where their `f32` may overflow: then they keep
    /// every lane, and the exact test decides.
    pub(crate) leaf_origin: Vec3,
    /// The direction of the ray divided by the scale.
    pub(crate) direction: Vec3,
    /// `1 / d`, or the replacement by [`with_parallel_axes`] where that is too large.
    inverse: Vec3,
    /// Absolute part of the error bound of an offset `b`.
    margin: Vec3,
    /// Start of the interval.
    pub(crate) start: f32,
    /// End of the interval, or before: minus infinity if the parameters of hits are not certain.
    pub(crate) end: f32,
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
        Self::within(ray, range).or_else(|| Self::beyond_range(ray))
    }

    /// Prepares a ray whose origin may be out of range.
    #[cold]
    #[inline(never)]
    fn beyond_range(ray: &Ray) -> Option<Self> {
        Some(Self { leaf_origin: Vec3::NAN, ..Self::within(ray, f32::MAX)? })
    }

    /// Prepares a ray whose origin is in this range; of any other it returns `None`.
    #[inline(always)]
    fn within(ray: &Ray, range: f32) -> Option<Self> {
        let longest = ray.direction.abs().max_element();
        // `max_element` may ignore a NaN, so finiteness is tested too.
        let in_range = ray.origin.abs().cmple(Vec3::splat(range)).all();
        let finite = (in_range & ray.direction.is_finite()) && longest > 0.0;
        if !(finite && ray.t_min <= ray.t_max) {
            return None;
        }
        let (mut direction, mut scale, mut least) = (ray.direction, 1.0, f32::MIN_POSITIVE);
        let (mut start, mut end) = (ray.t_min, ray.t_max);
        if !((1e-12..=1e12).contains(&longest) && range <= RANGE) {
            (direction, scale) = scaled(ray.direction, longest, range);
            // Many parameters belong to a `t` of zero, or to none if it overflows: the exact test
            // of each primitive decides.
            least *= scale.max(1.0);
            (start, end) = ((start * scale).next_down() - least, f32::NEG_INFINITY);
        }
        let margin = (-16.0 * U * start).clamp(f32::MIN_POSITIVE, LARGE);
        let inverse = direction.recip();
        let offset = (ray.origin * inverse).abs();
        // A NaN fails these comparisons.
        let (inverse, margin) = if (offset.x < LARGE) & (offset.y < LARGE) & (offset.z < LARGE) {
            (inverse, Vec3::splat(margin))
        } else {
            let farthest = start.abs().max(end.abs());
            with_parallel_axes(ray.origin, direction, farthest, margin)
        };
        let origin = ray.origin;
        let leaf_origin = origin;
        Some(Self { origin, leaf_origin, direction, inverse, margin, start, end, scale, least })
    }

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

    /// Broadcasts the slopes and offsets of all planes.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S) -> SlabLanes<S> {
        let (o, inverse, margin) = (self.origin, self.inverse, self.margin);
        SlabLanes {
            axes: [
                Axis::new(simd, o.x, inverse.x, margin.x),
                Axis::new(simd, o.y, inverse.y, margin.y),
                Axis::new(simd, o.z, inverse.z, margin.z),
            ],
            start: simd.splat(self.start),
        }
    }
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
fn with_parallel_axes(origin: Vec3, direction: Vec3, farthest: f32, margin: f32) -> (Vec3, Vec3) {
    let farthest = 4.0 * farthest.min(2f32.powi(96));
    let (mut inverses, mut margins) = (direction.recip(), Vec3::splat(margin));
    for i in 0..3 {
        if (origin[i] * inverses[i]).abs() < LARGE {
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
/// The longest component becomes one or, for coordinates beyond [`RANGE`], `2^100`: then the
/// parameters of all points are below `2^29`. As the power must be a number, tiny directions stay
/// below; their rays do not get that far.
#[cold]
#[inline(never)]
fn scaled(direction: Vec3, longest: f32, range: f32) -> (Vec3, f32) {
    let target = if range <= RANGE { 0.0 } else { 100.0 };
    let exponent = (target - f64::from(longest).log2().floor()).clamp(-126.0, 126.0) as f32;
    (direction * exponent.exp2(), (-exponent).exp2())
}

/// A [`SlabRay`], broadcast to all lanes.
#[derive(Clone, Copy)]
pub(crate) struct SlabLanes<S: Simd> {
    axes: [Axis<S>; 3],
    start: S::Lanes,
}

/// The map from the planes across one axis to parameters: slope and offset for near planes and for
/// far ones.
#[derive(Clone, Copy)]
struct Axis<S: Simd> {
    near: [S::Lanes; 2],
    far: [S::Lanes; 2],
    /// 1 if the direction is negative, so that the upper plane is the near one, else 0.
    negative: usize,
}

impl<S: Simd> Axis<S> {
    #[inline(always)]
    fn new(simd: S, origin: f32, inverse: f32, margin: f32) -> Self {
        let negative = usize::from(inverse.is_sign_negative());
        let (origin, inverse, margin) =
            (simd.splat(origin), simd.splat(inverse), simd.splat(margin));
        let near = simd.mul(inverse, simd.splat(1.0 - 8.0 * U));
        let far = simd.mul(inverse, simd.splat(1.0 + 8.0 * U));
        let (from_near, from_far) = (simd.mul(origin, near), simd.mul(origin, far));
        let error = simd.splat(4.0 * U);
        let near_error = simd.mul_add(simd.abs(from_near), error, margin);
        let far_error = simd.mul_add(simd.abs(from_far), error, margin);
        let zero = simd.splat(0.0);
        Self {
            near: [near, simd.sub(zero, simd.add(from_near, near_error))],
            far: [far, simd.sub(far_error, from_far)],
            negative,
        }
    }

    /// The parameters at which the ray meets the near and the far planes.
    #[inline(always)]
    fn ends(&self, simd: S, planes: &[[f32; WIDTH]; 2]) -> (S::Lanes, S::Lanes) {
        let near = simd.load(&planes[self.negative & 1]);
        let far = simd.load(&planes[self.negative & 1 ^ 1]);
        (
            simd.mul_add(near, self.near[0], self.near[1]),
            simd.mul_add(far, self.far[0], self.far[1]),
        )
    }
}

impl<S: Simd> SlabLanes<S> {
    /// Returns the parameters at which the ray enters the boxes of the children, and the mask of
    /// those it meets before `limit`.
    #[inline(always)]
    pub(crate) fn test(&self, simd: S, node: &Node, limit: S::Lanes) -> (S::Lanes, u32) {
        let [x, y, z] = &self.axes;
        let (near_x, far_x) = x.ends(simd, &node.planes[0]);
        let (near_y, far_y) = y.ends(simd, &node.planes[1]);
        let (near_z, far_z) = z.ends(simd, &node.planes[2]);
        let near = simd.max(simd.max(near_x, near_y), simd.max(near_z, self.start));
        let far = simd.min(simd.min(far_x, far_y), simd.min(far_z, limit));
        (near, simd.mask_le(near, far))
    }
}
