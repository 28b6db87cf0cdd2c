//! Positions and geometric normals, rebuilt from an element and its parameters.

use crate::{Scene, Shape};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};

impl Scene {
    /// The point of the surface with these parameters, in world space.
    ///
    /// With the parameters of a [`crate::SceneHit`] this is its position, within
    /// `error + 2^-22 (size + distance)`: the error of the hit, and the rounding of `uv` and of the frame in
    /// proportion to the size of the element in the world and to its distance from the origin.
    ///
    /// What `uv` runs along is on the page of each primitive: [`rotund_geometry::Sphere::position`],
    /// [`rotund_geometry::RoundedCone::position`] and so on; a vanilla point is its centre and a vanilla
    /// line its axis.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn eval_position(&self, instance: u32, element: u32, uv: Vec2) -> Vec3 {
        let (frame, shape) = self.placed(instance);
        frame.transform_point3(shape.primitive(element).position(uv))
    }

    /// The geometric normal there: unit length, out of the solid. Vanilla points and lines have none
    /// of their own and give an arbitrary direction and the tangent.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn eval_normal(&self, instance: u32, element: u32, uv: Vec2) -> Vec3 {
        let (frame, shape) = self.placed(instance);
        transform_normal(&frame.matrix3, shape.primitive(element).normal(uv))
    }

    /// The frame and the shape of an instance.
    pub(super) fn placed(&self, instance: u32) -> (&Affine3A, &Shape) {
        let instance = &self.instances[instance as usize];
        (&instance.world_from_object, &self.shapes[instance.shape as usize])
    }
}

/// A unit normal through a linear map, by the inverse transpose: it stays across the surface, and out
/// of the solid even if the map mirrors. A normal that is zero stays zero.
pub(super) fn transform_normal(matrix: &Mat3A, normal: Vec3) -> Vec3 {
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = *matrix;
    // The inverse transpose is the matrix of cofactors over the determinant, of which the sign counts.
    let (yz, zx, xy) = (y.cross(z), z.cross(x), x.cross(y));
    let side = 1.0_f32.copysign(x.dot(yz));
    let normal = Vec3A::from(side * normal);
    Vec3::from(Mat3A::from_cols(yz, zx, xy) * normal).normalize_or_zero()
}
