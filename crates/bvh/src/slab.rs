//! The slab test: where a line runs between the planes of a box, conservatively.
//!
//! On each axis the ray is between two planes while `t` is between `n = (near - o) / d` and
//! `f = (far - o) / d`; the box is met where the three intervals and the ray's own have a point in
//! common. An end is computed as `p a + b`, one operation if it is fused, with `a ≈ 1 / d` and `b ≈ -o / d`
//! made once for the ray and moved outwards so that rounding never loses a ray. With `u = 2^-24`:
//!
//! - `a` is `1 / d`, times `1 - 8 u` for a near plane and `1 + 8 u` for a far one. Each has two roundings, so
//!   it is off by `6 u` at least and `10 u` at most.
//! - `b` is `-o a`, minus `4 u |o a|` for a near plane and plus that for a far one. The roundings of the product
//!   and of the sum take `2.1 u |o a|` of it, an unfused `p a` one more, besides `u |(p - o) a|`.
//! - So for ends at `t >= 0` the computed near end is not beyond the true one, and the far end not before it,
//!   with `2 u t` to spare for a `t` of a hit that was rounded to the start of the interval.
//! - For ends at `t < 0` the factors `1 ± 8 u` move them the wrong way, by less than `13 u |t|`. That matters
//!   only if the interval starts at `s < 0`, and then `b` is moved by `16 u |s|` more. (If it does not, a
//!   near end behind the origin is as good as zero, and such a far end means a miss.)
//!
//! In space, a box grows by `4 u |o|`, two units in the last place of the origin, and `8 u` of the distance.
//! Slopes and offsets are finite, so ends are not NaN; where `1 / d` or `o / d` is not, see
//! [`with_parallel_axes`]. Where `p a` overflows, a `t` beyond all numbers becomes infinite, with the right sign.
//!
//! Sources: T. Kay, J. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986; T. Ize, "Robust BVH
//! ray traversal", JCGT 2013, for a bound on the form `(p - o) / d`.

use crate::node::{Node, WIDTH};
use crate::simd::Simd;
use rotund_geometry::Ray;
use rotund_geometry::glam::Vec3;

const U: f32 = rotund_geometry::UNIT_ROUNDOFF;

/// How much farther than `t` the line is followed once there is a hit at `t`: the hit's own `t` is
/// rounded too, and the walk keeps entries with their lowest three bits cut off.
const LIMIT_SLACK: f32 = 32.0 * U;

/// A ray made ready for slab tests.
///
/// Its parameter is `t * scale`, where `scale` is a power of two that brings the longest component
/// of an extreme direction near one; for all usual directions it is one.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    pub(crate) origin: Vec3,
    /// The direction over the scale.
    pub(crate) direction: Vec3,
    /// Of the direction, or what stands for it where it is too large.
    inverse: Vec3,
    /// What is added to the bound of the error of an offset.
    margin: Vec3,
    /// Where the interval starts.
    pub(crate) start: f32,
    /// Where it ends, or a little before.
    pub(crate) end: f32,
    pub(crate) scale: f32,
}

