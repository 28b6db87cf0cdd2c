//! Transforms of rays into instances and of hits back, with bounds on their rounding.
//!
//! # Error of a hit in world space
//!
//! Let `x ↦ M x + T` be the frame and `x ↦ W x + w` its inverse, stored in `f32`. A hit at `p`,
//! within `e` of the surface along its normal `n`, is reported at the rounded `M p + T`. A ray that
//! starts near there is transformed to object space by the rounded `W x + w`. The error of each
//! coordinate is at most the sum of
//!
//! ```text
//! |W| γ (|M| |p| + |T|)                      rounding on the way out, carried back
//! |W M - I| |p| + |W T + w|                  the inverse is not the inverse
//! γ (|W| (|M| |p| + |T|) + |w|)              rounding on the way in
//! ```
//!
//! where `γ = 4 u / (1 - 4 u)` bounds three products and three sums, and `| |` is taken of each
//! entry. This is `G |p| + g` with `G` and `g` computed once. A step of length `E` along the world
//! normal `N = M⁻ᵀ n / |M⁻ᵀ n|` moves the ray's origin by `E |M⁻ᵀ n|` along `n`, so
//!
//! ```text
//! E = (e + |n|·(G |p| + g)) / |M⁻ᵀ n|
//! ```
//!
//! suffices to clear the surface in object space. An identity adds no error.
//!
//! Source for `γ`: N. J. Higham, "Accuracy and Stability of Numerical Algorithms", 2nd edition,
//! chapter 3, 2002.

use glam::{Affine3A, DMat3, DVec3, Mat3A, Vec3, Vec3A};
use rotund_geometry::{Aabb, Hit, Ray, UNIT_ROUNDOFF};

/// Bound on the relative error of three products and three sums, rounded up for the rounding of the
/// bounds themselves.
const GAMMA: f64 = 4.01 * UNIT_ROUNDOFF as f64;

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
        let abs = |matrix: DMat3| {
            DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs())
        };
        let both = abs(w.matrix3) * abs(m.matrix3);
        let slope = 2.0 * GAMMA * both + abs(w.matrix3 * m.matrix3 - DMat3::IDENTITY);
        let offset = 2.0 * GAMMA * (abs(w.matrix3) * m.translation.abs())
            + (w.matrix3 * m.translation + w.translation).abs()
            + GAMMA * w.translation.abs();
        Self {
            world_from_object,
            object_from_world,
            normals: Mat3A::from(inverse.matrix3.transpose().as_mat3()),
            slope: Mat3A::from(slope.as_mat3()),
            offset: offset.as_vec3a(),
            identity: world_from_object == Affine3A::IDENTITY,
        }
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

    #[inline]
    pub(crate) fn world_hit(&self, hit: &Hit) -> WorldHit {
        if self.identity {
            return WorldHit { position: hit.position, normal: hit.normal, error: hit.error };
        }
        let normal = self.normals * Vec3A::from(hit.normal);
        let length = normal.length();
        let off = self.slope * Vec3A::from(hit.position).abs() + self.offset;
        let object_error = hit.error + Vec3A::from(hit.normal).abs().dot(off);
        WorldHit {
            position: self.world_from_object.transform_point3(hit.position),
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
    pub(crate) fn ribbon_start(&self, bounds: Aabb) -> f32 {
        if bounds.is_empty() {
            return 0.0;
        }
        let farthest = Vec3A::from(bounds.min.abs().max(bounds.max.abs()));
        // The sum of the coordinates bounds both the length and the rounding inside the primitive.
        let off = self.slope * farthest + self.offset;
        let off = off.element_sum() + 2.0 * UNIT_ROUNDOFF * farthest.element_sum();
        let norm = |m: Mat3A| {
            let square = m.x_axis.length_squared() + m.y_axis.length_squared();
            (square + m.z_axis.length_squared()).sqrt()
        };
        let stretch = norm(self.world_from_object.matrix3) * norm(self.object_from_world.matrix3);
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
        let off = (self.slope * farthest + self.offset).as_dvec3();
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
