//! Light sources, and how they are drawn.

mod emitter;
mod environment;
mod flat;
mod mosaic;
mod rectangle;
mod round;
mod spherical_triangle;
#[cfg(test)]
mod tests;
mod tree;

use emitter::Emitter;
use environment::EnvironmentLights;
use glam::{Vec2, Vec3};
use rotund_scene::{Instance, Scene, SceneHit};
pub(crate) use tree::Receiver;
use tree::{Extent, LightTree};

/// All light sources of a scene, ready to be drawn from any point.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    emitters: Vec<Emitter>,
    tree: LightTree,
    /// For each instance, where the emitters of its elements begin, if it has emitters.
    first_emitter: Vec<Option<u32>>,
    environments: EnvironmentLights,
    brightest: f32,
}

/// A drawn direction to a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    /// Of unit length.
    pub(crate) incoming: Vec3,
    /// Per solid angle.
    pub(crate) pdf: f32,
    /// Where the light comes from; none is infinitely far away.
    pub(crate) source: Option<LightSource>,
    /// The emitter, and what it calls the point.
    emitter: Option<(u32, Vec2)>,
}

/// A point on an emitter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSource {
    pub(crate) position: Vec3,
    /// Bound on the distance from the exact surface.
    pub(crate) error: f32,
    pub(crate) normal: Vec3,
}

/// Relative luminance of linear Rec. 709 red, green and blue.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

impl Lights {
    /// Finds all that shines in a scene: every element of an instance whose material emits, and
    /// every environment that an image makes uneven.
    ///
    /// Not drawn, but right all the same since paths that hit them count in full: vanilla points and
    /// lines, whose surface depends on where they are seen from, spheres and cones under a
    /// transform that makes them neither, and constant environments.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        let mut emitters = Vec::new();
        let first_emitter = (0..scene.instances.len())
            .map(|instance| {
                let of_instance = emitter::of_instance(scene, instance as u32)?;
                let first = emitters.len() as u32;
                emitters.extend(of_instance);
                Some(first)
            })
            .collect();
        let extents: Vec<Extent> = emitters.iter().map(Emitter::extent).collect();
        Self {
            tree: LightTree::new(&extents),
            emitters,
            first_emitter,
            environments: EnvironmentLights::new(scene),
            brightest: brightest(scene),
        }
    }

    /// A bound on the radiance of any channel of what shines, and so of any pixel.
    pub(crate) fn brightest(&self) -> f32 {
        self.brightest
    }

    /// The chance that an environment is drawn rather than an emitter.
    fn environment_chance(&self, receiver: &Receiver) -> f32 {
        // Both are estimates of irradiance; half of an environment is below the horizon.
        let environments = 0.5 * self.environments.power();
        if environments <= 0.0 {
            return 0.0;
        }
        let emitters = self.tree.importance(receiver);
        if emitters <= 0.0 {
            1.0
        } else {
            // Either estimate can be wrong, above all about occlusion.
            (environments / (environments + emitters)).clamp(0.1, 0.9)
        }
    }

    /// Draws a direction: `choice` picks the light, `u` the point on it.
    pub(crate) fn sample(&self, receiver: &Receiver, choice: f32, u: Vec2) -> Option<LightSample> {
        let environment_chance = self.environment_chance(receiver);
        if choice < environment_chance {
            let (incoming, pdf) = self.environments.sample(u)?;
            return Some(LightSample {
                incoming,
                pdf: environment_chance * pdf,
                source: None,
                emitter: None,
            });
        }
        let choice = (choice - environment_chance) / (1.0 - environment_chance);
        let (emitter, chance) = self.tree.choose(receiver, choice)?;
        let point = self.emitters[emitter as usize].sample(receiver.position, u);
        let point = point.as_ref()?;
        Some(LightSample {
            incoming: (point.source.position - receiver.position).try_normalize()?,
            pdf: (1.0 - environment_chance) * chance * point.pdf,
            source: Some(point.source),
            emitter: Some((emitter, point.uv)),
        })
    }

    /// What arrives from a drawn direction if nothing is in the way. Looking images up takes long, so
    /// it waits until the light is known to arrive.
    pub(crate) fn radiance(&self, scene: &Scene, light: &LightSample) -> Vec3 {
        match light.emitter {
            Some((emitter, uv)) => self.emitters[emitter as usize].radiance(scene, uv),
            None => scene.eval_environment(light.incoming),
        }
    }

    /// What comes from a direction that leads out of the scene, and the density with which [`Self::sample`]
    /// would have found it.
    pub(crate) fn environment(
        &self,
        scene: &Scene,
        receiver: Option<&Receiver>,
        direction: Vec3,
    ) -> (Vec3, f32) {
        let (radiance, pdf) = self.environments.radiance_and_pdf(scene, direction);
        let chance = receiver.map_or(0.0, |receiver| self.environment_chance(receiver));
        (radiance, chance * pdf)
    }

    /// The density per solid angle with which [`Self::sample`] would have found this point; zero
    /// if it never does.
    pub(crate) fn hit_pdf(&self, receiver: &Receiver, hit: &SceneHit) -> f32 {
        let Some(first) = self.first_emitter[hit.instance as usize] else { return 0.0 };
        let mut index = first + hit.element;
        index -= u32::from(self.emitters[index as usize].is_second_half());
        let emitter = &self.emitters[index as usize];
        if emitter.power <= 0.0 {
            return 0.0;
        }
        (1.0 - self.environment_chance(receiver))
            * self.tree.chance(receiver, index)
            * emitter.pdf(receiver.position, hit)
    }
}

/// The largest channel of all that shines in a scene, all environments together.
fn brightest(scene: &Scene) -> f32 {
    let of_texture = |index: Option<u32>| {
        let Some(index) = index else { return Vec3::ONE };
        let texture = &scene.textures[index as usize];
        let places = (0..texture.height).flat_map(|y| (0..texture.width).map(move |x| (x, y)));
        let colors = places.map(|(x, y)| texture.color_at(x, y).truncate());
        colors.fold(Vec3::ZERO, Vec3::max)
    };
    let sky: Vec3 =
        scene.environments.iter().map(|sky| sky.emission * of_texture(sky.emission_tex)).sum();
    let of_instance = |instance: &Instance| {
        let material = &scene.materials[instance.material as usize];
        if material.emission == Vec3::ZERO {
            return 0.0;
        }
        let colors = &scene.shapes[instance.shape as usize].colors;
        let vertices = colors.iter().map(|color| color.truncate()).reduce(Vec3::max);
        let emission = material.emission * of_texture(material.emission_tex);
        (emission * vertices.unwrap_or(Vec3::ONE)).max_element()
    };
    scene.instances.iter().map(of_instance).fold(sky.max_element(), f32::max)
}
