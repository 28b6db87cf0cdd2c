//! Transforms of rays into instances and of hits back, with bounds on their rounding.
//!
//! # Error of a hit in world space
//!
//! Let `x ↦ M x + T` be the frame and `x ↦ W x + w` its inverse, stored in `f32`. A hit at `p`,
//! within `e` of the surface along its normal `n`, is reported at the rounded `P = M p + T`. A ray
//! that starts near there is transformed to object space by the rounded `W x + w`. The error of
//! each coordinate is at most the sum of
//!
//! ```text
//! |W| u (m |M| |p| + |M| |p| + |T|)          rounding on the way out, carried back
//! |W M - I| |p| + |W T + w|                  the inverse is not the inverse
//! u (k |W| (|M| |p| + |T|) + |p|)            rounding on the way in
//! ```
//!
//! where `| |` is taken of each entry, and `m` and `k` are the roundings of the products and their
//! sums in each row of `M` and `W`: three at most, and none if a row has a single entry that is a
//! power of two. The last sum, with the translation, is rounded in proportion to its result, which
//! on the way in is `p`: an instance that is only moved adds `u |T|` and hardly more. All this is
//! `o = G |p| + g` with `G` and `g` computed once.
//!
//! A step of length `E` along the world normal `N = M⁻ᵀ n / |M⁻ᵀ n|` moves the origin of the ray by
//! `E |M⁻ᵀ n|` along `n`. So the tangent plane of `p` is left by
//!
//! ```text
//! E = (e + |n|·o) / |M⁻ᵀ n|
//! ```
//!
//! But the errors also move the point along the plane, by a distance `s` of at most the sum of
//! `e`, `|o|`, and `3 u |W| |P|`, by which `leave_surface` rounds outwards. In frames that are no
//! similarity the step itself does so, by the part of `M⁻¹ N` across `n`.
//! There a surface of curvature `κ` lies `κ s² / 2` below the plane, or a little more. A point
//! `κ s²` below it is inside of a sphere, as long as that is not more than the radius; and the
//! distance of the surface never exceeds `s` more than that of the plane. So
//!
//! ```text
//! E = (e + |n|·o + min(κ s², s)) / |M⁻ᵀ n|
//! ```
//!
//! suffices on either side, where the radius of curvature is not less than `s`, a few roundings of
//! `P`. An identity adds no error.

use glam::{Affine3A, DMat3, DVec3, Mat3A, Vec3, Vec3A};
use rotund_geometry::{Aabb, Hit, Ray, UNIT_ROUNDOFF};

/// Bound on the relative error of a rounding, with room for the squares of such errors and for the
/// rounding of the bounds themselves.
const U: f64 = 1.01 * UNIT_ROUNDOFF as f64;

/// Bound on the relative error of three products and three sums, `4 u / (1 - 4 u)`, rounded up for
/// the rounding of the bounds themselves.
///
/// Source: N. J. Higham, "Accuracy and Stability of Numerical Algorithms", 2nd edition, chapter 3,
/// 2002.
const GAMMA: f64 = 4.01 * UNIT_ROUNDOFF as f64;

/// The errors of rays that start anywhere, as a multiple of the errors of those that start at hits.
///
/// The products with a far origin are rounded in proportion to its distance, by up to `3 u |W|`.
/// Slab tests allow for `8 u` of the distance, which suffices unless a frame stretches; the rest is
/// for such frames.
const RAYS: f32 = 4.0;

/// The frame of an instance, with its inverse and error bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    world_from_object: Affine3A,
    object_from_world: Affine3A,
    /// The inverse transpose.
    normals: Mat3A,
    /// `G` and `g` above.
    slope: Mat3A,
    offset: Vec3A,
    /// Bound on the length of `W x` per length of `x`.
    shrink: f32,
    /// Whether steps along `N` are along `n` too.
    similarity: bool,
    identity: bool,
}

/// Position, normal and error of a hit in world space.
pub(crate) struct WorldHit {
    pub position: Vec3,
    pub normal: Vec3,
    pub error: f32,
}

