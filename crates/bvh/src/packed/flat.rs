//! Ray space, in which the wide tests of patches and triangles work.
//!
//! A translation moves the origin of the ray to zero, and a shear turns its direction to the
//! dominant axis `z`. The line then meets the convex hull of corners if zero lies in the hull of
//! their `(x, y)`.
//!
//! # Errors of areas
//!
//! With `u = 2^-24`, `S` the longest side of the box of the corners and `Z` the largest `|z|`, the
//! error of a sheared coordinate is less than `4 u (|x| + |z|)`. If the line meets the hull, all
//! corners are within `2 S` of zero, since the slopes of the shear are at most one. So the error of
//! a signed area `x_i y_j - x_j y_i` is then less than `4 · 2 S · 4 u (2 S + Z) + 8 u S²`. The
//! bound in use, `2^-18 S (|z_0| + 4 S)` with the `z_0` of any one corner, exceeds this. An area
//! within the bound counts as positive and as negative.
//!
//! A certain hit must not presuppose that the line passes near. So it requires `x_0` and `y_0` of
//! at most `2 S`, which puts all corners within `4 S`, and areas beyond four times the bound.
//!
//! # Crossings in front of and behind the origin
//!
//! A ray that leaves a surface has its crossing with that surface behind it. If the line meets a
//! triangle, the areas are weights of the corners, all of the sign of their sum. So the sign of the
//! volume `a_12 z_0 + a_20 z_1 + a_01 z_2` gives the side of the crossing: in front of or behind
//! the origin. With `E` the error of an area, the error of the volume is less than `3 E Z`, and
//! `96 u S² Z` from rounding; the bound in use is `4 E (|z_0| + S)`.
//!
//! The volume over the sum of the areas, whose error is less than `4 E`, is the `z` of the
//! crossing. As that is `Z` at most, the error of the quotient is less than the sum of both errors,
//! `8 E (|z_0| + S)`, over the computed sum. For a triangle that is large compared with its
//! distance this range is much narrower than that of the `z` of its corners.

use super::kernel::Candidates;
use super::vec3::{self, dot, sub};
use crate::node::WIDTH;
use crate::simd::Simd;
use crate::slab::SlabRay;
use rotund_geometry::glam::{Vec3, Vec4};

/// The mask of all lanes.
const ALL_LANES: u32 = (1 << WIDTH) - 1;

/// A ray, prepared for flat primitives.
#[derive(Clone, Copy)]
pub struct FlatRay {
    /// The axes that become x, y and z of ray space.
    axes: [usize; 3],
    /// The origin in ray space before the shear.
    origin: [f32; 3],
    /// The shear, the change of x and y per unit of z along the ray, and the parameter per unit of
    /// the mirrored z of a [`Corner`].
    shear: Vec4,
    start: f32,
    end: f32,
}

impl FlatRay {
    #[inline(always)]
    pub(crate) fn new(ray: &SlabRay) -> Self {
        // The bits of non-negative numbers have the order of the numbers, and integers are compared
        // faster. The dominant axis is computed branch-free, because it is unpredictable, and the
        // other two by arithmetic that proves them to be below 3.
        let (o, d) = (ray.leaf_origin.to_array(), ray.direction.to_array());
        let [x, y, z] = [d[0].to_bits() << 1, d[1].to_bits() << 1, d[2].to_bits() << 1];
        let z = (usize::from(y >= x) + 2 * usize::from(z >= x.max(y))).min(2);
        let (x, y) = (if z == 2 { 0 } else { z + 1 }, if z == 0 { 2 } else { z - 1 });
        let shear = Vec4::new(d[x], d[y], -1.0, 1.0) / d[z];
        Self { axes: [x, y, z], origin: [o[x], o[y], o[z]], shear, start: ray.start, end: ray.end }
    }

