//! A scene together with what rendering it takes.

use crate::context::{Context, Facts};
use crate::near::{Near, better_origin};
use crate::{Lights, Options, RenderError, View};
use rotund_geometry::Ray;
use rotund_scene::{Camera, Scene, SceneError, SceneHit, Trees};
use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

/// A scene, the trees that rays are traced with, and the tables that lights are sampled with.
///
/// [`Self::render`] and [`Self::layers`] make pictures of it. A custom integrator traces rays by
/// [`Self::closest`] and [`Self::any`], samples [`Self::lights`], and fills a [`crate::Film`].
///
/// A world borrows its scene, so it always fits. After an edit of the scene, make a new world: from
/// nothing by [`Self::new`], or by [`Self::from_parts`] with trees that were refitted. A
/// [`crate::Stage`] does so for edits of methods, overlaps and cameras.
#[derive(Debug)]
pub struct World<'a> {
    scene: &'a Scene,
    trees: Cow<'a, Trees>,
    lights: Cow<'a, Lights>,
    facts: Facts,
    /// The scene about the far camera that was rendered last.
    near: Arc<NearCache>,
}

/// The scene about the far camera that was rendered last, if there was one.
pub(crate) type NearCache = Mutex<Option<Arc<Near>>>;

impl<'a> World<'a> {
    /// Builds trees and lights on the threads of the current rayon pool. There is no progress
    /// report before it returns.
    ///
    /// Memory, beyond that of the scene: enhanced points take about 70 bytes each at the peak, of
    /// which 35 stay. An element that emits takes another 370 at the peak, of which 320 stay, and
    /// so does a point or line of smooth glass or metal in a shape of at most 65,536. A point of
    /// smooth glass takes 130 more.
    ///
    /// # Errors
    ///
    /// If [`Scene::validate`] refuses the scene.
    pub fn new(scene: &'a Scene) -> Result<Self, SceneError> {
        let trees = Trees::build(scene)?;
        let lights = Lights::of_valid(scene);
        Ok(Self::assemble(scene, Cow::Owned(trees), Cow::Owned(lights)))
    }

    /// Puts a world together from trees and lights that exist already. They must have been built
    /// from this scene, or the trees refitted to it and the lights built anew.
    ///
    /// # Errors
    ///
    /// If [`Scene::validate`] refuses the scene, or the trees or lights are those of a scene with
    /// other numbers of shapes, elements, instances or environments. That they belong to another
    /// scene with the same numbers is not noticed; such a picture is wrong.
    pub fn from_parts(
        scene: &'a Scene,
        trees: &'a Trees,
        lights: &'a Lights,
    ) -> Result<Self, SceneError> {
        scene.validate()?;
        trees.check_counts(scene)?;
        lights.check_counts(scene)?;
        Ok(Self::assemble(scene, Cow::Borrowed(trees), Cow::Borrowed(lights)))
    }

    fn assemble(scene: &'a Scene, trees: Cow<'a, Trees>, lights: Cow<'a, Lights>) -> Self {
        Self { scene, trees, lights, facts: Facts::new(scene), near: Arc::default() }
    }

    /// Puts a world together from parts that are known to fit.
    pub(crate) fn of_stage(
        scene: &'a Scene,
        trees: &'a Trees,
        lights: &'a Lights,
        facts: Facts,
        near: Arc<NearCache>,
    ) -> Self {
        Self { scene, trees: Cow::Borrowed(trees), lights: Cow::Borrowed(lights), facts, near }
    }

    /// Returns the scene.
    #[must_use]
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Returns the trees of the scene.
    #[must_use]
    pub fn trees(&self) -> &Trees {
        &self.trees
    }

    /// Returns the lights of the scene.
    #[must_use]
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Returns a camera of the scene.
    ///
    /// # Errors
    ///
    /// If the scene has no camera of this index.
    pub fn camera(&self, index: usize) -> Result<&'a Camera, RenderError> {
        let count = self.scene.cameras.len();
        self.scene.cameras.get(index).ok_or(RenderError::NoCamera { camera: index, count })
    }

    /// Returns the first surface that a ray meets with `t` in `t_min..=t_max`.
    #[must_use]
    pub fn closest(&self, ray: &Ray) -> Option<SceneHit> {
        self.trees.closest(self.scene, ray)
    }

    /// Returns true if a ray meets any surface with `t` in `t_min..=t_max`, whatever its opacity.
    #[must_use]
    pub fn any(&self, ray: &Ray) -> bool {
        self.trees.any(self.scene, ray)
    }

    /// Returns the context of a render of the scene where it is.
    pub(crate) fn context(&self, options: &Options) -> Context<'_> {
        Context::new(self.scene, &self.trees, &self.lights, self.facts, options)
    }

    /// Returns the scene about its camera, if `options` ask for it and it gains digits.
    pub(crate) fn near(
        &self,
        camera: usize,
        options: &Options,
    ) -> Result<Option<Arc<Near>>, RenderError> {
        if !options.recenter || options.view != View::Path {
            return Ok(None);
        }
        let Some(origin) = better_origin(self.scene, self.camera(camera)?) else { return Ok(None) };
        let mut kept = self.near.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(near) = kept.as_ref().filter(|near| near.camera == camera) {
            return Ok(Some(Arc::clone(near)));
        }
        // The memory of another camera's is free before that of this one is taken.
        *kept = None;
        let near = Arc::new(Near::new(self.scene, &self.trees, camera, origin)?);
        *kept = Some(Arc::clone(&near));
        Ok(Some(near))
    }
}
