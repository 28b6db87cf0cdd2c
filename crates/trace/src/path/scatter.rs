//! Scattering at a vertex of a path: direct illumination, and the direction that goes on.

use super::reverse::crosses_both_ways;
use super::{BRANCHES, END_BELOW, MATTE_BELOW, Next, Origin, Path};
use crate::context::{Arrived, Context};
use crate::light::Aim;
use crate::medium::Medium;
use crate::mis::weight_of_light_sample;
use crate::shadow::{Departure, Target, Visible};
use crate::vertex::{Vertex, sides_agree};
use crate::{Bsdf, BsdfSample, Receiver, phase, power_heuristic};
use glam::{Vec2, Vec3};
use rotund_geometry::Ray;
use rotund_scene::{MaterialKind, MaterialPoint, SceneHit};

impl Path<'_> {
    /// Samples a light and adds its contribution. `scatter` returns the value of the BSDF or phase
    /// function for a direction, and the density with which it would be sampled.
    fn gather_light(
        &mut self,
        aim: &Aim,
        departure: &Departure<'_>,
        vertex: Option<&Vertex<'_>>,
        [x, y, choice, _]: [f32; 4],
        scatter: impl Fn(Vec3) -> (Vec3, f32),
    ) {
        let Context { scene, trees, lights, bounces, furnace, .. } = self.context;
        if *furnace {
            return;
        }
        // Results are borrowed where they were written: a copy right after the store stalls on
        // store-to-load forwarding.
        let sampled = lights.sample_for(aim, choice, Vec2::new(x, y));
        let Some(light) = &sampled else { return };
        let (value, pdf) = scatter(light.incoming);
        if value == Vec3::ZERO {
            return;
        }
        let target = Target {
            incoming: light.incoming,
            source: light.source.as_ref(),
            borders: bounces - self.segment - 1,
        };
        let seen = self.context.visibility(departure, &target, &self.media);
        let Visible { share, rays, clouds } = seen;
        self.arrived.rays += rays;
        if share != Vec3::ZERO && !lights.is_covered(scene, trees, light) {
            let radiance = lights.radiance(scene, light);
            let found = vertex.filter(|_| !clouds);
            let found = found.and_then(|vertex| self.found_with(vertex, light, pdf));
            let weight = found.map_or_else(
                || power_heuristic(light.pdf, pdf),
                |found| weight_of_light_sample(light.pdf / pdf, found),
            );
            let weight = weight / light.pdf;
            self.arrived.radiance += self.throughput * share * weight * value * radiance;
        }
    }

    /// Scatters in a medium after a distance, with the numbers of a vertex.
    pub(super) fn scatter_inside(
        &mut self,
        medium: &Medium,
        distance: f32,
        [of_light, [x, y, chance, roulette]]: [[f32; 4]; 2],
    ) -> Next {
        self.arrived.covered = true;
        if self.segment == self.context.bounces {
            return Next::End;
        }
        let factor = medium.scattered(distance);
        let survival = if self.part { factor.max_element().min(1.0) } else { 1.0 };
        if chance >= survival {
            return Next::End;
        }
        self.throughput *= factor / survival;
        let (position, outgoing) = (self.ray.at(distance), -self.ray.direction);
        let g = medium.anisotropy;
        // The refracting wall blocks direct illumination from outside.
        let lit = !medium.walled || self.context.facts.lit_inside;
        let incoming = phase::sample(g, outgoing, Vec2::new(x, y));
        self.origin = lit.then(|| {
            let aim = self.context.lights.aim(&Receiver { position, normal: None });
            let departure = Departure::Inside(position);
            self.gather_light(&aim, &departure, None, of_light, |incoming| {
                let density = phase::henyey_greenstein(g, outgoing, incoming);
                (Vec3::splat(density), density)
            });
            Origin { aim, pdf: phase::henyey_greenstein(g, outgoing, incoming) }
        });
        (self.reverse, self.passage) = (None, None);
        self.smooth = false;
        self.continue_along(Ray::new(position, incoming), None, END_BELOW, roulette)
    }

    pub(super) fn scatter_at(&mut self, hit: &SceneHit, material: &MaterialPoint) -> Next {
        let outgoing = -self.ray.direction;
        let vertex = Vertex { scene: self.context.scene, hit, material };
        let [of_light, [x, y, choice, roulette]] = self.numbers_of_vertex();
        let normal = vertex.shading_normal(outgoing);
        let bsdf = Bsdf::new(material, normal, outgoing);
        // Filled in where it stays, for the reason below.
        let mut aim = Aim { receiver: vertex.receiver(normal), environment_chance: 0.0 };
        let medium = (material.kind == MaterialKind::Refractive).then(|| Medium::new(material));
        if !bsdf.is_delta() {
            aim.environment_chance = self.context.lights.environment_chance(&aim.receiver);
            let departure = Departure::Surface { hit, outgoing, medium };
            self.gather_light(&aim, &departure, Some(&vertex), of_light, |incoming| {
                let value = bsdf.eval(incoming);
                let allowed = vertex.allows(normal, outgoing, incoming);
                (if allowed { value.value } else { Vec3::ZERO }, value.pdf)
            });
            self.gather_through_lens(&aim.receiver, &vertex, &bsdf);
        }
        let end_below = if material.kind == MaterialKind::Matte { MATTE_BELOW } else { END_BELOW };
        let wall = Wall { hit, outgoing, medium, normal, end_below };
        if self.smooth
            && let Some((both, f)) = bsdf.both()
        {
            return self.branch(&wall, &both, f, choice, roulette);
        }
        let sampled = bsdf.sample(choice, Vec2::new(x, y));
        let Some(scattered) = &sampled else { return Next::End };
        self.smooth &= scattered.pdf.is_none();
        // Written in place: a copy of the optional result stalls on store-to-load forwarding.
        match scattered.pdf {
            Some(pdf) => self.origin = Some(Origin { aim, pdf }),
            None => self.origin = None,
        }
        // In scenes without light paths both stay `None`.
        if self.context.sensor.is_some() {
            self.passage = self.passed(&aim.receiver, &vertex, scattered);
            self.reverse = self.reversed(&vertex, scattered.incoming, scattered.pdf);
        }
        self.leave(&wall, scattered.incoming, scattered.weight, roulette)
    }

    /// Follows both directions in which a smooth dielectric sends light, or one of them by chance.
    ///
    /// A direction with less than one over [`BRANCHES`] of the light is followed by chance, with so
    /// much of it. The other one has the rest, or all if it is alone: the light of all branches
    /// together always counts as that of one path, and a pixel as bright as a lamp has no sample
    /// that is brighter.
    fn branch(
        &mut self,
        wall: &Wall<'_>,
        [mirrored, through]: &[BsdfSample; 2],
        f: f32,
        choice: f32,
        roulette: f32,
    ) -> Next {
        let least = 1.0 / (BRANCHES * self.share);
        let (rarer, mostly) = (f.min(1.0 - f), if f > 0.5 { 1.0 } else { 0.0 });
        let reflected = if rarer >= least {
            f
        } else if least > 0.5 {
            if choice < f { 1.0 } else { 0.0 }
        } else if choice * least < rarer {
            (mostly - least).abs()
        } else {
            mostly
        };
        self.origin = None;
        let take = |path: &mut Self, taken: &BsdfSample, share: f32| {
            path.share *= share;
            path.leave(wall, taken.incoming, share * taken.weight, roulette)
        };
        if reflected == 1.0 {
            return take(self, mirrored, reflected);
        }
        if reflected > 0.0 {
            let sampler = self.sampler.branch(self.segment);
            let mut other = Path { sampler, arrived: Arrived::default(), ..self.clone() };
            let arrived = match take(&mut other, mirrored, reflected) {
                Next::Segment => other.follow(),
                Next::Parts => other.divide(),
                Next::End => Arrived::default(),
            };
            self.arrived.radiance += arrived.radiance;
            self.arrived.rays += arrived.rays;
        }
        take(self, through, 1.0 - reflected)
    }

    /// Leaves a surface in a sampled direction.
    fn leave(&mut self, wall: &Wall<'_>, incoming: Vec3, weight: Vec3, roulette: f32) -> Next {
        let Wall { hit, outgoing, medium, normal, end_below } = *wall;
        let mut divided = false;
        if let Some(medium) = medium {
            if !sides_agree(hit, normal, outgoing, incoming) {
                return Next::End;
            }
            if hit.normal.dot(outgoing) * hit.normal.dot(incoming) < 0.0 {
                if !crosses_both_ways(&mut self.media, hit, incoming, medium) {
                    self.reverse = None;
                }
                let inside = self.media.innermost();
                divided = !self.part && inside.is_some_and(|medium| medium.albedo != Vec3::ZERO);
            }
        }
        self.throughput *= weight;
        let (ray, left) = (hit.spawn(incoming), hit.left_by(incoming));
        match self.continue_along(ray, left, end_below, roulette) {
            Next::Segment if divided => Next::Parts,
            next => next,
        }
    }
}

/// A surface that a path leaves.
struct Wall<'a> {
    hit: &'a SceneHit,
    outgoing: Vec3,
    /// The medium behind, if the surface is the boundary of one.
    medium: Option<Medium>,
    normal: Vec3,
    /// Throughput below which Russian roulette may end the path.
    end_below: f32,
}
