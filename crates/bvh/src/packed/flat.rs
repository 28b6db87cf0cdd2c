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
//!
//! That a ray hits for sure must not rest on its being near: there, `x_0` and `y_0` are asked to be at most
//! `2 S`, so that all corners are within `4 S`, and four times the error is allowed for.
//!
//! A ray that leaves what it started from has its crossing behind it. Of a triangle that it meets, the areas are
//! shares of the corners, all of the sign of their sum, so the crossing is before or behind the origin by the
//! sign of the volume `a_12 z_0 + a_20 z_1 + a_01 z_2`. With `E` the error of an area this is wrong by less than
//! `3 E Z`, and `96 u S² Z` from rounding: `4 E (|z_0| + S)` is enough.
//!
//! Divided by the sum of the areas, which is wrong by less than `4 E`, that volume is the `z` of the crossing. The
//! crossing is at `Z` at most, so the quotient is wrong by less than both errors together, `8 E (|z_0| + S)`, over
//! the computed sum. For a triangle that is large as seen from the ray this says much more than the `z` of its corners.

use super::kernel::{Candidates, dot, load3, splat, sub};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::glam::Vec3;

/// A mask of all lanes.
const ALL: u32 = (1 << WIDTH) - 1;

/// A ray as flat primitives see it.
#[derive(Clone, Copy)]
pub struct FlatLanes<S: Simd> {
    /// The axes that become x, y and z.
    axes: [usize; 3],
    origin: [S::Lanes; 3],
    slope: [S::Lanes; 2],
    /// From `z` to the parameter.
    inverse: S::Lanes,
    start: S::Lanes,
    end: S::Lanes,
    /// 1 with the sign of `inverse`.
    sense: S::Lanes,
    /// All lanes if the interval starts behind the origin, else none.
    backwards: u32,
}

impl<S: Simd> FlatLanes<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &SlabRay) -> Self {
        let size = ray.direction.abs();
        let over = [
            usize::from(size.x > size.y),
            usize::from(size.x > size.z),
            usize::from(size.y > size.z),
        ];
        // 0 if x is the largest, 1 if y is, else 2: without a branch, which would be hard to predict.
        let z = 2 - (2 * (over[0] & over[1]) + (over[2] & (over[0] ^ 1)));
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
        let axes = [x, y, z];
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let (o, d) = (Vec3::new(o[x], o[y], o[z]), Vec3::new(d[x], d[y], d[z]));
        Self {
            axes,
            origin: splat(simd, o),
            slope: [simd.splat(d.x / d.z), simd.splat(d.y / d.z)],
            inverse: simd.splat(d.z.recip()),
            start: simd.splat(ray.start),
            end: simd.splat(ray.end),
            sense: simd.splat(1f32.copysign(d.z)),
            backwards: if ray.start < 0.0 { ALL } else { 0 },
        }
    }

    /// Loads a corner, given its three rows, and looks at it along the ray.
    #[inline(always)]
    pub(crate) fn corner(&self, simd: S, rows: &[[f32; WIDTH]; 3]) -> Corner<S> {
        let [x, y, z] = self.axes;
        let picked = load3(simd, [&rows[x % 3], &rows[y % 3], &rows[z % 3]]);
        let [x, y, z] = sub(simd, picked, self.origin);
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
        let error = simd.mul(size, simd.splat(2f32.powi(-18)));
        // Products that underflow are off by less than the smallest normal number.
        simd.mul_add(error, depth, simd.splat(f32::MIN_POSITIVE))
    }

    /// Lanes where the outline, of which these are the least and the largest area, turns around the ray
    /// beyond all error.
    #[inline(always)]
    pub(crate) fn surely(
        &self,
        simd: S,
        corner: &Corner<S>,
        size: S::Lanes,
        error: S::Lanes,
        [least, most]: [S::Lanes; 2],
    ) -> u32 {
        let error = simd.mul(error, simd.splat(4.0));
        let turns =
            simd.mask_le(error, least) | simd.mask_le(most, simd.sub(simd.splat(0.0), error));
        let away = simd.max(simd.abs(corner.x), simd.abs(corner.y));
        turns & simd.mask_le(away, simd.add(size, size))
    }

    /// Of the lanes where the line may cross a triangle, those where it may do so before the origin.
    #[inline(always)]
    pub(crate) fn ahead(
        &self,
        simd: S,
        areas: [S::Lanes; 3],
        error: S::Lanes,
        [volume, slack]: [S::Lanes; 2],
    ) -> u32 {
        let volume = simd.mul(volume, self.sense);
        let zero = simd.splat(0.0);
        let positive = simd.mask_not_gt(simd.sub(zero, error), least(simd, areas));
        let negative = simd.mask_not_gt(most(simd, areas), error);
        positive & (self.backwards | simd.mask_not_gt(simd.sub(zero, slack), volume))
            | negative & (self.backwards | simd.mask_not_gt(volume, slack))
    }

    /// Of the lanes that the line may cross, and of those that it surely does, those where it does so
    /// in the interval of the ray up to `limit`. If it does, it is at a `z` between the two.
    #[inline(always)]
    pub(crate) fn candidates(
        &self,
        simd: S,
        [least, most]: [S::Lanes; 2],
        limit: f32,
        maybe: u32,
        surely: u32,
    ) -> Candidates<S> {
        let (a, b) = (simd.mul(least, self.inverse), simd.mul(most, self.inverse));
        let slack = simd.splat(2f32.powi(-20));
        let (near, far) = (simd.min(a, b), simd.max(a, b));
        let near = simd.neg_mul_add(simd.abs(near), slack, near);
        let far = simd.mul_add(simd.abs(far), slack, far);
        let within = simd.mask_not_gt(near, simd.splat(limit)) & simd.mask_not_gt(self.start, far);
        let inside = simd.mask_le(self.start, near) & simd.mask_le(far, self.end);
        let maybe = maybe & within;
        Candidates { maybe, surely: surely & inside & maybe, near: simd.max(near, self.start), far }
    }
}