impl Frame {
    pub(crate) fn new(world_from_object: Affine3A) -> Self {
        let m = world_from_object.as_daffine3();
        let inverse = m.inverse();
        let object_from_world = inverse.as_affine3a();
        let w = object_from_world.as_daffine3();
        let (m_abs, w_abs) = (abs(m.matrix3), abs(w.matrix3));
        let (out, back) = (U * roundings(world_from_object), U * roundings(object_from_world));
        let out = w_abs * (DMat3::from_diagonal(out) + U * DMat3::IDENTITY) * m_abs;
        let way_in = DMat3::from_diagonal(back) * w_abs;
        let slope = out
            + abs(w.matrix3 * m.matrix3 - DMat3::IDENTITY)
            + way_in * m_abs
            + U * DMat3::IDENTITY;
        let offset = (U * w_abs + way_in) * m.translation.abs()
            + (w.matrix3 * m.translation + w.translation).abs();
        // The spectral norm is at most the root of the largest sums of columns and of rows.
        let largest_sum = |m: DMat3| (m.x_axis + m.y_axis + m.z_axis).max_element();
        let shrink = (largest_sum(w_abs) * largest_sum(w_abs.transpose())).sqrt();
        // A step is along `M⁻¹ M⁻ᵀ n`.
        let square = inverse.matrix3 * inverse.matrix3.transpose();
        let mean = (square.x_axis.x + square.y_axis.y + square.z_axis.z) / 3.0;
        let similarity = norm(square - mean * DMat3::IDENTITY) < 1e-4 * mean;
        Self {
            world_from_object,
            object_from_world,
            normals: Mat3A::from(inverse.matrix3.transpose().as_mat3()),
            slope: Mat3A::from(slope.as_mat3()),
            offset: offset.as_vec3a(),
            shrink: shrink as f32,
            similarity,
            identity: world_from_object == Affine3A::IDENTITY,
        }
    }

    /// Returns whether object space is world space.
    #[inline]
    pub(crate) fn is_identity(&self) -> bool {
        self.identity
    }

    /// Transforms a ray to object space. `t` is the same in both spaces, since the direction is not
    /// normalized.
    #[inline]
    pub(crate) fn object_ray(&self, ray: &Ray) -> Ray {
        if self.identity {
            return *ray;
        }
        Ray {
            origin: self.object_from_world.transform_point3(ray.origin),
            direction: self.object_from_world.transform_vector3(ray.direction),
            ..*ray
        }
    }

    /// Transforms a hit to world space. `curvature` returns the largest curvature of the surface at
    /// the hit; it is not called if the frame is an identity.
    #[inline]
    pub(crate) fn world_hit(&self, hit: &Hit, curvature: impl FnOnce() -> f32) -> WorldHit {
        if self.identity {
            return WorldHit { position: hit.position, normal: hit.normal, error: hit.error };
        }
        let normal = self.normals * Vec3A::from(hit.normal);
        let length = normal.length();
        let off = self.slope * Vec3A::from(hit.position).abs() + self.offset;
        let plane_error = hit.error + Vec3A::from(hit.normal).abs().dot(off);
        let position = self.world_from_object.transform_point3(hit.position);
        let outwards = 3.0 * UNIT_ROUNDOFF * self.shrink * position.length();
        let mut along = hit.error + off.length() + outwards;
        if !self.similarity {
            let (step, height) = (self.object_from_world.matrix3 * normal, length * length);
            let across = step.length_squared() - height * height;
            along += plane_error * across.max(0.0).sqrt() / height;
        }
        // The order of the arguments replaces a NaN, of no distance and infinite curvature.
        let object_error = plane_error + (curvature() * (along * along)).min(along);
        WorldHit {
            position,
            normal: Vec3::from(normal / length),
            // The factor covers the roundings of the sums above, the length and the division.
            error: object_error / length * (1.0 + 16.0 * UNIT_ROUNDOFF),
        }
    }

