//! The arrays that make a scene, and the indices between them.

use crate::{Camera, ElementKind, Environment, Material, Method, Overlap, Shape, Texture};
use glam::{Affine3A, Vec3A};
use rotund_geometry::Aabb;

/// Cameras, lights and surfaces in plain arrays that refer to each other by index.
///
/// Scenes from `load` are valid. [`Scene::validate`], which [`crate::Trees::build`] calls first,
/// finds indices that are out of range and values outside of their domain. Evaluation at an index
/// that is out of range panics.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Views of the scene; a renderer selects one by index.
    pub cameras: Vec<Camera>,
    /// Light from infinitely far away; the radiance of several is summed.
    pub environments: Vec<Environment>,
    /// Images that materials and environments refer to.
    pub textures: Vec<Texture>,
    /// Surface appearances that instances refer to.
    pub materials: Vec<Material>,
    /// Geometry in object space.
    pub shapes: Vec<Shape>,
    /// Shapes with a material and a frame in the world.
    pub instances: Vec<Instance>,
}

impl Scene {
    /// Adds a shape, a material, and an instance of both with the identity frame; returns the index
    /// of the instance.
    ///
    /// ```
    /// use rotund_scene::{Material, Scene, Shape, geometry::glam::{Affine3A, Vec3}};
    ///
    /// let mut scene = Scene::default();
    /// let white = Material { color: Vec3::ONE, ..Material::default() };
    /// let ball = scene.add(Shape::points([Vec3::ZERO], 0.5), white);
    /// scene.instances[ball as usize].world_from_object = Affine3A::from_translation(Vec3::Y);
    /// # assert_eq!(scene.validate(), Ok(()));
    /// ```
    pub fn add(&mut self, shape: Shape, material: Material) -> u32 {
        // More items than `u32` counts do not fit into memory.
        let index = |length: usize| length as u32;
        let instance = Instance::new(index(self.shapes.len()), index(self.materials.len()));
        self.shapes.push(shape);
        self.materials.push(material);
        self.instances.push(instance);
        index(self.instances.len() - 1)
    }

    /// Returns a box around all instances; [`Aabb::EMPTY`] if there are none.
    ///
    /// # Panics
    ///
    /// If an instance names a shape that the scene does not have.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.instances.iter().map(|i| self.bounds_of(i)).fold(Aabb::EMPTY, Aabb::union)
    }

    /// Returns a box around an instance in world space: the bounds of its vertices, padded by the
    /// largest radius.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn instance_bounds(&self, instance: u32) -> Aabb {
        self.bounds_of(&self.instances[instance as usize])
    }

    fn bounds_of(&self, instance: &Instance) -> Aabb {
        let shape = &self.shapes[instance.shape as usize];
        let frame = &instance.world_from_object;
        let stretch = frame.matrix3.x_axis.length().max(frame.matrix3.y_axis.length());
        let stretch = stretch.max(frame.matrix3.z_axis.length());
        let radius = stretch * shape.radii.iter().copied().fold(0.0, f32::max);
        let points = shape.positions.iter().map(|&p| frame.transform_point3(p));
        let Aabb { min, max } = Aabb::from_points(points);
        Aabb { min: min - radius, max: max + radius }
    }

    /// Sets the method of every shape whose elements are of this kind. Trees over the scene stay
    /// valid.
    pub fn set_method(&mut self, kind: ElementKind, method: Method) {
        for shape in self.shapes.iter_mut().filter(|shape| shape.elements.kind() == kind) {
            shape.method = method;
        }
    }

    /// Sets whether the points or lines of every shape are one body. Trees over the scene must be
    /// refitted.
    pub fn set_overlap(&mut self, overlap: Overlap) {
        for shape in &mut self.shapes {
            shape.overlap = overlap;
        }
    }

    /// Returns whether the opacity of a material is 1 everywhere, its texture included. Colours of
    /// vertices may still scale it.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn material_is_opaque(&self, material: u32) -> bool {
        let Material { opacity, color_tex, .. } = &self.materials[material as usize];
        *opacity >= 1.0
            && color_tex.is_none_or(|texture| self.textures[texture as usize].is_opaque())
    }

    /// Moves the frames of cameras and instances so that `origin` becomes the origin of the world.
    ///
    /// Positions have 24 bits: 10 km from the origin they are multiples of a millimeter, and so are
    /// the error bounds by which rays leave surfaces. A scene that is far from the origin is traced
    /// more accurately if it is recentered first. The subtraction is exact for frames within half
    /// their distance from `origin`.
    pub fn recenter(&mut self, origin: Vec3A) {
        for camera in &mut self.cameras {
            camera.world_from_camera.translation -= origin;
        }
        for instance in &mut self.instances {
            instance.world_from_object.translation -= origin;
        }
    }
}

/// A shape with a material, placed in the world by a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instance {
    /// Name for messages; may be empty.
    pub name: String,
    /// Any invertible affine map; mirrored, scaled and sheared frames are allowed.
    pub world_from_object: Affine3A,
    /// Index into [`Scene::shapes`].
    pub shape: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

impl Instance {
    /// Creates an instance of a shape and a material by their indices, with the identity frame.
    #[must_use]
    pub fn new(shape: u32, material: u32) -> Self {
        Self { shape, material, ..Self::default() }
    }
}
