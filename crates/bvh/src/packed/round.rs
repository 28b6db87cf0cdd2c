//! The ray as the wide tests of spheres and rounded cones use it.

use super::vec3::{dot, neg_mul_add, splat, sub};
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::glam::Vec3;

/// A ray, prepared for round primitives.
#[derive(Clone, Copy)]
pub struct RoundRay {
    origin: Vec3,
    direction: Vec3,
    /// `1 / |d|²`.
    inverse_square: f32,
    /// `1 / |d|`.
    inverse_length: f32,
    start: f32,
    end: f32,
}

/// A [`RoundRay`], broadcast to all lanes.
pub(crate) struct RoundLanes<S: Simd> {
    origin: [S::Lanes; 3],
    direction: [S::Lanes; 3],
    inverse_square: S::Lanes,
    pub(crate) inverse_length: S::Lanes,
    pub(crate) start: S::Lanes,
    pub(crate) end: S::Lanes,
}

/// A point relative to a ray.
pub(crate) struct Projection<S: Simd> {
    /// The squared distance of the point from the origin of the ray.
    pub(crate) distance_squared: S::Lanes,
    /// The parameter of the closest point of the line.
    pub(crate) t: S::Lanes,
    /// The vector from the closest point of the line to the point.
    pub(crate) perpendicular: [S::Lanes; 3],
}

impl RoundRay {
    #[inline(always)]
    pub(crate) fn new(ray: &SlabRay) -> Self {
        let inverse_square = ray.direction.length_squared().recip();
        Self {
            origin: ray.leaf_origin,
            direction: ray.direction,
            inverse_square,
            inverse_length: inverse_square.sqrt(),
            start: ray.start,
            end: ray.end,
        }
    }

    /// Broadcasts the ray to all lanes.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S) -> RoundLanes<S> {
        RoundLanes {
            origin: splat(simd, self.origin),
            direction: splat(simd, self.direction),
            inverse_square: simd.splat(self.inverse_square),
            inverse_length: simd.splat(self.inverse_length),
            start: simd.splat(self.start),
            end: simd.splat(self.end),
        }
    }
}

impl<S: Simd> RoundLanes<S> {
    /// Projects a point on the line of the ray.
    #[inline(always)]
    pub(crate) fn project(&self, simd: S, p: [S::Lanes; 3]) -> Projection<S> {
        let [x, y, z] = sub(simd, p, self.origin);
        let [dx, dy, dz] = self.direction;
        let along = simd.mul_add(x, dx, simd.mul_add(y, dy, simd.mul(z, dz)));
        let t = simd.mul(along, self.inverse_square);
        let distance_squared = dot(simd, [x, y, z], [x, y, z]);
        let perpendicular = neg_mul_add(simd, t, self.direction, [x, y, z]);
        Projection { distance_squared, t, perpendicular }
    }
}
