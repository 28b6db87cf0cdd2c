//! A scene with its trees and lights, for programs that change how it is seen.

use crate::context::Facts;
use crate::light::casts;
use crate::world::NearCache;
use crate::{Lights, World};
use glam::Vec3;
use rotund_scene::{Camera, ElementKind, Method, Overlap, Scene, SceneError, Trees};
use std::sync::Arc;

/// A scene with its trees and lights, which stay in step while methods, overlaps and cameras
/// change: what an interactive program or a series of comparisons needs.
///
/// It owns the scene, so that nothing else changes, and [`Self::world`] costs nothing: the scene
/// need not be validated again. A change does the least that it must. Of a method or camera no tree
/// is built or refitted; of a method lights are built anew only if shapes that it concerns emit or
/// are of smooth glass or metal; of an overlap trees are refitted.
///
/// ```
/// use rotund_trace::scene::{Camera, ElementKind, Material, Method, Scene, Shape};
/// use rotund_trace::{Options, Stage, View};
///
/// let mut scene = Scene::default();
/// scene.add(Shape::points([[0.0, 0.0, -3.0].into()], 1.0), Material::default());
/// scene.cameras.push(Camera::default());
/// let mut stage = Stage::new(scene)?;
/// let options = Options { samples: 1, view: View::Method, ..Options::default() };
/// let exact = stage.world().render(0, &options)?;
/// stage.set_method(ElementKind::Points, Method::Vanilla);
/// let vanilla = stage.world().render(0, &options)?;
/// assert_ne!(exact, vanilla);
/// # Ok::<(), rotund_trace::RenderError>(())
/// ```
#[derive(Debug)]
pub struct Stage {
    scene: Scene,
    trees: Trees,
    lights: Lights,
    facts: Facts,
    near: Arc<NearCache>,
}

impl Stage {
    /// Builds trees and lights on the threads of the current rayon pool, as [`World::new`] does.
    ///
    /// # Errors
    ///
    /// If [`Scene::validate`] refuses the scene.
    pub fn new(scene: Scene) -> Result<Self, SceneError> {
        let trees = Trees::build(&scene)?;
        let lights = Lights::of_valid(&scene);
        let facts = Facts::new(&scene);
        Ok(Self { scene, trees, lights, facts, near: Arc::default() })
    }

    /// Returns the scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the scene and what rendering it takes.
    #[must_use]
    pub fn world(&self) -> World<'_> {
        let near = Arc::clone(&self.near);
        World::of_stage(&self.scene, &self.trees, &self.lights, self.facts, near)
    }

    /// Sets the method of all shapes of a kind.
    pub fn set_method(&mut self, kind: ElementKind, method: Method) {
        let mut changed = vec![false; self.scene.shapes.len()];
        for (shape, changed) in self.scene.shapes.iter_mut().zip(&mut changed) {
            *changed = shape.elements.kind() == kind && shape.method != method;
            if *changed {
                shape.method = method;
            }
        }
        if !changed.contains(&true) {
            return;
        }
        self.near = Arc::default();
        self.facts = self.facts.after_methods(&self.scene);
        let matters = self.scene.instances.iter().any(|instance| {
            let material = &self.scene.materials[instance.material as usize];
            let sampled = material.emission != Vec3::ZERO || casts(material);
            changed[instance.shape as usize] && sampled
        });
        if matters {
            self.lights = Lights::of_valid(&self.scene);
        }
    }

    /// Sets for each shape, given by its index, whether its points or lines are one body.
    ///
    /// # Errors
    ///
    /// Trees of a valid scene are refitted without an error; it is passed on all the same.
    pub fn set_overlap(&mut self, of: impl Fn(usize) -> Overlap) -> Result<(), SceneError> {
        let mut changed = false;
        for (index, shape) in self.scene.shapes.iter_mut().enumerate() {
            let overlap = of(index);
            changed |= shape.overlap != overlap;
            shape.overlap = overlap;
        }
        if changed {
            self.near = Arc::default();
            self.trees.refit(&self.scene)?;
        }
        Ok(())
    }

    /// Replaces a camera, or adds one if `index` is the number of cameras.
    ///
    /// # Errors
    ///
    /// If [`Camera::validate`] refuses the camera. The scene is unchanged then.
    ///
    /// # Panics
    ///
    /// If `index` is larger than the number of cameras.
    pub fn set_camera(&mut self, index: usize, camera: Camera) -> Result<(), SceneError> {
        camera.validate()?;
        match self.scene.cameras.get_mut(index) {
            Some(place) if *place == camera => {}
            Some(place) => {
                *place = camera;
                self.near = Arc::default();
            }
            None => {
                assert_eq!(index, self.scene.cameras.len(), "the next camera");
                self.scene.cameras.push(camera);
            }
        }
        Ok(())
    }
}
