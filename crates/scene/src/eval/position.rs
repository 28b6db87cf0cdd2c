//! Positions and geometric normals rebuilt from element and parameters.

use crate::{Scene, Shape, primitive::Primitive};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use rotund_geometry::Ray;

impl Scene {
    /// Returns the surface point with these parameters, in world space.
    ///
    /// For the parameters of a [`crate::SceneHit`] it is within `error + 2^-22 (size + distance)`
    /// of the position of the hit: the error of the hit, plus the rounding of `uv` and of the frame
    /// in proportion to the size of the element in the world and to its distance from the origin.
    ///
    /// [`rotund_geometry::Sphere::position`], [`rotund_geometry::RoundedCone::position`] and so on
    /// define the parameters. The position of a vanilla point is its centre, that of a vanilla line
    /// is on the axis.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_position(&self, instance: u32, element: u32, uv: Vec2) -> Vec3 {
        let (frame, shape) = self.placed(instance);
        frame.transform_point3(shape.primitive(element).position(uv))
    }

    /// Returns the parameters of a point on the surface of an enhanced point or line, in world
    /// space: what [`Self::eval_position`] takes. `normal` is the outward normal there. `None` for
    /// other elements, and for points that are far off the surface.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_round_parameters(
        &self,
        instance: u32,
        element: u32,
        position: Vec3,
        normal: Vec3,
    ) -> Option<Vec2> {
        let (frame, shape) = self.placed(instance);
        let primitive = shape.primitive(element);
        let size = match primitive {
            Primitive::Sphere(sphere) => sphere.radius,
            Primitive::Cone(cone) => cone.r0.max(cone.r1),
            _ => return None,
        };
        // A ray from outside against the normal meets a convex solid at the point.
        let object_from_world = frame.inverse();
        let inwards = -transform_normal(&object_from_world.matrix3, normal);
        let on_surface = object_from_world.transform_point3(position);
        let ray = Ray::new(on_surface - size * inwards, inwards);
        let hit = match primitive {
            Primitive::Sphere(sphere) => sphere.closest(&ray)?,
            Primitive::Cone(cone) => cone.closest(&ray)?,
            _ => return None,
        };
        Some(shape.uv(element, &hit))
    }

    /// Returns the geometric normal of unit length, out of the solid. Vanilla points and lines have
    /// none: a point returns an arbitrary direction, a line its tangent.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_normal(&self, instance: u32, element: u32, uv: Vec2) -> Vec3 {
        let (frame, shape) = self.placed(instance);
        transform_normal(&frame.matrix3, shape.primitive(element).normal(uv))
    }

    /// Returns the frame and the shape of an instance.
    pub(super) fn placed(&self, instance: u32) -> (&Affine3A, &Shape) {
        let instance = &self.instances[instance as usize];
        (&instance.world_from_object, &self.shapes[instance.shape as usize])
    }
}

/// Transforms a unit normal by the inverse transpose of a linear map and normalizes it, so that it
/// stays normal to the surface, and out of the solid even if the map mirrors. Zero stays zero.
pub(super) fn transform_normal(matrix: &Mat3A, normal: Vec3) -> Vec3 {
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = *matrix;
    // The inverse transpose is the cofactor matrix over the determinant, of which only the sign
    // counts.
    let (yz, zx, xy) = (y.cross(z), z.cross(x), x.cross(y));
    let side = 1.0_f32.copysign(x.dot(yz));
    let normal = Vec3A::from(side * normal);
    Vec3::from(Mat3A::from_cols(yz, zx, xy) * normal).normalize_or_zero()
}
