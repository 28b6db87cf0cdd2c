//! Light sampled through a ball of smooth glass.
//!
//! At a rough surface whose light paths cannot be connected to the camera, because it is seen in
//! glass or mirrors or by way of another rough surface, a ball and a point of a light are sampled.
//! All paths that the ball refracts between them are found. The BSDF finds the same paths; the
//! power heuristic weights both.

use super::Path;
use crate::context::Context;
use crate::light::{Beam, Crossing, End, LightSource};
use crate::medium::{Media, Medium};
use crate::shadow::{Departure, Target};
use crate::vertex::Vertex;
use crate::{Bsdf, BsdfSample, BsdfValue, Receiver, power_heuristic};
use glam::{Vec2, Vec3};
use rotund_scene::SceneHit;

/// A path that has left a rough surface for a light behind a lens.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    receiver: Receiver,
    /// The direction that the BSDF sampled, and its density per solid angle.
    direction: Vec3,
    pdf: f32,
    /// The lens that the path has entered.
    lens: Option<u32>,
    /// The path has left it.
    complete: bool,
}

impl Passage {
    /// Returns true if the path has passed the lens.
    pub(super) fn is_complete(&self) -> bool {
        self.complete
    }
}

/// Share of the light from which on a branch samples a light at each vertex. Branches with less of
/// it are nearly as many as the others, and matter less.
const FULL: f32 = 0.5;
/// Density of a light sample per steradian from which on all are used. Lights that are larger or
/// unlikely, which the BSDF finds as well, are sampled through lenses less often, in proportion.
const NARROW: f32 = 4.0;
/// Number of segments from a rough surface through a lens to a light.
const SEGMENTS: u32 = 3;

