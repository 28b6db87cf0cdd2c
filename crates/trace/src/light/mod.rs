//! Light sources, and importance sampling of them.

mod casters;
mod emitter;
mod environment;
mod flat;
mod lens;
mod lenses;
mod mosaic;
mod owners;
mod rectangle;
mod round;
mod spherical_triangle;
#[cfg(test)]
mod tests;
mod tree;

pub(crate) use casters::{Casters, casts};
use emitter::Emitter;
use environment::EnvironmentLights;
use glam::{Vec2, Vec3};
pub(crate) use lens::{Beam, Crossing, End};
use lenses::Lenses;
use owners::Owners;
use rotund_geometry::{Ray, UNIT_ROUNDOFF, leave_surface};
use rotund_scene::{Instance, Scene, SceneError, SceneHit, SceneItem, Trees};
pub use tree::Receiver;
use tree::{Extent, LightTree};

/// The light sources of a scene, in tables that importance-sample them from any point, and the
/// surfaces of smooth glass and metal, which light paths are aimed at.
///
/// # Direct illumination with multiple importance sampling
///
/// An estimator of direct illumination samples one direction from the lights and one from the BSDF.
/// The first is weighted with the density of the second and the other way round, so that the sum
/// has no bias:
///
/// ```
/// use glam::{Vec2, Vec3};
/// use rotund_scene::SceneHit;
/// use rotund_trace::{Bsdf, Receiver, Sampler, World, power_heuristic};
///
/// /// Radiance that the surface point sends to `outgoing` by direct illumination.
/// fn direct(world: &World<'_>, hit: &SceneHit, outgoing: Vec3, sampler: &Sampler) -> Vec3 {
///     let (scene, lights) = (world.scene(), world.lights());
///     let material = scene.eval_material(hit.instance, hit.element, hit.uv);
///     let normal = scene.shading_normal(hit, outgoing);
///     let bsdf = Bsdf::new(&material, normal, outgoing);
///     let receiver = Receiver { position: hit.position, normal: Some(normal) };
///     let mut sum = material.emission;
///
///     // From the lights, unless the BSDF is a set of delta directions.
///     let [x, y, choice, _] = sampler.set(1);
///     if !bsdf.is_delta()
///         && let Some(light) = lights.sample(&receiver, choice, Vec2::new(x, y))
///         && !world.any(&light.shadow_ray(hit))
///     {
///         let f = bsdf.eval(light.incoming);
///         let weight = power_heuristic(light.pdf, f.pdf) / light.pdf;
///         sum += weight * f.value * lights.radiance(scene, &light);
///     }
///
///     // From the BSDF. `pdf` is `None` for a delta direction, which the lights cannot sample.
///     let [x, y, choice, _] = sampler.set(2);
///     if let Some(scattered) = bsdf.sample(choice, Vec2::new(x, y)) {
///         let ray = hit.spawn(scattered.incoming);
///         let (radiance, light_pdf) = match world.closest(&ray) {
///             Some(far) => (
///                 scene.eval_emission(far.instance, far.element, far.uv),
///                 lights.pdf(&receiver, &far),
///             ),
///             None => (
///                 scene.eval_environment(ray.direction),
///                 lights.environment_pdf(&receiver, ray.direction),
///             ),
///         };
///         let weight = scattered.pdf.map_or(1.0, |pdf| power_heuristic(pdf, light_pdf));
///         sum += weight * scattered.weight * radiance;
///     }
///     sum
/// }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Lights {
    emitters: Vec<Emitter>,
    tree: LightTree,
    /// For each instance, the number of its first emitter, if it has emitters.
    first_emitter: Vec<Option<u32>>,
    environments: EnvironmentLights,
    brightest: f32,
    casters: Casters,
    lenses: Lenses,
}

/// A receiver, and what all queries about it need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    pub(crate) receiver: Receiver,
    /// The result of [`Lights::environment_chance`].
    pub(crate) environment_chance: f32,
}

