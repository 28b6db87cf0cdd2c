//! Scenes far from the origin, moved to it.

use crate::Lights;
use crate::context::Facts;
use glam::Vec3A;
use rotund_scene::{Camera, Scene, SceneError, Trees};

/// A scene with its camera at the origin.
#[derive(Debug)]
pub(crate) struct Near {
    /// Index of the camera.
    pub(crate) camera: usize,
    pub(crate) scene: Scene,
    pub(crate) trees: Trees,
    pub(crate) lights: Lights,
    pub(crate) facts: Facts,
}

/// Distance of the origin from the camera, in multiples of that of the farthest instance, above
/// which the scene is moved. Positions have lost four bits there, which is not visible yet, so
/// pictures of ordinary scenes do not depend on it.
const FAR: f32 = 16.0;

/// Returns the point that should be the origin, if the actual origin is so far from the camera that
/// positions lose digits.
pub(crate) fn better_origin(scene: &Scene, camera: &Camera) -> Option<Vec3A> {
    let eye = camera.world_from_camera.translation;
    let frames = scene.instances.iter().map(|instance| instance.world_from_object.translation);
    let reach = frames.map(|place| place.distance(eye)).fold(0.0, f32::max);
    (eye.length() > FAR * reach).then_some(eye)
}

impl Near {
    /// Moves a scene, and its trees with it, which keeps how they are walked.
    pub(crate) fn new(
        scene: &Scene,
        trees: &Trees,
        camera: usize,
        origin: Vec3A,
    ) -> Result<Self, SceneError> {
        let mut scene = scene.clone();
        scene.recenter(origin);
        let mut trees = trees.clone();
        trees.refit(&scene)?;
        let lights = Lights::of_valid(&scene);
        let facts = Facts::new(&scene);
        Ok(Self { camera, scene, trees, lights, facts })
    }
}