impl Path<'_> {
    /// True if light is sampled through lenses at a vertex.
    fn sees_through_lenses(&self, receiver: &Receiver) -> bool {
        let reaches_light = self.segment + SEGMENTS <= self.context.bounces;
        self.context.sensor.is_some()
            && !self.straight
            && self.reverse.is_none()
            && receiver.normal.is_some()
            && reaches_light
            && self.media.is_outside()
            && !self.context.lights.lenses().is_empty()
    }

    /// Returns the probability that a light is sampled through a lens at a vertex.
    fn effort(&self) -> f32 {
        (self.share / FULL).min(1.0)
    }

    /// Samples a light through a lens and adds its contribution.
    pub(super) fn gather_through_lens(
        &mut self,
        receiver: &Receiver,
        vertex: &Vertex<'_>,
        bsdf: &Bsdf,
    ) {
        if !self.sees_through_lenses(receiver) {
            return;
        }
        let Context { scene, trees, lights, .. } = *self.context;
        let lenses = lights.lenses();
        // Only paths inside of a medium take numbers of this set else.
        let [x, y, choice, which] = self.numbers(2);
        let effort = self.effort();
        if which >= effort {
            return;
        }
        let Some(chosen) = lenses.choose(receiver, which / effort) else { return };
        let at_lens = lenses.receiver(chosen.number);
        let Some(light) = lights.sample(&at_lens, choice, Vec2::new(x, y)) else { return };
        let end = match &light.source {
            Some(source) => End::Point(source.position),
            None => End::Sky(light.incoming),
        };
        let narrow = narrowness(light.pdf);
        // The last number of this set is free.
        let [.., chance] = self.numbers(0);
        if chance >= narrow {
            return;
        }
        let effort = effort * narrow;
        let sampled = light.source.as_ref();
        for crossing in lenses.get(chosen.number).crossings(receiver.position, end) {
            let BsdfValue { value, pdf } = bsdf.eval(crossing.direction);
            if value == Vec3::ZERO {
                continue;
            }
            let to_light = |source: &LightSource| (source.position - crossing.exit).normalize();
            let incoming = sampled.map_or(light.incoming, to_light);
            let density = lenses.density(&chosen, light.pdf, sampled.map(|at| (at, incoming)));
            let density = effort * density / crossing.beam.spread;
            if !(density > 0.0 && density.is_finite()) {
                continue;
            }
            let Some(wall) = self.far_wall(vertex.hit, chosen.number, &crossing) else { continue };
            let departure = Departure::Surface {
                hit: &wall.hit,
                outgoing: -wall.arriving,
                medium: Some(wall.medium),
            };
            let target = Target { incoming, source: sampled, borders: 0 };
            let seen = self.context.visibility(&departure, &target, &wall.media);
            self.arrived.rays += seen.rays;
            if seen.share == Vec3::ZERO || lights.is_covered(scene, trees, &light) {
                continue;
            }
            let Beam { transmitted, .. } = crossing.beam;
            let weight = power_heuristic(density, transmitted * pdf) * transmitted / density;
            let share = wall.transmittance * seen.share;
            let radiance = lights.radiance(scene, &light);
            self.arrived.radiance += self.throughput * share * weight * value * radiance;
        }
    }

    /// Traces a path through a lens up to where it leaves, or returns `None` if something is in the
    /// way.
    fn far_wall(&mut self, from: &SceneHit, lens: u32, crossing: &Crossing) -> Option<Wall> {
        let Context { scene, trees, lights, .. } = *self.context;
        let mut meet = |from: &SceneHit, direction: Vec3| {
            self.arrived.rays += 1;
            let ray = from.spawn(direction);
            let hit = trees.closest_after(scene, &ray, from.left_by(direction))?;
            (lights.lenses().lens(&hit) == Some(lens)).then_some(hit)
        };
        let near = meet(from, crossing.direction)?;
        let arriving = (crossing.exit - near.position).try_normalize()?;
        let hit = meet(&near, arriving)?;
        let medium = Medium::new(&scene.eval_material(near.instance, near.element, near.uv));
        let mut media = self.media;
        media.cross(&near, arriving, medium);
        let transmittance = media.transmittance(hit.t);
        let medium = Medium::new(&scene.eval_material(hit.instance, hit.element, hit.uv));
        Some(Wall { hit, arriving, medium, media, transmittance })
    }

    /// Returns what becomes of [`Self::passage`] if the path goes on from a vertex.
    pub(super) fn passed(
        &self,
        receiver: &Receiver,
        vertex: &Vertex<'_>,
        scattered: &BsdfSample,
    ) -> Option<Passage> {
        let direction = scattered.incoming;
        if let Some(pdf) = scattered.pdf {
            let start =
                Passage { receiver: *receiver, direction, pdf, lens: None, complete: false };
            return self.sees_through_lenses(receiver).then_some(start);
        }
        let passage = self.passage.filter(|passage| !passage.complete)?;
        let lens = self.context.lights.lenses().lens(vertex.hit)?;
        let normal = vertex.hit.normal;
        let refracted = normal.dot(self.ray.direction) * normal.dot(direction) > 0.0;
        let entered = passage.lens.is_none_or(|entered| entered == lens);
        let complete = passage.lens.is_some();
        (refracted && entered).then_some(Passage { lens: Some(lens), complete, ..passage })
    }

    /// Returns the weight of light that the path has found through a lens at `source`, or in the
    /// environments; `None` if light samples through lenses find none of this path.
    pub(super) fn weight_through(&self, source: Option<&SceneHit>) -> Option<f32> {
        let &Passage { ref receiver, direction, pdf, lens, .. } =
            self.passage.as_ref().filter(|passage| passage.is_complete())?;
        let (lights, incoming) = (self.context.lights, self.ray.direction);
        let lenses = lights.lenses();
        let chosen = lenses.chosen(receiver, lens?);
        let at_lens = lenses.receiver(chosen.number);
        let (end, sampled) = match source {
            Some(hit) => (End::Point(hit.position), lights.pdf(&at_lens, hit)),
            None => (End::Sky(incoming), lights.environment_pdf(&at_lens, incoming)),
        };
        let beam = lenses.get(chosen.number).beam(receiver.position, direction, end)?;
        let at = source.map(|&SceneHit { position, normal, error, .. }| LightSource {
            position,
            normal,
            error,
        });
        let effort = self.effort() * narrowness(sampled);
        let density = lenses.density(&chosen, sampled, at.as_ref().map(|at| (at, incoming)));
        let found = if density > 0.0 { effort * density / beam.spread } else { 0.0 };
        Some(power_heuristic(beam.transmitted * pdf, found))
    }
}

/// Returns the probability that a light sample of a density per solid angle is used.
fn narrowness(pdf: f32) -> f32 {
    (pdf / NARROW).min(1.0)
}

/// The point where a path leaves a lens.
struct Wall {
    hit: SceneHit,
    /// Direction from inside.
    arriving: Vec3,
    /// The medium inside, and the stack with it.
    medium: Medium,
    media: Media,
    /// Transmittance from wall to wall.
    transmittance: Vec3,
}