/// A direction sampled from the lights.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Direction from the receiver to the light, of unit length.
    pub incoming: Vec3,
    /// Density of `incoming` per solid angle at the receiver, over all lights: the probability of
    /// this light is in it.
    pub pdf: f32,
    /// Point on the light, or `None` for an environment, which is infinitely far away.
    pub source: Option<LightSource>,
    /// Number of the emitter, and parameters of the point on it unless it is round.
    emitter: Option<(u32, Option<Vec2>)>,
}

/// A point on an emitting surface, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSource {
    /// The point, within `error` of the surface.
    pub position: Vec3,
    /// Bound on the distance from the exact surface.
    pub error: f32,
    /// Geometric normal of the surface, of unit length.
    pub normal: Vec3,
}

impl LightSample {
    /// Returns the ray from a surface point to the light, for [`crate::World::any`]: it meets
    /// neither the surface that it leaves nor the light that it goes to.
    #[must_use]
    pub fn shadow_ray(&self, hit: &SceneHit) -> Ray {
        self.shadow_ray_from(hit.spawn(self.incoming).origin)
    }

    /// Returns the ray from a point that lies on no surface to the light; see [`Self::shadow_ray`].
    #[must_use]
    pub fn shadow_ray_from(&self, origin: Vec3) -> Ray {
        match self.source {
            None => Ray::new(origin, self.incoming),
            Some(source) => source.shadow_ray(source.end(self.incoming), origin),
        }
    }
}

impl LightSource {
    /// Returns the point off the surface at which rays from direction `incoming` end.
    pub(crate) fn end(&self, incoming: Vec3) -> Vec3 {
        leave_surface(self.position, self.error, self.normal, -incoming)
    }

    /// Returns the ray from `origin` to [`Self::end`].
    pub(crate) fn shadow_ray(&self, end: Vec3, origin: Vec3) -> Ray {
        // Both ends leave their surfaces. How far along the ray an end is off its surface can be
        // less than the rounding of `t`, which is some units in the last place.
        Ray { t_max: 1.0 - 32.0 * UNIT_ROUNDOFF, ..Ray::new(origin, end - origin) }
    }
}

/// Relative luminance of linear Rec. 709 red, green and blue.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

impl Lights {
    /// Collects the lights of a scene: every element of an instance whose material emits, and every
    /// environment with an image that is not constant.
    ///
    /// Some lights are never sampled, and [`Self::pdf`] is 0 for them: vanilla points and lines,
    /// whose surface depends on the ray; spheres and cones under a transform that deforms them; and
    /// constant environments. BSDF sampling finds them with MIS weight 1, so the estimator stays
    /// unbiased.
    ///
    /// A surface that several elements have, such as the ball between two lines, is sampled as part
    /// of the first of them, which is the one that rays hit.
    ///
    /// # Errors
    ///
    /// If [`Scene::validate`] refuses the scene.
    pub fn build(scene: &Scene) -> Result<Self, SceneError> {
        scene.validate()?;
        Ok(Self::of_valid(scene))
    }

    /// [`Self::build`] for a scene that has been validated.
    pub(crate) fn of_valid(scene: &Scene) -> Self {
        let (mut emitters, mut owners) = (Vec::new(), Owners::default());
        let first_emitter = (0..scene.instances.len() as u32)
            .map(|index| emitter::add_instance(scene, index, &mut owners, &mut emitters))
            .collect();
        drop(owners);
        let extents: Vec<Extent> = emitters.iter().map(Emitter::extent).collect();
        let mut lights = Self {
            tree: LightTree::new(&extents),
            emitters,
            first_emitter,
            environments: EnvironmentLights::new(scene),
            brightest: brightest(scene),
            casters: Casters::default(),
            lenses: Lenses::default(),
        };
        lights.casters = Casters::new(scene, &lights);
        lights.lenses = Lenses::new(scene, &lights);
        lights
    }