    /// Returns a bound on the distance, in object space, between a ribbon and the start of a ray
    /// that left its middle: the length of the step `E` in object space, and the rounding of the
    /// transform back. `bounds` contain the shape.
    ///
    /// A ribbon, that is a vanilla point or line, has no sides: a ray leaves it from its middle,
    /// and rounding decides whether the closest approach lies before or after the start. Anything
    /// nearer than this bound is taken for the ribbon that the ray left.
    ///
    /// The closest approach of a ray along a ribbon is farther from its start than the ribbon is,
    /// hence the margin [`RAYS`]. Where products are rounded, [`GAMMA`] for each transform has
    /// margin enough, and ignores less of what is near.
    pub(crate) fn ribbon_start(&self, bounds: Aabb) -> f32 {
        if bounds.is_empty() {
            return 0.0;
        }
        let farthest = Vec3A::from(bounds.min.abs().max(bounds.max.abs()));
        let [m, w] = [self.world_from_object, self.object_from_world].map(|a| a.as_daffine3());
        let residual = w * m;
        let (m_abs, w_abs) = (abs(m.matrix3), abs(w.matrix3));
        let far = farthest.as_dvec3();
        let plain = 2.0 * GAMMA * (w_abs * (m_abs * far + m.translation.abs()))
            + abs(residual.matrix3 - DMat3::IDENTITY) * far
            + residual.translation.abs()
            + GAMMA * w.translation.abs();
        let off = (RAYS * (self.slope * farthest + self.offset)).element_sum();
        // The sum of the coordinates bounds both the length and the rounding inside the primitive.
        let off =
            off.min(plain.element_sum() as f32) + 2.0 * UNIT_ROUNDOFF * farthest.element_sum();
        let matrices = [self.world_from_object.matrix3, self.object_from_world.matrix3];
        let [forth, back] = matrices.map(|m| norm(m.as_dmat3()));
        let stretch = (forth * back) as f32;
        off * (1.0 + stretch)
    }

    /// Returns a box in world space around a box in object space, grown by the errors of
    /// transformed rays.
    pub(crate) fn world_bounds(&self, bounds: Aabb) -> Aabb {
        if self.identity || bounds.is_empty() {
            return bounds;
        }
        let m = self.world_from_object.as_daffine3();
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let center = m.transform_point3(0.5 * (min + max));
        let farthest = Vec3A::from(bounds.min.abs().max(bounds.max.abs()));
        let off = (RAYS * (self.slope * farthest + self.offset)).as_dvec3();
        let half = 0.5 * (max - min) + off;
        let [x, y, z] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(DVec3::abs);
        let half = x * half.x + y * half.y + z * half.z;
        let (low, high) = ((center - half).as_vec3(), (center + half).as_vec3());
        Aabb {
            min: Vec3::new(low.x.next_down(), low.y.next_down(), low.z.next_down()),
            max: Vec3::new(high.x.next_up(), high.y.next_up(), high.z.next_up()),
        }
    }
}

/// Returns the absolute values of all entries.
fn abs(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

/// Returns the Frobenius norm.
fn norm(m: DMat3) -> f64 {
    let square = m.x_axis.length_squared() + m.y_axis.length_squared();
    (square + m.z_axis.length_squared()).sqrt()
}

/// Returns how many roundings the products and their sums have in each row.
fn roundings(transform: Affine3A) -> DVec3 {
    let rows = transform.matrix3.transpose();
    DVec3::from_array([rows.x_axis, rows.y_axis, rows.z_axis].map(|row| {
        let entries = row.to_array();
        let is_power_of_two = |x: f32| x.is_normal() && x.to_bits() << 9 == 0;
        let inexact = entries.iter().any(|&x| x != 0.0 && !is_power_of_two(x));
        let terms = entries.iter().filter(|&&x| x != 0.0).count();
        f64::from(u8::from(inexact)) + terms.saturating_sub(1) as f64
    }))
}
