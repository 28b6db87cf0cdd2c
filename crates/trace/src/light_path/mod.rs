//! Paths that start at the lights: the light that smooth glass and metal cast on rough surfaces,
//! which paths from the camera find by chance only.
//!
//! A light path starts at a point of a light, aimed at a caster. It goes on from caster to caster
//! up to the first other surface. Every rough surface after the first caster is connected to the
//! camera, and what it sends there is added to the pixel that sees it. A path from the camera finds
//! the same light, at its end by the BSDF or by a light sample; the power heuristic weights all
//! three techniques. So a path has a light path as its twin if, seen from the camera, its first
//! vertex is rough and all others, of which there must be one, are on casters.
//!
//! A light path also ends where the path from the camera is inside of other media: where solids of
//! different glass overlap, and in glass whose colour varies over its surface ([`WayBack`]).
//!
//! The contribution of a vertex is that of the path from the camera, whose BSDF it evaluates, since
//! shading normals make scattering differ in both directions.
//!
//! Sources: E. Veach, "Robust Monte Carlo Methods for Light Transport Simulation", PhD thesis,
//! Stanford 1997, chapters 5 (adjoints) and 10 (weights); I. Georgiev, "Implementing Vertex
//! Connection and Merging", 2012 (weights from the quantities of each vertex).

#[cfg(test)]
mod tests;

use crate::context::Context;
use crate::film::Splat;
use crate::light::LightSource;
use crate::medium::{Media, Medium, WayBack};
use crate::mis::weight_of_light_path;
use crate::opacity::{SHEET_SETS, SHEETS};
use crate::sensor::Sensor;
use crate::shadow::{Departure, Target, Visible};
use crate::vertex::Vertex;
use crate::{BsdfValue, Options, Receiver, Sampler, View, warp};
use glam::{Vec2, Vec3};
use rotund_geometry::{Ray, leave_surface};
use rotund_scene::{Camera, MaterialKind, SceneHit};

/// Number of samples for each light path. A light path takes as long as a path from the camera and
/// serves all pixels, so a few of them are enough: more of them add more time to a picture than
/// they remove noise from it.
const SAMPLES: u64 = 8;
/// Number of light paths for each sample.
pub(crate) const RATE: f32 = 1.0 / SAMPLES as f32;
/// Dimension sets of a vertex. The start takes sets 0 and 1, the vertices follow.
const SETS_PER_VERTEX: u32 = 3;
/// Number of vertices after which Russian roulette may end a light path.
const ROULETTE_AFTER: u32 = 4;

/// The state of a light path between two vertices.
struct LightPath<'a> {
    context: &'a Context<'a>,
    sensor: &'a Sensor,
    sampler: Sampler,
    start: Start,
    /// The caster that the path is aimed at.
    caster: u32,
    ray: Ray,
    left: Option<u32>,
    media: Media,
    /// Radiance of the light over the density of the path, times the factors of all vertices.
    throughput: Vec3,
    /// Product of the factors of all vertices alone, which roulette goes by.
    factor: Vec3,
    /// Density of the path over that of its twin from the camera, as far as known.
    ratio: f32,
    /// Density of a light sample at the first vertex over that of the twin.
    sampled: f32,
    /// Number of the next vertex, from 1.
    number: u32,
    sheets: u32,
    /// Number of the vertex before which the path passed the last sheet.
    sheet_at: u32,
    rays: u64,
}

/// Where a light path starts.
enum Start {
    /// On a surface.
    Surface(SceneHit),
    /// In the environments, in this direction.
    Sky(Vec3),
}

impl Context<'_> {
    /// Returns the context with paths from the lights to a camera, if they find anything.
    pub(crate) fn with_light_paths(self, camera: &Camera, options: &Options) -> Self {
        let finds =
            options.view == View::Path && options.bounces > 2 && !self.lights.casters().is_empty();
        if !finds {
            return self;
        }
        let bounds = self.scene.bounds();
        let reach = 1.01 * (bounds.max - bounds.min).length();
        Self { sensor: Some(Sensor::new(camera)), reach, rate: RATE, ..self }
    }

    /// Traces the light path of a sample, if it has one; returns the number of rays traced.
    ///
    /// Light paths are numbered over all pixels, and those of consecutive numbers are stratified
    /// together, since any of them may serve any pixel.
    pub(crate) fn trace_light(
        &self,
        options: &Options,
        [x, y, sample]: [u32; 3],
        add: &mut impl FnMut(Splat),
    ) -> u64 {
        let Some(sensor) = &self.sensor else { return 0 };
        let [x, y, sample] = [x, y, sample].map(u64::from);
        let row = sample * u64::from(options.height) + y;
        let number = row * u64::from(options.width) + x;
        if !number.is_multiple_of(SAMPLES) {
            return 0;
        }
        let number = number / SAMPLES;
        let sampler = Sampler::of_light_path(options.sequence, options.seed, number);
        let path = LightPath::start(self, sensor, &sampler);
        let Some(mut path) = path else { return 0 };
        while path.step(add).is_some() {}
        path.rays
    }
}

