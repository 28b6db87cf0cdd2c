//! A scene that is ready to be rendered and probed.

use crate::error::GoldenError;
use crate::moments::Moments;
use crate::probe::Probe;
use crate::surface::Surface;
use glam::{DVec3, Vec2};
use rotund_bvh::Isa;
use rotund_scene::{Scene, Trees};
use rotund_trace::{Lights, Options, Sequence, World};

/// A scene with what rays need, seen through its first camera.
#[derive(Debug)]
pub(crate) struct Subject {
    name: String,
    pub(crate) scene: Scene,
    trees: Trees,
    lights: Lights,
}

/// How a picture is rendered.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Number of columns.
    pub(crate) width: u32,
    /// Number of rows.
    pub(crate) height: u32,
    /// Largest number of segments of a path.
    pub(crate) bounces: u32,
    /// Samples per pixel of one replica.
    pub(crate) samples: u32,
    /// Generator of the random numbers.
    pub(crate) sequence: Sequence,
}

impl Subject {
    /// Builds what rays need, for trees to be traversed with these instructions. `name` is that of
    /// the picture, for errors.
    pub(crate) fn new(name: &str, scene: Scene, isa: Isa) -> Result<Self, GoldenError> {
        let refused = |error| {
            let source = Box::new(error);
            GoldenError::Scene { name: name.to_owned(), source }
        };
        if scene.cameras.is_empty() {
            return Err(GoldenError::NoCamera { name: name.to_owned() });
        }
        let trees = Trees::build(&scene).map_err(refused)?.with_isa(isa);
        let lights = Lights::build(&scene).map_err(refused)?;
        Ok(Self { name: name.to_owned(), scene, trees, lights })
    }

    /// Returns the size of the picture whose longer side has `resolution` pixels.
    pub(crate) fn resolution(&self, resolution: u32) -> (u32, u32) {
        self.scene.cameras[0].resolution(resolution)
    }

    /// Returns what the camera sees without light.
    pub(crate) fn surface(&self, width: u32, height: u32) -> Surface {
        Surface::measure(width as usize, height as usize, |uv, ray| self.probe(uv, ray))
    }

    /// Returns the result of one ray; see [`Probe::new`].
    pub(crate) fn probe(&self, image_uv: Vec2, ray: usize) -> Probe {
        Probe::new(&self.scene, &self.trees, &self.scene.cameras[0], image_uv, ray)
    }

    /// Renders `replicas` pictures. Those of another `seed` are independent of these.
    pub(crate) fn measure(
        &self,
        plan: &Plan,
        replicas: u32,
        seed: u32,
    ) -> Result<Moments, GoldenError> {
        let failed = |error| {
            let source = Box::new(error);
            GoldenError::Render { name: self.name.clone(), source }
        };
        let world = World::from_parts(&self.scene, &self.trees, &self.lights).map_err(|error| {
            GoldenError::Scene { name: self.name.clone(), source: Box::new(error) }
        })?;
        let mut moments = Moments::empty(plan.width as usize, plan.height as usize);
        for replica in 0..replicas {
            let options = Options {
                width: plan.width,
                height: plan.height,
                samples: plan.samples,
                bounces: plan.bounces,
                seed: u64::from(seed) << 32 | u64::from(replica),
                sequence: plan.sequence,
                // The surfaces of the same picture are probed where they are.
                recenter: false,
                ..Options::default()
            };
            let film = world.render(0, &options).map_err(failed)?;
            moments.rejected += film.rejected();
            let pixels = film.image().pixels.into_iter();
            moments.push(pixels.map(|[r, g, b, _]| DVec3::new(r.into(), g.into(), b.into())));
        }
        Ok(moments.finish())
    }
}
