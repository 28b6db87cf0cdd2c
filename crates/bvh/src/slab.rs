//! The slab test: where a line runs between the planes of a box, conservatively.
//!
//! On each axis the ray is between the two planes while `t` is between
//! `n = (near - o) / d` and `f = (far - o) / d`; the box is met where the three intervals and the
//! ray's own have a point in common, `max n <= min f`. Computed as `fl(fl(p - o) * fl(1 / d))`, an
//! end carries three roundings, a relative error below `3.01 u` with `u = 2^-24`. So
//! `max n <= min f` for the exact ends implies `n <= f + 8 u |f|` for the computed ones, which is
//! the test here: it accepts a little more than the box and never loses a ray that meets it. A term
//! `fma(p, 1/d, -o/d)` would save an operation, but its error grows with the distance of the box
//! from zero and not only from the ray.
//!
//! A direction component of zero gives `1/d` infinite, and the ends are infinite too, with the
//! right signs, or NaN (`0 * inf`) if the origin lies in the plane. A NaN is dropped by the order
//! of operands of `min` and `max`: that plane does not confine the ray, so boxes are closed.
//!
//! Sources: T. Kay, J. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986; T. Ize, "Robust BVH
//! ray traversal", JCGT 2013 (whose bound this is); for the NaN, A. Williams et al., "An efficient
//! and robust ray-box intersection algorithm", 2005.

use crate::node::Node;
use crate::simd::Simd;
use rotund_geometry::Ray;
use rotund_geometry::glam::Vec3;

/// Relative error allowed between the ends of an interval: `8 u`, derived above.
const SLACK: f32 = 8.0 * rotund_geometry::UNIT_ROUNDOFF;

/// How much farther than `t` the line is followed once there is a hit at `t`: the hit's own `t` is
/// rounded too, and the walk keeps entries with their lowest three bits cut off.
const LIMIT_SLACK: f32 = 4.0 * SLACK;

/// A ray made ready for slab tests.
///
/// Its parameter is `t * scale`, where `scale` is a power of two that brings the longest component
/// of an extreme direction near one; for all usual directions it is one.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    pub(crate) origin: Vec3,
    /// The direction over the scale.
    pub(crate) direction: Vec3,
    inverse: [f32; 3],
    /// Rows of [`Node::planes`] that the ray meets first, per axis; the last is the other of the
    /// pair.
    near: [usize; 3],
    /// Where the interval starts.
    pub(crate) start: f32,
    /// Where it ends, or a little before.
    pub(crate) end: f32,
    pub(crate) scale: f32,
}

impl SlabRay {
    /// Returns `None` for a ray that can meet nothing: an origin or direction that is not finite,
    /// a zero direction, an empty interval, a NaN.
    #[inline]
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
            // In two steps, since the inverse of a denormal overflows.
            let step = if longest < 1.0 { 2f32.powi(64) } else { 2f32.powi(-64) };
            let (direction, scale) = (ray.direction * step, step.recip());
            if direction.abs().max_element() < 1e-12 {
                (direction * step, scale / step)
            } else {
                (direction, scale)
            }
        };
        let inverse = direction.recip();
        let scaled = Self {
            origin: ray.origin,
            direction,
            inverse: inverse.to_array(),
            near: [0, 1, 2].map(|axis| 2 * axis + usize::from(direction[axis].is_sign_negative())),
            start: 0.0,
            end: 0.0,
            scale,
        };
        Some(Self { start: scaled.before(ray.t_min), end: scaled.before(ray.t_max), ..scaled })
    }

    /// The parameter of `t`, or a little less.
    #[inline(always)]
    fn before(&self, t: f32) -> f32 {
        let start = t * self.scale;
        if self.scale == 1.0 { start } else { start.next_down() }
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
        SlabLanes {
            origin: [
                simd.splat(self.origin.x),
                simd.splat(self.origin.y),
                simd.splat(self.origin.z),
            ],
            inverse: [
                simd.splat(self.inverse[0]),
                simd.splat(self.inverse[1]),
                simd.splat(self.inverse[2]),
            ],
            near: self.near,
            start: simd.splat(self.start),
            slack: simd.splat(SLACK),
        }
    }
}

/// A [`SlabRay`] in all lanes.
#[derive(Clone, Copy)]
pub(crate) struct SlabLanes<S: Simd> {
    origin: [S::Lanes; 3],
    inverse: [S::Lanes; 3],
    near: [usize; 3],
    start: S::Lanes,
    slack: S::Lanes,
}

impl<S: Simd> SlabLanes<S> {
    /// Where the ray meets the planes of a row.
    #[inline(always)]
    fn end(&self, simd: S, node: &Node, row: usize, axis: usize) -> S::Lanes {
        let plane = simd.load(&node.planes[row]);
        simd.mul(simd.sub(plane, self.origin[axis]), self.inverse[axis])
    }

    /// Which children the ray meets up to `limit`, and where it enters each.
    #[inline(always)]
    pub(crate) fn test(&self, simd: S, node: &Node, limit: S::Lanes) -> (S::Lanes, u32) {
        let (mut near, mut far) = (self.start, limit);
        for axis in 0..3 {
            near = simd.max(self.end(simd, node, self.near[axis], axis), near);
            far = simd.min(self.end(simd, node, self.near[axis] ^ 1, axis), far);
        }
        let far = simd.mul_add(simd.abs(far), self.slack, far);
        (near, simd.mask_le(near, far))
    }
}
