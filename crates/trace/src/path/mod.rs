//! Radiance along one path from the camera.
//!
//! At each vertex one direction is sampled from the lights and one from the BSDF, or from the phase
//! function inside of a medium. Multiple importance sampling weights both by the power heuristic,
//! since each technique could have sampled the direction of the other. The path continues along the
//! second direction; the surface that it hits tells with which density the lights would have
//! sampled it. Inside of a solid that scatters, no light can be sampled through the refracting
//! wall; there a path is split, and all parts continue. Smooth glass before the first rough surface
//! both reflects and transmits, so a path branches there. Light that casters send to a rough
//! surface is found by paths from the lights too ([`crate::light_path`]); the weights tell. Where
//! those cannot be connected to the camera, lights are sampled through balls of glass.

mod lens;
mod reverse;
mod scatter;
#[cfg(test)]
mod tests;

use crate::context::{Arrived, Context};
use crate::light::Aim;
use crate::medium::{Media, Medium};
use crate::mis::weight_of_bsdf;
use crate::opacity::{SHEET_SETS, SHEETS};
use crate::{Sampler, power_heuristic};
use glam::Vec3;
use lens::Passage;
use reverse::Reverse;
use rotund_geometry::Ray;
use rotund_scene::{MaterialKind, SceneHit};

/// Number of segments after which Russian roulette may end a path.
const ROULETTE_AFTER: u32 = 4;
/// Throughput below which Russian roulette may end a path. A higher threshold saves less time than
/// the noise it adds costs, above all where a few paths carry most of the light: one of 0.5 gives
/// glass and metal a tenth more noise, for at most a twentieth of the time.
const END_BELOW: f32 = 0.15;
/// The same behind a matte surface, where light samples at the next vertex find most of the light,
/// so that less depends on a single path. It saves a twelfth of the rays in a closed room for 4 %
/// more noise there, and changes neither by more than 1.5 % in open scenes.
const MATTE_BELOW: f32 = 0.3;
/// Dimension sets of a segment. The camera takes set 0, the segments follow.
const SETS_PER_SEGMENT: u32 = 3;
/// Number of parts that a path is split into where it enters a solid that scatters. No light can be
/// sampled there through the wall, so all of it comes from the few paths that find the way out.
/// The parts share the cost of the segments before the split, and end where a photon would be
/// absorbed: so eight of them take as long as four that go on with less light, and have a fifth
/// less noise in dense solids.
const PARTS: u32 = 8;

/// Largest number of branches of a path. Smooth dielectrics between the camera and the first rough
/// surface both reflect and transmit; a branch with less than one over this number of the light is
/// followed by chance, as if it had so much. A bright lamp that glass reflects once is most of the
/// noise of a picture of glass otherwise.
const BRANCHES: f32 = 8.0;

/// The vertex at which the last direction was sampled, unless it was a delta direction.
#[derive(Clone, Copy)]
struct Origin {
    aim: Aim,
    /// Density of the direction per solid angle.
    pdf: f32,
}

/// The state of a path between two vertices.
#[derive(Clone)]
struct Path<'a> {
    context: &'a Context<'a>,
    sampler: Sampler,
    ray: Ray,
    /// What the ray meets, as far as it has been traced already.
    found: Option<&'a Option<SceneHit>>,
    /// The instance on whose outside the ray starts.
    left: Option<u32>,
    throughput: Vec3,
    /// The factor of the throughput that is due to branches: at least one over [`BRANCHES`].
    share: f32,
    origin: Option<Origin>,
    media: Media,
    /// Number of the segment along `ray`, counted from 1 at the camera.
    segment: u32,
    /// Number of surfaces of partial opacity met so far.
    sheets: u32,
    /// The last segment on which the path passed such a surface.
    sheet_at: u32,
    /// The path has been split already: it is one of [`PARTS`].
    part: bool,
    /// What light paths that would find this path need to be weighted, unless none would.
    reverse: Option<Reverse>,
    /// What light samples through a lens that would find this path need to be weighted.
    passage: Option<Passage>,
    /// Where the path started.
    lens: Vec3,
    /// Nothing has changed the direction since the camera.
    straight: bool,
    /// All vertices so far were smooth.
    smooth: bool,
    arrived: Arrived,
}