    /// Checks that a scene has as many instances and environments as the one of the lights, and
    /// each instance with emitters or casters as many elements: all that indices rely on.
    pub(crate) fn check_counts(&self, scene: &Scene) -> Result<(), SceneError> {
        for (what, before, now) in [
            ("instances", self.first_emitter.len(), scene.instances.len()),
            ("environments", self.environments.len(), scene.environments.len()),
        ] {
            if before != now {
                return Err(SceneError::LightsChanged { item: None, what, before, now });
            }
        }
        for (index, before) in self.emitter_counts().chain(self.casters.counts()) {
            let instance = &scene.instances[index];
            let now = scene.shapes[instance.shape as usize].elements.count();
            if before != now {
                let name = instance.name.clone();
                let item = Some(SceneItem { array: "instances", index, name });
                return Err(SceneError::LightsChanged { item, what: "elements", before, now });
            }
        }
        Ok(())
    }

    /// Returns the index of each instance with emitters, and their number.
    fn emitter_counts(&self) -> impl Iterator<Item = (usize, usize)> {
        let firsts = || {
            let numbered = self.first_emitter.iter().enumerate();
            numbered.filter_map(|(index, first)| first.map(|first| (index, first as usize)))
        };
        let ends = firsts().skip(1).map(|(_, first)| first).chain([self.emitters.len()]);
        firsts().zip(ends).map(|((index, first), end)| (index, end - first))
    }

    /// Returns a bound on the radiance of every light in each channel, and so of every pixel.
    pub(crate) fn brightest(&self) -> f32 {
        self.brightest
    }

    /// Returns an estimate of the light that arrives at a receiver, without occlusion.
    fn arriving(&self, receiver: &Receiver) -> f32 {
        self.tree.importance(receiver) + 0.5 * self.environments.power()
    }

    /// Returns the point of a sampled light as a hit of a ray, for [`Self::pdf`]; `None` for an
    /// environment. Round emitters have no parameters here.
    pub(crate) fn hit(&self, light: &LightSample) -> Option<SceneHit> {
        let (Some((emitter, uv)), Some(source)) = (light.emitter, &light.source) else {
            return None;
        };
        let LightSource { position, normal, error } = *source;
        let (instance, element) = self.emitters[emitter as usize].element();
        let uv = uv.unwrap_or_default();
        Some(SceneHit { instance, element, uv, t: 0.0, position, normal, error })
    }

    /// Returns the surfaces that pass light on.
    pub(crate) fn casters(&self) -> &Casters {
        &self.casters
    }

    /// Returns the balls of smooth glass.
    pub(crate) fn lenses(&self) -> &Lenses {
        &self.lenses
    }

    /// Prepares a receiver for several queries.
    pub(crate) fn aim(&self, receiver: &Receiver) -> Aim {
        Aim { receiver: *receiver, environment_chance: self.environment_chance(receiver) }
    }

