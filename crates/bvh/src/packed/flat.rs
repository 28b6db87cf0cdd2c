//! What patches and triangles share: their corners, seen along the ray.
//!
//! The origin of the ray moves to zero and a shear brings its direction onto the dominant axis `z`;
//! then the ray meets the hull of the corners if zero is in the hull of the corners' `(x, y)`.
//!
//! With `u = 2^-24`, `S` the largest side of the box of the corners and `Z` the largest `|z|`, a sheared
//! coordinate is wrong by less than `4 u (|x| + |z|)`. A ray that meets the hull sees all corners within
//! `2 S` of zero, since the slopes are at most one. So the signed area `x_i y_j - x_j y_i` of such a ray is
//! wrong by less than `4 · 2 S · 4 u (2 S + Z) + 8 u S²`, for which `2^-18 S (|z_0| + 4 S)` is enough, `z_0`
//! being that of any one corner. Signs within that count as either.

use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::glam::Vec3;

/// A ray as flat primitives see it.
#[derive(Clone, Copy)]
pub struct FlatLanes<S: Simd> {
    /// The axes that become x, y and z.
    axes: [usize; 3],
    origin: [S::Lanes; 3],
    slope: [S::Lanes; 2],
    /// From `z` to the parameter.
    inverse: S::Lanes,
    pub(crate) start: S::Lanes,
}

impl<S: Simd> FlatLanes<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &SlabRay) -> Self {
        let size = ray.direction.abs();
        let axes = if size.x > size.y && size.x > size.z {
            [1, 2, 0]
        } else if size.y > size.z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let [dx, dy, dz] = axes.map(|axis| ray.direction[axis]);
        Self {
            axes,
            origin: axes.map(|axis| simd.splat(ray.origin[axis])),
            slope: [simd.splat(dx / dz), simd.splat(dy / dz)],
            inverse: simd.splat(dz.recip()),
            start: simd.splat(ray.start),
        }
    }

    /// Loads a corner, given its three rows, and looks at it along the ray.
    #[inline(always)]
    pub(crate) fn corner(&self, simd: S, rows: &[[f32; 8]; 3]) -> Corner<S> {
        let [x, y, z]: [S::Lanes; 3] =
            std::array::from_fn(|i| simd.sub(simd.load(&rows[self.axes[i] % 3]), self.origin[i]));
        Corner {
            x: simd.neg_mul_add(z, self.slope[0], x),
            y: simd.neg_mul_add(z, self.slope[1], y),
            z,
        }
    }

    /// How far a signed area may be from the truth, derived above.
    #[inline(always)]
    pub(crate) fn area_error(&self, simd: S, size: S::Lanes, z: S::Lanes) -> S::Lanes {
        let depth = simd.mul_add(size, simd.splat(4.0), simd.abs(z));
        simd.mul(simd.mul(size, simd.splat(2f32.powi(-18))), depth)
    }

    /// Which lanes have a part in the interval of the ray up to `limit`, and where the part begins at
    /// the earliest.
    #[inline(always)]
    pub(crate) fn interval<const CORNERS: usize>(
        &self,
        simd: S,
        corners: [Corner<S>; CORNERS],
        limit: f32,
    ) -> (u32, S::Lanes) {
        let (mut least, mut most) = (corners[0].z, corners[0].z);
        for corner in &corners[1..] {
            (least, most) = (simd.min(corner.z, least), simd.max(corner.z, most));
        }
        let (a, b) = (simd.mul(least, self.inverse), simd.mul(most, self.inverse));
        let slack = simd.splat(2f32.powi(-20));
        let (near, far) = (simd.min(a, b), simd.max(a, b));
        let near = simd.neg_mul_add(simd.abs(near), slack, near);
        let far = simd.mul_add(simd.abs(far), slack, far);
        let within = simd.mask_not_gt(near, simd.splat(limit)) & simd.mask_not_gt(self.start, far);
        (within, simd.max(near, self.start))
    }
}

/// A corner in the sheared space.
#[derive(Clone, Copy)]
pub(crate) struct Corner<S: Simd> {
    pub(crate) x: S::Lanes,
    pub(crate) y: S::Lanes,
    pub(crate) z: S::Lanes,
}

/// Twice the signed area of the triangle (zero, a, b).
#[inline(always)]
pub(crate) fn area<S: Simd>(simd: S, a: Corner<S>, b: Corner<S>) -> S::Lanes {
    simd.neg_mul_add(b.x, a.y, simd.mul(a.x, b.y))
}

/// The largest side of the box of some corners; infinite if it overflows.
pub(crate) fn largest_side(corners: &[Vec3]) -> f32 {
    let bounds = rotund_geometry::Aabb::from_points(corners.iter().copied());
    (bounds.max - bounds.min).max_element()
}