impl<'a> LightPath<'a> {
    /// Samples the first ray.
    fn start(context: &'a Context<'a>, sensor: &'a Sensor, sampler: &Sampler) -> Option<Self> {
        let Context { scene, trees, lights, reach, .. } = *context;
        let [u, v, choice, _] = sampler.set(0);
        let [x, y, which, _] = sampler.set(1);
        let casters = lights.casters();
        let aim = casters.choose(which)?;
        let receiver = Receiver { position: aim.center, normal: None };
        let light = lights.sample(&receiver, choice, Vec2::new(u, v))?;
        let (start, ray, left) = match (lights.hit(&light), &light.source) {
            (Some(hit), Some(source)) => {
                if lights.is_covered(scene, trees, &light) {
                    return None;
                }
                let direction = casters.aim(aim.caster, source.position, Vec2::new(x, y))?;
                let origin = leave_surface(source.position, source.error, source.normal, direction);
                (Start::Surface(hit), Ray::new(origin, direction), hit.left_by(direction))
            }
            _ => {
                let (right, up) = light.incoming.any_orthonormal_pair();
                let place = aim.radius * warp::disk(Vec2::new(x, y));
                let origin = aim.center
                    + place.x * right
                    + place.y * up
                    + (reach + aim.radius) * light.incoming;
                (Start::Sky(light.incoming), Ray::new(origin, -light.incoming), None)
            }
        };
        let radiance = lights.radiance(scene, &light);
        let path = Self {
            context,
            sensor,
            sampler: *sampler,
            start,
            ray,
            left,
            media: Media::default(),
            caster: aim.caster,
            throughput: radiance,
            factor: Vec3::ONE,
            ratio: 1.0,
            sampled: 0.0,
            number: 1,
            sheets: 0,
            sheet_at: 0,
            rays: 0,
        };
        (radiance.max_element() > 0.0).then_some(path)
    }

    /// Traces the ray, connects its end to the camera, and samples the next ray; `None` at the end
    /// of the path.
    fn step(&mut self, add: &mut impl FnMut(Splat)) -> Option<()> {
        let Context { scene, trees, lights, facts, bounces, .. } = *self.context;
        self.rays += 1;
        let medium = self.media.innermost().filter(|medium| medium.scatters());
        let distance = medium.map_or(f32::INFINITY, |medium| {
            let [mut channel, mut u, ..] = self.numbers(1);
            if self.sheet_at == self.number {
                // The path has come this far without an event, so its numbers are not free.
                [_, channel, u, _] = self.sampler.set(SHEET_SETS + self.sheets - 1);
            }
            medium.sample(channel, u)
        });
        self.ray.t_max = if facts.closed { distance } else { f32::INFINITY };
        let hit = trees.closest_after(scene, &self.ray, self.left)?;
        // A light path ends where it scatters in a solid.
        if distance < hit.t {
            return None;
        }
        self.throughput *= match medium {
            Some(medium) => medium.passed(hit.t),
            None => self.media.transmittance(hit.t),
        };
        let material = scene.eval_material(hit.instance, hit.element, hit.uv);
        if material.opacity < 1.0 {
            let [chance, ..] = self.sampler.set(SHEET_SETS + self.sheets);
            self.sheets += 1;
            if self.sheets > SHEETS {
                return None;
            }
            if chance >= material.opacity {
                let direction = self.ray.direction;
                self.sheet_at = self.number;
                self.ray.origin = hit.spawn(direction).origin;
                self.left = hit.left_by(direction);
                return Some(());
            }
        }
        if material.kind == MaterialKind::Volumetric {
            return None;
        }
        let vertex = Vertex { scene, hit: &hit, material: &material };
        if !vertex.is_fixed() {
            return None;
        }
        let caster = lights.casters().caster(&hit);
        if self.number == 1 {
            if caster != Some(self.caster) {
                return None;
            }
            let density = match &self.start {
                Start::Surface(source) => lights.casters().density(lights, source, &hit),
                Start::Sky(sky) => lights.casters().density_of_sky(lights, *sky, &hit),
            };
            if density <= 0.0 {
                return None;
            }
            self.ratio = density;
            self.throughput /= density;
        } else {
            self.connect(&vertex, add);
        }
        // The last vertex and the segment to the camera follow.
        if caster.is_none() || self.number + 2 > bounces {
            return None;
        }
        self.scatter(&vertex)
    }

    /// Returns the `index`-th set of numbers of the next vertex.
    fn numbers(&self, index: u32) -> [f32; 4] {
        self.sampler.set(2 + SETS_PER_VERTEX * (self.number - 1) + index)
    }