    /// Returns the probability that an environment is sampled rather than an emitter.
    pub(crate) fn environment_chance(&self, receiver: &Receiver) -> f32 {
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

    /// Samples a direction to a light: `choice` picks the light, `u` the point on it, both uniform
    /// in `0.0..1.0`. Returns `None` if no light can illuminate the receiver, or the sampled one
    /// does not: this is a sample of value zero; keep it in the mean.
    ///
    /// Occlusion is not tested: see [`LightSample::shadow_ray`]. The direction may lie below the
    /// horizon of the receiver, where the BSDF is zero.
    #[must_use]
    pub fn sample(&self, receiver: &Receiver, choice: f32, u: Vec2) -> Option<LightSample> {
        self.sample_for(&self.aim(receiver), choice, u)
    }

    /// [`Self::sample`] for a receiver that is prepared.
    pub(crate) fn sample_for(&self, aim: &Aim, choice: f32, u: Vec2) -> Option<LightSample> {
        let Aim { receiver, environment_chance } = aim;
        if choice < *environment_chance {
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

    /// Returns the radiance that a sampled light sends to the receiver if nothing occludes it.
    /// Texture look-ups are expensive, so ask after the shadow ray.
    ///
    /// # Panics
    ///
    /// If `scene` is not the scene that the lights were built from, and lacks an index of theirs.
    #[must_use]
    pub fn radiance(&self, scene: &Scene, light: &LightSample) -> Vec3 {
        match (light.emitter, &light.source) {
            (Some((emitter, uv)), Some(source)) => {
                self.emitters[emitter as usize].radiance(scene, uv, source)
            }
            _ => scene.eval_environment(light.incoming),
        }
    }

    /// Returns whether the sampled point lies inside the body that it is part of, where it does not
    /// shine.
    pub(crate) fn is_covered(&self, scene: &Scene, trees: &Trees, light: &LightSample) -> bool {
        let (Some((emitter, _)), Some(source)) = (light.emitter, &light.source) else {
            return false;
        };
        let LightSource { position, normal, error } = *source;
        trees.covers(scene, self.emitters[emitter as usize].element(), position, normal, error)
    }

    /// Returns the radiance of a direction that leads out of the scene, and the density per solid
    /// angle with which [`Self::sample`] samples it.
    pub(crate) fn environment(
        &self,
        scene: &Scene,
        aim: Option<&Aim>,
        direction: Vec3,
    ) -> (Vec3, f32) {
        let (radiance, pdf) = self.environments.radiance_and_pdf(scene, direction);
        let chance = aim.map_or(0.0, |aim| aim.environment_chance);
        (radiance, chance * pdf)
    }

    /// Returns the density per solid angle with which [`Self::sample`] samples a direction, of unit
    /// length, that leads out of the scene to the environments; 0 if all of them are constant.
    #[must_use]
    pub fn environment_pdf(&self, receiver: &Receiver, direction: Vec3) -> f32 {
        self.environment_chance(receiver) * self.environments.pdf(direction)
    }

    /// Returns the density per solid angle at the receiver with which [`Self::sample`] samples the
    /// direction to a surface point `hit`, which must be the first surface in that direction; 0 if
    /// the surface does not emit or is never sampled.
    ///
    /// # Panics
    ///
    /// If the hit is not of the scene that the lights were built from, and its index is out of
    /// range.
    #[must_use]
    pub fn pdf(&self, receiver: &Receiver, hit: &SceneHit) -> f32 {
        self.emitter(hit).map_or(0.0, |index| self.pdf_of(index, &self.aim(receiver), hit))
    }

    /// [`Self::pdf`] for a receiver that is prepared.
    pub(crate) fn pdf_for(&self, aim: &Aim, hit: &SceneHit) -> f32 {
        self.emitter(hit).map_or(0.0, |index| self.pdf_of(index, aim, hit))
    }

    /// Returns the index of the emitter that samples a surface point, if any does.
    fn emitter(&self, hit: &SceneHit) -> Option<u32> {
        let index = self.first_emitter[hit.instance as usize]? + hit.element;
        let index = index - u32::from(self.emitters[index as usize].is_second_half());
        (self.emitters[index as usize].power > 0.0).then_some(index)
    }

    fn pdf_of(&self, emitter: u32, aim: &Aim, hit: &SceneHit) -> f32 {
        let Aim { receiver, environment_chance } = aim;
        (1.0 - environment_chance)
            * self.tree.chance(receiver, emitter)
            * self.emitters[emitter as usize].pdf(receiver.position, hit)
    }
}

/// Returns the largest channel of all lights of a scene, all environments together.
fn brightest(scene: &Scene) -> f32 {
    let of_texture = |index: Option<u32>| {
        index.map_or(Vec3::ONE, |index| scene.textures[index as usize].brightest())
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
