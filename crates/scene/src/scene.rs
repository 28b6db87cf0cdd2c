//! The arrays that make a scene, and the indices between them.

use crate::{Camera, ElementKind, Environment, Material, Method, Shape, Texture};
use glam::{Affine3A, Vec3A};

/// Plain data: everything is an array, and whatever refers to an element does it by index.
///
/// [`crate::load`] refuses indices that are out of range; who builds a scene by hand keeps them in
/// range, or evaluation panics.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Views; a renderer is told which one by index.
    pub cameras: Vec<Camera>,
    /// Light from infinitely far away; several add up.
    pub environments: Vec<Environment>,
    /// Images that materials and environments name.
    pub textures: Vec<Texture>,
    /// How surfaces look.
    pub materials: Vec<Material>,
    /// Geometry in object space.
    pub shapes: Vec<Shape>,
    /// Shapes with a material, placed in the world.
    pub instances: Vec<Instance>,
}

impl Scene {
    /// Sets the method of every shape whose elements are of this kind. Trees stay valid.
    pub fn set_method(&mut self, kind: ElementKind, method: Method) {
        for shape in self.shapes.iter_mut().filter(|shape| shape.elements.kind() == kind) {
            shape.method = method;
        }
    }

    /// Moves the frames of cameras and instances so that `origin` becomes the origin of the world.
    ///
    /// Positions have 24 bits: 10 km from the origin they are multiples of a millimeter, and so is what
    /// rays keep clear of. A scene that is far away is traced with more digits if it is brought near
    /// first. The subtraction is exact for frames within half their distance from `origin`.
    pub fn recenter(&mut self, origin: Vec3A) {
        for camera in &mut self.cameras {
            camera.world_from_camera.translation -= origin;
        }
        for instance in &mut self.instances {
            instance.world_from_object.translation -= origin;
        }
    }
}

/// One placement of a shape.
#[derive(Clone, Debug)]
pub struct Instance {
    /// For messages.
    pub name: String,
    /// Any invertible affine map: mirrored, scaled and sheared frames are allowed.
    pub world_from_object: Affine3A,
    /// Index into [`Scene::shapes`].
    pub shape: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
}