impl SlabRay {
    /// Returns `None` for a ray that can meet nothing: an origin or direction that is not finite,
    /// a zero direction, an empty interval, a NaN.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        let longest = ray.direction.abs().max_element();
        // The maximum of glam may drop a NaN, the sum does not.
        let finite = (ray.origin.is_finite() & ray.direction.is_finite()) && longest > 0.0;
        if !(finite && ray.t_min <= ray.t_max) {
            return None;
        }
        let (direction, scale) = if (1e-12..=1e12).contains(&longest) {
            (ray.direction, 1.0)
        } else {
            brought_near_one(ray.direction, longest)
        };
        let (start, end) = (before(ray.t_min, scale), before(ray.t_max, scale));
        let margin = (-16.0 * U * start).clamp(f32::MIN_POSITIVE, LARGE);
        let inverse = direction.recip();
        let offset = (ray.origin * inverse).abs();
        // Also false for a NaN.
        let (inverse, margin) = if (offset.x < LARGE) & (offset.y < LARGE) & (offset.z < LARGE) {
            (inverse, Vec3::splat(margin))
        } else {
            let farthest = start.abs().max(end.abs());
            with_parallel_axes(ray.origin, direction, farthest, margin)
        };
        Some(Self { origin: ray.origin, direction, inverse, margin, start, end, scale })
    }

    /// How far to follow the line if hits beyond `t` are of no interest.
    #[inline(always)]
    pub(crate) fn limit(&self, t: f32) -> f32 {
        Self::beyond(t * self.scale)
    }

    /// How far to follow the line if a hit is known not to be beyond a parameter.
    #[inline(always)]
    pub(crate) fn beyond(end: f32) -> f32 {
        // A parameter too small for a normal number is rounded absolutely, not relatively.
        end + (LIMIT_SLACK * end.abs()).max(f32::MIN_POSITIVE)
    }

    /// Broadcasts what every node needs.
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

/// The origin over the direction is below this, so that the sum of a few such numbers is finite.
const LARGE: f32 = f32::MAX / 16.0;

/// The inverse of a direction and the margins, of a ray for which `1 / d` or `o / d` is too large on an axis.
///
/// There `|d| < 1 / a` with `a = LARGE / 4 max(|o|, 1)`, so that the ray moves by less than `t / a`. Take `a` in
/// place of `1 / d`, and move the offsets by four times the farthest `t`: this does not confine a ray that
/// is within `t / a` of the space between the planes, and other rays miss. The farthest `t` is taken to be
/// `2^96` at most, by which the boxes grow by less than `2 u max(|o|, 1)`.
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

/// The parameter of `t`, or a little less.
#[inline(always)]
fn before(t: f32, scale: f32) -> f32 {
    let start = t * scale;
    if scale == 1.0 { start } else { start.next_down() }
}

/// The direction over a power of two that brings its longest component near one, and that power.
#[cold]
#[inline(never)]
fn brought_near_one(direction: Vec3, longest: f32) -> (Vec3, f32) {
    // In two steps, since the inverse of a denormal overflows.
    let step = if longest < 1.0 { 2f32.powi(64) } else { 2f32.powi(-64) };
    let (direction, scale) = (direction * step, step.recip());
    if direction.abs().max_element() < 1e-12 {
        (direction * step, scale / step)
    } else {
        (direction, scale)
    }
}

/// A [`SlabRay`] in all lanes.
#[derive(Clone, Copy)]
pub(crate) struct SlabLanes<S: Simd> {
    axes: [Axis<S>; 3],
    start: S::Lanes,
}

/// From the planes across one axis to the parameter: slope and offset for near ends, and for far ones.
#[derive(Clone, Copy)]
struct Axis<S: Simd> {
    near: [S::Lanes; 2],
    far: [S::Lanes; 2],
    /// 1 if the ray goes down the axis and meets the upper plane first, else 0.
    down: usize,
}

impl<S: Simd> Axis<S> {
    #[inline(always)]
    fn new(simd: S, origin: f32, inverse: f32, margin: f32) -> Self {
        let down = usize::from(inverse.is_sign_negative());
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
            down,
        }
    }

    /// Where the ray meets the near and the far planes.
    #[inline(always)]
    fn ends(&self, simd: S, planes: &[[f32; WIDTH]; 2]) -> (S::Lanes, S::Lanes) {
        let near = simd.load(&planes[self.down & 1]);
        let far = simd.load(&planes[self.down & 1 ^ 1]);
        (
            simd.mul_add(near, self.near[0], self.near[1]),
            simd.mul_add(far, self.far[0], self.far[1]),
        )
    }
}

impl<S: Simd> SlabLanes<S> {
    /// Which children the ray meets up to `limit`, and where it enters each.
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