/// The continuation of a path after a vertex.
enum Next {
    /// One more segment.
    Segment,
    /// A split into [`PARTS`] paths.
    Parts,
    /// None.
    End,
}

impl Context<'_> {
    /// Returns what a path along a camera ray meets first, for [`Self::trace`].
    #[inline]
    pub(crate) fn camera_hit(&self, ray: &Ray) -> Option<SceneHit> {
        self.trees.closest_to_shade(self.scene, ray, None)
    }

    /// Returns the radiance along a camera ray of unit direction, which meets `found`.
    pub(crate) fn trace(&self, ray: Ray, sampler: &Sampler, found: &Option<SceneHit>) -> Arrived {
        let mut path = Path {
            context: self,
            sampler: *sampler,
            ray,
            found: Some(found),
            left: None,
            throughput: Vec3::ONE,
            share: 1.0,
            origin: None,
            media: Media::default(),
            segment: 1,
            sheets: 0,
            sheet_at: 0,
            part: false,
            reverse: None,
            passage: None,
            lens: ray.origin,
            straight: true,
            smooth: true,
            arrived: Arrived::default(),
        };
        path.follow()
    }
}

impl Path<'_> {
    /// Follows the path to its end.
    fn follow(&mut self) -> Arrived {
        while self.segment <= self.context.bounces {
            match self.step() {
                Next::Segment => {}
                Next::Parts => return self.divide(),
                Next::End => break,
            }
        }
        self.arrived
    }

    /// Splits the path, and adds the mean radiance of its parts to what has arrived.
    fn divide(&self) -> Arrived {
        let mut sum = self.arrived;
        for part in 0..PARTS {
            let sampler = self.sampler.part(part, PARTS);
            let mut path =
                Path { sampler, part: true, arrived: Arrived::default(), ..self.clone() };
            let arrived = path.follow();
            sum.radiance += arrived.radiance / PARTS as f32;
            sum.rays += arrived.rays;
        }
        sum
    }

    /// Traces the ray, gathers light at its end, and samples the next ray.
    fn step(&mut self) -> Next {
        let Context { scene, bounces, facts, .. } = *self.context;
        let event = self.media.innermost().filter(|medium| medium.scatters()).map(|medium| {
            let [of_light, of_direction, [mut channel, mut u, ..]] =
                self.sampler.sets(self.first_set());
            if self.sheet_at == self.segment {
                // The path has come this far without an event, so its numbers are not free.
                [_, channel, u, _] = self.sampler.set(SHEET_SETS + self.sheets - 1);
            }
            (*medium, medium.sample(channel, u), [of_light, of_direction])
        });
        let closed = event.as_ref().filter(|_| facts.closed);
        let is_walled = closed.is_some_and(|(medium, ..)| medium.walled);
        if self.segment == bounces && is_walled && !facts.lit_inside {
            // The last segment can end at the wall at best, where nothing emits.
            return Next::End;
        }
        // A ray inside of a solid is traced to the next event only, which is often near compared
        // with the other side of the solid.
        let limit = closed.map_or(f32::INFINITY, |&(_, distance, _)| distance);
        self.ray.t_max = limit;
        self.arrived.rays += 1;
        // Borrow the hit where it was written, instead of moving it: copying it right after the
        // store stalls on store-to-load forwarding.
        let found = match self.found.take() {
            Some(found) => found,
            None => &self.context.trees.closest_to_shade(scene, &self.ray, self.left),
        };
        if let Some((medium, distance, numbers)) = event
            && found.as_ref().map_or(limit < f32::INFINITY, |hit| distance < hit.t)
        {
            return self.scatter_inside(&medium, distance, numbers);
        }
        let Some(hit) = found else {
            self.gather_environment();
            return Next::End;
        };
        self.throughput *= match event {
            Some((medium, ..)) => medium.passed(hit.t),
            None => self.media.transmittance(hit.t),
        };
        let material = scene.eval_material(hit.instance, hit.element, hit.uv);
        if material.opacity < 1.0 {
            let [chance, ..] = self.sampler.set(SHEET_SETS + self.sheets);
            self.sheets += 1;
            if self.sheets > SHEETS {
                return Next::End;
            }
            if chance >= material.opacity {
                self.passage = self.passage.filter(Passage::is_complete);
                self.sheet_at = self.segment;
                self.pass(hit);
                return Next::Segment;
            }
        }
        self.arrived.covered = true;
        self.gather_emission(hit, material.emission);
        if self.segment == bounces {
            return Next::End;
        }
        if material.kind == MaterialKind::Volumetric {
            (self.reverse, self.passage) = (None, None);
            // Light samples cross whole borders as well, but only pass those that are there by
            // chance.
            self.origin = self.origin.filter(|_| material.opacity >= 1.0);
            self.media.cross(hit, self.ray.direction, Medium::new(&material));
            self.pass(hit);
            self.segment += 1;
            return Next::Segment;
        }
        self.scatter_at(hit, &material)
    }

    /// Returns the `index`-th set of numbers of this segment.
    fn numbers(&self, index: u32) -> [f32; 4] {
        self.sampler.set(self.first_set() + index)
    }

    /// Returns the sets of numbers of a vertex: for a light, and for the direction that goes on.
    fn numbers_of_vertex(&self) -> [[f32; 4]; 2] {
        self.sampler.sets(self.first_set())
    }

    fn first_set(&self) -> u32 {
        1 + SETS_PER_SEGMENT * (self.segment - 1)
    }

    /// Continues straight behind a surface.
    fn pass(&mut self, hit: &SceneHit) {
        self.ray.origin = hit.spawn(self.ray.direction).origin;
        self.left = hit.left_by(self.ray.direction);
    }

    fn gather_environment(&mut self) {
        let Context { scene, lights, furnace, transparent, .. } = self.context;
        if *transparent && self.straight {
            self.arrived.covered = false;
            return;
        }
        if *furnace {
            self.arrived.radiance += self.throughput;
            self.arrived.covered = true;
            return;
        }
        let aim = self.origin.as_ref().map(|origin| &origin.aim);
        let (radiance, other) = lights.environment(scene, aim, self.ray.direction);
        let through = self.weight_through(None);
        let weight = through
            .unwrap_or_else(|| self.weight(other, || self.found_from_sky(self.ray.direction)));
        self.arrived.radiance += weight * self.throughput * radiance;
        self.arrived.covered |= !scene.environments.is_empty();
    }

    fn gather_emission(&mut self, hit: &SceneHit, emission: Vec3) {
        if emission != Vec3::ZERO && !self.context.furnace {
            let lights = self.context.lights;
            let of_sample = |origin: &Origin| lights.pdf_for(&origin.aim, hit);
            let other = self.origin.as_ref().map_or(0.0, of_sample);
            let through = self.weight_through(Some(hit));
            let weight = through.unwrap_or_else(|| self.weight(other, || self.found_from(hit)));
            self.arrived.radiance += weight * self.throughput * emission;
        }
    }

    /// Returns the weight of light that the BSDF found and a light sample finds with density
    /// `other`. `light` is the density of light paths relative to that of this one.
    fn weight(&self, other: f32, light: impl Fn() -> f32) -> f32 {
        let Some(_) = self.reverse else {
            return self.origin.as_ref().map_or(1.0, |o| power_heuristic(o.pdf, other));
        };
        weight_of_bsdf(self.origin.as_ref().map_or(0.0, |o| other / o.pdf), light())
    }

    /// Takes the next segment, unless the throughput is zero or Russian roulette ends the path.
    #[inline(always)]
    fn continue_along(
        &mut self,
        ray: Ray,
        left: Option<u32>,
        end_below: f32,
        roulette: f32,
    ) -> Next {
        if self.segment >= ROULETTE_AFTER {
            let usual = end_below * self.share;
            let survival = (self.throughput.max_element() / usual).min(0.99);
            if roulette >= survival {
                return Next::End;
            }
            self.throughput /= survival;
        }
        (self.ray, self.left) = (ray, left);
        self.straight = false;
        self.segment += 1;
        if self.throughput == Vec3::ZERO { Next::End } else { Next::Segment }
    }
}
