//! Scattering at a vertex of a path: direct illumination, and the direction that goes on.

use super::{Next, Origin, Path};
use crate::context::Context;
use crate::medium::Medium;
use crate::shadow::{Departure, Target};
use crate::{Bsdf, Receiver, phase, power_heuristic};
use glam::{Vec2, Vec3};
use rotund_geometry::Ray;
use rotund_scene::{MaterialKind, MaterialPoint, Scene, SceneHit};

impl Path<'_> {
    /// Samples a light and adds its contribution. `scatter` returns the value of the BSDF or phase
    /// function for a direction, and the density with which it would be sampled.
    fn gather_light(
        &mut self,
        receiver: &Receiver,
        departure: &Departure<'_>,
        scatter: impl Fn(Vec3) -> (Vec3, f32),
    ) {
        let Context { scene, trees, lights, bounces, furnace, .. } = self.context;
        if *furnace {
            return;
        }
        let [x, y, choice, _] = self.numbers(0);
        let Some(light) = lights.sample(receiver, choice, Vec2::new(x, y)) else { return };
        let (value, pdf) = scatter(light.incoming);
        if value == Vec3::ZERO {
            return;
        }
        let weight = power_heuristic(light.pdf, pdf) / light.pdf;
        let target = Target {
            incoming: light.incoming,
            source: light.source.as_ref(),
            borders: bounces - self.segment - 1,
        };
        let (share, rays) = self.context.visibility(departure, &target, &self.media);
        self.arrived.rays += rays;
        if share != Vec3::ZERO && !lights.is_covered(scene, trees, &light) {
            let radiance = lights.radiance(scene, &light);
            self.arrived.radiance += self.throughput * share * weight * value * radiance;
        }
    }

    pub(super) fn scatter_inside(&mut self, medium: &Medium, position: Vec3) -> Next {
        self.arrived.covered = true;
        if self.segment == self.context.bounces {
            return Next::End;
        }
        let outgoing = -self.ray.direction;
        let g = medium.anisotropy;
        let receiver = Receiver { position, normal: None };
        // The refracting wall blocks direct illumination from outside.
        let lit = !medium.walled || self.context.facts.lit_inside;
        if lit {
            self.gather_light(&receiver, &Departure::Inside(position), |incoming| {
                let density = phase::henyey_greenstein(g, outgoing, incoming);
                (Vec3::splat(density), density)
            });
        }
        let [x, y, _, roulette] = self.numbers(1);
        let incoming = phase::sample(g, outgoing, Vec2::new(x, y));
        let pdf = phase::henyey_greenstein(g, outgoing, incoming);
        self.origin = lit.then_some(Origin { receiver, pdf });
        self.continue_along(Ray::new(position, incoming), None, roulette)
    }

    pub(super) fn scatter_at(&mut self, hit: &SceneHit, material: &MaterialPoint) -> Next {
        let outgoing = -self.ray.direction;
        let normal = shading_normal(self.context.scene, hit, material.kind, outgoing);
        let bsdf = Bsdf::new(material, normal, outgoing);
        let wall = material.kind == MaterialKind::Refractive;
        let both_sides = wall || material.kind == MaterialKind::Transparent;
        let receiver = Receiver { position: hit.position, normal: (!both_sides).then_some(normal) };
        let medium = wall.then(|| Medium::new(material));
        let allowed = |incoming: Vec3| !wall || sides_agree(hit, normal, outgoing, incoming);
        if !bsdf.is_delta() {
            let departure = Departure::Surface { hit, outgoing, medium };
            self.gather_light(&receiver, &departure, |incoming| {
                let value = bsdf.eval(incoming);
                (if allowed(incoming) { value.value } else { Vec3::ZERO }, value.pdf)
            });
        }
        let [x, y, choice, roulette] = self.numbers(1);
        let Some(scattered) = bsdf.sample(choice, Vec2::new(x, y)) else { return Next::End };
        let incoming = scattered.incoming;
        if !allowed(incoming) {
            return Next::End;
        }
        let mut divided = false;
        if let Some(medium) = medium
            && hit.normal.dot(outgoing) * hit.normal.dot(incoming) < 0.0
        {
            self.media.cross(hit, incoming, medium);
            let inside = self.media.innermost();
            divided = !self.part && inside.is_some_and(|medium| medium.albedo != Vec3::ZERO);
        }
        self.throughput *= scattered.weight;
        self.origin = scattered.pdf.map(|pdf| Origin { receiver, pdf });
        match self.continue_along(hit.spawn(incoming), hit.left_by(incoming), roulette) {
            Next::Segment if divided => Next::Parts,
            next => next,
        }
    }
}

/// Returns the shading normal, or for walls of solids the geometric normal where the two face
/// different sides. At the silhouette of a mesh an interpolated normal can face away from the
/// viewer, and a path that enters the solid would be taken for one that leaves it.
fn shading_normal(scene: &Scene, hit: &SceneHit, kind: MaterialKind, outgoing: Vec3) -> Vec3 {
    let normal = scene.shading_normal(hit, outgoing);
    let turned = normal.dot(outgoing) * hit.normal.dot(outgoing) < 0.0;
    if kind == MaterialKind::Refractive && turned { hit.normal } else { normal }
}

/// True if shading normal and geometric normal agree whether light is reflected or transmitted.
/// Where the wall of a solid reflects by one and transmits by the other, a path would lose track of
/// the solids that it is in.
///
/// Opaque surfaces skip this test: there the shading normal alone decides, as in most renderers,
/// and a direction below the geometric surface meets the inside of a closed mesh, which is dark.
fn sides_agree(hit: &SceneHit, normal: Vec3, outgoing: Vec3, incoming: Vec3) -> bool {
    let shading = normal.dot(outgoing) * normal.dot(incoming) > 0.0;
    let geometric = hit.normal.dot(outgoing) * hit.normal.dot(incoming) > 0.0;
    shading == geometric
}