    /// Broadcasts the ray to all lanes.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S) -> FlatLanes<S> {
        let [x, y, z] = self.origin;
        FlatLanes {
            axes: self.axes,
            origin: [simd.splat(x), simd.splat(y), simd.splat(z)],
            slope: [simd.splat(self.shear.x), simd.splat(self.shear.y)],
            inverse: simd.splat(self.shear.z),
            start: simd.splat(self.start),
            end: simd.splat(self.end),
            sign: simd.splat(1f32.copysign(self.shear.z)),
            starts_behind: if self.start < 0.0 { ALL_LANES } else { 0 },
        }
    }
}

/// A [`FlatRay`], broadcast to all lanes.
pub(crate) struct FlatLanes<S: Simd> {
    axes: [usize; 3],
    origin: [S::Lanes; 3],
    slope: [S::Lanes; 2],
    inverse: S::Lanes,
    start: S::Lanes,
    end: S::Lanes,
    /// 1 with the sign of `inverse`.
    sign: S::Lanes,
    /// All lanes if the interval starts behind the origin, else none.
    starts_behind: u32,
}

impl<S: Simd> FlatLanes<S> {
    /// Loads a corner from its three rows and transforms it to ray space.
    #[inline(always)]
    pub(crate) fn corner(&self, simd: S, rows: &[[f32; WIDTH]; 3]) -> Corner<S> {
        let [x, y, z] = self.axes;
        let permuted = vec3::load(simd, [&rows[x.min(2)], &rows[y.min(2)], &rows[z.min(2)]]);
        // Mirrored, because a subtraction can take its second argument from memory.
        let [x, y, z] = sub(simd, self.origin, permuted);
        Corner {
            x: simd.neg_mul_add(z, self.slope[0], x),
            y: simd.neg_mul_add(z, self.slope[1], y),
            z,
        }
    }

    /// Bound on the error of a signed area, derived above.
    #[inline(always)]
    pub(crate) fn area_error(&self, simd: S, size: S::Lanes, z: S::Lanes) -> S::Lanes {
        let depth = simd.mul_add(size, simd.splat(4.0), simd.abs(z));
        let error = simd.mul(size, simd.splat(2f32.powi(-18)));
        // Covers products that underflow.
        simd.mul_add(error, depth, simd.splat(f32::MIN_POSITIVE))
    }

    /// Lanes whose outline certainly winds around the ray. `smallest` and `largest` are the
    /// extremes of its signed areas.
    #[inline(always)]
    pub(crate) fn certain_inside(
        &self,
        simd: S,
        corner: &Corner<S>,
        size: S::Lanes,
        error: S::Lanes,
        [smallest, largest]: [S::Lanes; 2],
    ) -> u32 {
        let error = simd.mul(error, simd.splat(4.0));
        let winds =
            simd.mask_le(error, smallest) | simd.mask_le(largest, simd.sub(simd.splat(0.0), error));
        let distance = simd.max(simd.abs(corner.x), simd.abs(corner.y));
        winds & simd.mask_le(distance, simd.add(size, size))
    }

    /// Lanes whose triangle the line may cross in front of the origin (or anywhere, if the interval
    /// starts behind it).
    #[inline(always)]
    pub(crate) fn crossing_ahead(
        &self,
        simd: S,
        areas: [S::Lanes; 3],
        error: S::Lanes,
        [volume, slack]: [S::Lanes; 2],
    ) -> u32 {
        let volume = simd.mul(volume, self.sign);
        let zero = simd.splat(0.0);
        let positive = simd.mask_not_gt(simd.sub(zero, error), min3(simd, areas));
        let negative = simd.mask_not_gt(max3(simd, areas), error);
        positive & (self.starts_behind | simd.mask_not_gt(simd.sub(zero, slack), volume))
            | negative & (self.starts_behind | simd.mask_not_gt(volume, slack))
    }