    /// Samples the direction to the next vertex.
    fn scatter(&mut self, vertex: &Vertex<'_>) -> Option<()> {
        let (hit, to_light) = (vertex.hit, -self.ray.direction);
        let [x, y, choice, roulette] = self.numbers(0);
        let (bsdf, normal) = vertex.bsdf(to_light);
        let scattered = bsdf.sample(choice, Vec2::new(x, y))?;
        let direction = scattered.incoming;
        // The path from the camera, which comes from there.
        let (twin, of_camera) = vertex.bsdf(direction);
        if !vertex.allows(normal, to_light, direction)
            || !vertex.allows(of_camera, direction, to_light)
        {
            return None;
        }
        let turn = vertex.slant(direction) / vertex.slant(to_light);
        let factor = match scattered.pdf {
            Some(pdf) => {
                let value = twin.eval(to_light);
                if self.number == 1 {
                    self.sampled = self.density_of_light_sample(vertex, of_camera) / value.pdf;
                }
                value.value * turn / pdf
            }
            None => {
                // A refracted beam changes its cross section, and the solid angle it fills.
                let bent = (normal.dot(to_light) / normal.dot(direction)).abs();
                let refracted = normal.dot(to_light) * normal.dot(direction) < 0.0
                    && vertex.material.kind == MaterialKind::Refractive;
                let eta = match (refracted, normal.dot(to_light) > 0.0) {
                    (false, _) => 1.0,
                    (true, true) => 1.0 / vertex.material.ior,
                    (true, false) => vertex.material.ior,
                };
                scattered.weight * turn * bent * eta * eta
            }
        };
        self.ratio *= vertex.reversal(direction, to_light)?;
        if vertex.material.kind == MaterialKind::Refractive
            && hit.normal.dot(to_light) * hit.normal.dot(direction) < 0.0
        {
            let medium = Medium::new(vertex.material);
            if self.media.cross_known(hit, direction, medium) != WayBack::SameMedia {
                return None;
            }
        }
        self.throughput *= factor;
        self.factor *= factor;
        if self.number >= ROULETTE_AFTER {
            let survival = self.factor.max_element().min(0.95);
            if roulette >= survival {
                return None;
            }
            self.throughput /= survival;
            self.factor /= survival;
        }
        self.number += 1;
        (self.ray, self.left) = (hit.spawn(direction), hit.left_by(direction));
        (self.throughput.max_element() > 0.0).then_some(())
    }

    /// Returns the density per solid angle with which the twin would sample the light at a vertex.
    fn density_of_light_sample(&self, vertex: &Vertex<'_>, normal: Vec3) -> f32 {
        let lights = self.context.lights;
        let receiver = vertex.receiver(normal);
        match &self.start {
            Start::Surface(source) => lights.pdf(&receiver, source),
            Start::Sky(sky) => lights.environment_pdf(&receiver, *sky),
        }
    }

    /// Adds what a vertex sends to the camera.
    fn connect(&mut self, vertex: &Vertex<'_>, add: &mut impl FnMut(Splat)) {
        let (hit, to_light) = (vertex.hit, -self.ray.direction);
        let [x, y, ..] = self.numbers(2);
        let Some(seen) = self.sensor.see(hit.position, warp::disk(Vec2::new(x, y))) else { return };
        let wall = vertex.material.kind == MaterialKind::Refractive;
        let medium = wall.then(|| Medium::new(vertex.material));
        if !self.is_clear_towards(hit, seen.direction, medium) {
            return;
        }
        let (bsdf, normal) = vertex.bsdf(seen.direction);
        let BsdfValue { value, pdf } = bsdf.eval(to_light);
        if value == Vec3::ZERO || !vertex.allows(normal, seen.direction, to_light) {
            return;
        }
        let [shown, lit] = [seen.direction, to_light].map(|d| vertex.slant(d));
        let ratio = self.context.rate * self.ratio * lit / (seen.density * shown * pdf);
        let weight = weight_of_light_path(ratio, self.sampled);
        let radiance = self.throughput * value * (weight * shown * seen.density / lit);
        // A radiance that is NaN goes on, so that the film counts it.
        if radiance.max_element() <= 0.0 {
            return;
        }
        let departure = Departure::Surface { hit, outgoing: to_light, medium };
        let lens = LightSource { position: seen.lens, error: 0.0, normal: seen.direction };
        let target = Target { incoming: seen.direction, source: Some(&lens), borders: 0 };
        let Visible { share, rays, .. } = self.context.visibility(&departure, &target, &self.media);
        self.rays += rays;
        if share != Vec3::ZERO {
            let radiance = share * radiance;
            add(Splat { image_uv: seen.image_uv, radiance, samples: 1.0 / RATE });
        }
    }

    /// Returns whether nothing absorbs between the camera and a vertex, which is on the wall of
    /// `medium` or of none.
    ///
    /// A camera inside of a solid, or behind a wall that is there by chance, sees the vertex as if
    /// nothing were around it. A path that started inside of a solid does not know how that
    /// absorbs, and is not connected through its wall.
    fn is_clear_towards(&self, hit: &SceneHit, direction: Vec3, medium: Option<Medium>) -> bool {
        match medium {
            Some(medium)
                if hit.normal.dot(self.ray.direction) * hit.normal.dot(direction) > 0.0 =>
            {
                let mut media = self.media;
                let way_back = media.cross_known(hit, direction, medium);
                way_back == WayBack::SameMedia && media.is_clear()
            }
            _ => self.media.is_clear(),
        }
    }
}
