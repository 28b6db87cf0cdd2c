//! The arrays that make a scene, and the indices between them.

use crate::{Camera, Environment, Material, Shape, Texture};
use glam::Affine3A;

/// Plain data: everything is an array, and whatever refers to an element does it by index.
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