    /// Restricts the lanes that the line possibly and certainly crosses to crossings in the
    /// interval of the ray up to `limit`. `smallest` and `largest` bound the `z` of a crossing.
    #[inline(always)]
    pub(crate) fn candidates(
        &self,
        simd: S,
        [smallest, largest]: [S::Lanes; 2],
        limit: f32,
        possible: u32,
        certain: u32,
    ) -> Candidates<S> {
        let (a, b) = (simd.mul(smallest, self.inverse), simd.mul(largest, self.inverse));
        let slack = simd.splat(2f32.powi(-20));
        let (near, far) = (simd.min(a, b), simd.max(a, b));
        let near = simd.neg_mul_add(simd.abs(near), slack, near);
        let far = simd.mul_add(simd.abs(far), slack, far);
        let within = simd.mask_not_gt(near, simd.splat(limit)) & simd.mask_not_gt(self.start, far);
        let inside = simd.mask_le(self.start, near) & simd.mask_le(far, self.end);
        let possible = possible & within;
        let certain = certain & inside & possible;
        Candidates { possible, certain, near: simd.max(near, self.start), far }
    }
}

/// The volume, derived above, of a triangle, and a bound on its error.
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

/// The smallest and the largest `z` of corners.
#[inline(always)]
pub(crate) fn z_range<S: Simd>(simd: S, corners: &[Corner<S>]) -> [S::Lanes; 2] {
    // Two halves at once, for a shorter chain of dependent instructions.
    let (one, other) = corners.split_at(corners.len() / 2);
    let ([a, b], [c, d]) = (z_ends(simd, one), z_ends(simd, other));
    [simd.min(a, c), simd.max(b, d)]
}

#[inline(always)]
fn z_ends<S: Simd>(simd: S, corners: &[Corner<S>]) -> [S::Lanes; 2] {
    let (mut smallest, mut largest) = (corners[0].z, corners[0].z);
    for corner in &corners[1..] {
        smallest = simd.min(corner.z, smallest);
        largest = simd.max(corner.z, largest);
    }
    [smallest, largest]
}

/// Narrows the range of `z` in which the line may cross a triangle by its areas and volume, as
/// derived above.
#[inline(always)]
pub(crate) fn crossing_range<S: Simd>(
    simd: S,
    [a, b, c]: [S::Lanes; 3],
    [volume, slack]: [S::Lanes; 2],
    [smallest, largest]: [S::Lanes; 2],
) -> [S::Lanes; 2] {
    let inverse = simd.div(simd.splat(1.0), simd.add(simd.add(a, b), c));
    let z = simd.mul(volume, inverse);
    // Twice the slack bounds the error; the third covers rounding. The quotient adds its own
    // rounding, which is infinite if it overflows.
    let slack = simd.mul(slack, simd.splat(3.0));
    let slack = simd.mul_add(simd.abs(volume), simd.splat(2f32.powi(-20)), slack);
    let error = simd.mul(slack, simd.abs(inverse));
    // The order of the arguments keeps the range where there is a NaN.
    [simd.max(simd.sub(z, error), smallest), simd.min(simd.add(z, error), largest)]
}

/// A corner in ray space, mirrored in the origin.
#[derive(Clone, Copy)]
pub(crate) struct Corner<S: Simd> {
    pub(crate) x: S::Lanes,
    pub(crate) y: S::Lanes,
    pub(crate) z: S::Lanes,
}

/// The smallest of three.
#[inline(always)]
pub(crate) fn min3<S: Simd>(simd: S, [a, b, c]: [S::Lanes; 3]) -> S::Lanes {
    simd.min(simd.min(a, b), c)
}

/// The largest of three.
#[inline(always)]
pub(crate) fn max3<S: Simd>(simd: S, [a, b, c]: [S::Lanes; 3]) -> S::Lanes {
    simd.max(simd.max(a, b), c)
}

/// Twice the signed area of the triangle (zero, a, b).
#[inline(always)]
pub(crate) fn signed_area<S: Simd>(simd: S, a: Corner<S>, b: Corner<S>) -> S::Lanes {
    simd.neg_mul_add(b.x, a.y, simd.mul(a.x, b.y))
}

/// The longest side of the box of corners; infinite if it overflows.
pub(crate) fn largest_side(corners: &[Vec3]) -> f32 {
    let bounds = rotund_geometry::Aabb::from_points(corners.iter().copied());
    (bounds.max - bounds.min).max_element()
}