/// The volume that the ray spans with a triangle, and a bound on its error.
#[inline(always)]
pub(crate) fn volume<S: Simd>(
    simd: S,
    corners: [&Corner<S>; 3],
    areas: [S::Lanes; 3],
    size: S::Lanes,
    error: S::Lanes,
) -> [S::Lanes; 2] {
    let depth = simd.add(simd.abs(corners[0].z), size);
    let slack = simd.mul(simd.mul(error, simd.splat(4.0)), depth);
    let slack = simd.add(slack, simd.splat(f32::MIN_POSITIVE));
    [dot(simd, areas, [corners[0].z, corners[1].z, corners[2].z]), slack]
}

/// The least and the largest `z` of some corners.
#[inline(always)]
pub(crate) fn range<S: Simd>(simd: S, corners: &[Corner<S>]) -> [S::Lanes; 2] {
    let (mut least, mut most) = (corners[0].z, corners[0].z);
    for corner in &corners[1..] {
        (least, most) = (simd.min(corner.z, least), simd.max(corner.z, most));
    }
    [least, most]
}

/// Of a range of `z` in which a line crosses a triangle the part that areas and volume leave, derived above.
#[inline(always)]
pub(crate) fn crossing<S: Simd>(
    simd: S,
    [a, b, c]: [S::Lanes; 3],
    [volume, slack]: [S::Lanes; 2],
    [least, most]: [S::Lanes; 2],
) -> [S::Lanes; 2] {
    let inverse = simd.div(simd.splat(1.0), simd.add(simd.add(a, b), c));
    let z = simd.mul(volume, inverse);
    // Of the slack 2 are needed, one is for rounding; beside it that of the quotient, infinite if it overflows.
    let slack = simd.mul(slack, simd.splat(3.0));
    let slack = simd.mul_add(simd.abs(volume), simd.splat(2f32.powi(-20)), slack);
    let error = simd.mul(slack, simd.abs(inverse));
    // A NaN leaves the range as it was.
    [simd.max(simd.sub(z, error), least), simd.min(simd.add(z, error), most)]
}

/// A corner in the sheared space.
#[derive(Clone, Copy)]
pub(crate) struct Corner<S: Simd> {
    pub(crate) x: S::Lanes,
    pub(crate) y: S::Lanes,
    pub(crate) z: S::Lanes,
}

#[inline(always)]
pub(crate) fn least<S: Simd>(simd: S, [a, b, c]: [S::Lanes; 3]) -> S::Lanes {
    simd.min(simd.min(a, b), c)
}

#[inline(always)]
pub(crate) fn most<S: Simd>(simd: S, [a, b, c]: [S::Lanes; 3]) -> S::Lanes {
    simd.max(simd.max(a, b), c)
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
