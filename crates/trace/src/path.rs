//! Light along one path from the camera.
//!
//! At each vertex one direction is drawn from the lights and one from the BSDF, or the phase function
//! inside of a medium. Either could have found what the other found, so both are weighted by the power
//! heuristic. The second direction goes on; what it hits tells by itself with which density the lights
//! would have found it. Inside of a solid that scatters no light can be drawn through the wall; there a
//! path divides, and all parts go on.

use crate::light::Receiver;
use crate::medium::{Media, Medium};
use crate::shadow::{Departure, Target};
use crate::{Bsdf, Lights, Options, Sampler, View, phase, power_heuristic, view};
use glam::{Vec2, Vec3};
use rotund_geometry::{Aabb, Ray, leave_surface};
use rotund_scene::{Instance, Material, MaterialKind, MaterialPoint, Scene, SceneHit, Trees};

/// What all paths of a render share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct World<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) trees: &'a Trees,
    pub(crate) lights: &'a Lights,
    pub(crate) bounces: u32,
    /// No surface lets rays go straight through.
    pub(crate) opaque: bool,
    /// Something may shine inside of a solid that scatters.
    pub(crate) lit_inside: bool,
    /// All directions send radiance 1, and nothing else shines.
    pub(crate) furnace: bool,
    /// Of the scene, for a view that shows positions.
    pub(crate) bounds: Aabb,
}

/// What a path brings home.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Arrived {
    pub(crate) radiance: Vec3,
    /// A surface or an environment was met.
    pub(crate) covered: bool,
    /// Rays traced.
    pub(crate) rays: u64,
}

/// Segments after which a path may end by Russian roulette.
const ROULETTE_AFTER: u32 = 4;
/// What a path may still bring below which it may end. Paths that end sooner save less time than they add noise,
/// above all where a few bring most of the light.
const ROULETTE_BELOW: f32 = 0.5;
/// Sheets of partial opacity that one path may pass. It ends paths that would otherwise not.
pub(crate) const SHEETS: u32 = 1024;
/// Dimension sets of a path: the camera takes the first, each segment three.
const SETS_PER_SEGMENT: u32 = 3;
/// Sets of decisions at sheets of partial opacity, which come in any number.
pub(crate) const SHEET_SETS: u32 = 1 << 16;

/// Into how many a path is divided that goes into a solid that scatters: of light inside none can be drawn
/// through the wall, so it comes from the few paths that find the way out to it. Of four the camera's
/// ray is paid for once.
const PARTS: u32 = 4;

/// Where the last direction was drawn, unless from a discrete few.
#[derive(Clone, Copy)]
struct Origin {
    receiver: Receiver,
    /// Density of the direction.
    pdf: f32,
}

/// A path under way.
#[derive(Clone)]
struct Path<'a> {
    world: &'a World<'a>,
    sampler: Sampler,
    ray: Ray,
    throughput: Vec3,
    origin: Option<Origin>,
    media: Media,
    /// The segment that `ray` is, counted from 1 at the camera.
    segment: u32,
    sheets: u32,
    /// It is one of [`PARTS`] already.
    part: bool,
    arrived: Arrived,
}

/// Whether a path goes on.
enum Next {
    Segment,
    /// In several ways.
    Parts,
    End,
}

impl<'a> World<'a> {
    /// Looks through the scene for what all paths need to know.
    pub(crate) fn new(
        scene: &'a Scene,
        trees: &'a Trees,
        lights: &'a Lights,
        options: &Options,
    ) -> Self {
        let bounds = match options.view {
            View::Position => view::bounds(scene),
            _ => Aabb::EMPTY,
        };
        let (bounces, furnace) = (options.bounces, options.view == View::Furnace);
        let (opaque, lit_inside) = (is_opaque(scene), is_lit_inside(scene));
        Self { scene, trees, lights, bounces, opaque, lit_inside, furnace, bounds }
    }

    /// The radiance that comes along a ray of unit direction.
    pub(crate) fn trace(&self, ray: Ray, sampler: &Sampler) -> Arrived {
        let path = Path {
            world: self,
            sampler: *sampler,
            ray,
            throughput: Vec3::ONE,
            origin: None,
            media: Media::default(),
            segment: 1,
            sheets: 0,
            part: false,
            arrived: Arrived::default(),
        };
        path.follow()
    }
}

impl Path<'_> {
    /// Goes on to the end.
    fn follow(mut self) -> Arrived {
        while self.segment <= self.world.bounces {
            match self.step() {
                Next::Segment => {}
                Next::Parts => return self.divide(),
                Next::End => break,
            }
        }
        self.arrived
    }

    /// The mean of several paths that go on from here, added to what has arrived.
    fn divide(self) -> Arrived {
        let mut sum = self.arrived;
        for part in 0..PARTS {
            let sampler = self.sampler.part(part, PARTS);
            let path = Path { sampler, part: true, arrived: Arrived::default(), ..self.clone() };
            let arrived = path.follow();
            sum.radiance += arrived.radiance / PARTS as f32;
            sum.rays += arrived.rays;
        }
        sum
    }

    /// Follows the ray, gathers light at its end, and finds the next ray.
    fn step(&mut self) -> Next {
        let scene = self.world.scene;
        self.arrived.rays += 1;
        // Not moved out of the option: a copy of what has just been written waits until it has left the processor.
        let found = self.world.trees.closest(scene, &self.ray);
        let Some(hit) = &found else {
            self.gather_environment();
            return Next::End;
        };
        if let Some(&medium) = self.media.innermost() {
            if medium.albedo == Vec3::ZERO {
                self.throughput *= self.media.transmittance(hit.t);
            } else {
                let [channel, u, ..] = self.numbers(2);
                let (distance, factor) = medium.sample(hit.t, channel, u);
                self.throughput *= factor;
                if let Some(distance) = distance {
                    return self.scatter_inside(&medium, self.ray.at(distance));
                }
            }
        }
        let material = scene.eval_material(hit.instance, hit.element, hit.uv);
        if material.opacity < 1.0 {
            let [chance, ..] = self.sampler.set(SHEET_SETS + self.sheets);
            self.sheets += 1;
            if self.sheets > SHEETS {
                return Next::End;
            }
            if chance >= material.opacity {
                self.pass(hit);
                return Next::Segment;
            }
        }
        self.arrived.covered = true;
        self.gather_emission(hit, material.emission);
        if self.segment == self.world.bounces {
            return Next::End;
        }
        if material.kind == MaterialKind::Volumetric {
            // The density of the last direction stays: the lights too see through such a border.
            self.media.cross(hit, self.ray.direction, Medium::new(&material));
            self.pass(hit);
            self.segment += 1;
            return Next::Segment;
        }
        self.scatter_at(hit, &material)
    }

    /// The `index`-th set of numbers of this segment.
    fn numbers(&self, index: u32) -> [f32; 4] {
        self.sampler.set(1 + SETS_PER_SEGMENT * (self.segment - 1) + index)
    }

    /// Goes straight on behind a surface.
    fn pass(&mut self, hit: &SceneHit) {
        self.ray.origin = leave_surface(hit.position, hit.error, hit.normal, self.ray.direction);
    }

    fn gather_environment(&mut self) {
        let World { scene, lights, furnace, .. } = self.world;
        if *furnace {
            self.arrived.radiance += self.throughput;
            self.arrived.covered = true;
            return;
        }
        let receiver = self.origin.as_ref().map(|origin| &origin.receiver);
        let (radiance, other) = lights.environment(scene, receiver, self.ray.direction);
        let weight = self.origin.as_ref().map_or(1.0, |origin| power_heuristic(origin.pdf, other));
        self.arrived.radiance += weight * self.throughput * radiance;
        self.arrived.covered |= !scene.environments.is_empty();
    }

    fn gather_emission(&mut self, hit: &SceneHit, emission: Vec3) {
        if emission != Vec3::ZERO && !self.world.furnace {
            let weight = self.origin.as_ref().map_or(1.0, |origin| {
                power_heuristic(origin.pdf, self.world.lights.hit_pdf(&origin.receiver, hit))
            });
            self.arrived.radiance += weight * self.throughput * emission;
        }
    }

    /// Draws a light and adds what comes from it. `scatter` gives value and density for a direction.
    fn gather_light(
        &mut self,
        receiver: &Receiver,
        departure: &Departure<'_>,
        scatter: impl Fn(Vec3) -> (Vec3, f32),
    ) {
        let World { scene, lights, bounces, furnace, .. } = self.world;
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
        let (share, rays) = self.world.visibility(departure, &target, &self.media);
        self.arrived.rays += rays;
        if share != Vec3::ZERO {
            let radiance = lights.radiance(scene, &light);
            self.arrived.radiance += self.throughput * share * weight * value * radiance;
        }
    }

    fn scatter_inside(&mut self, medium: &Medium, position: Vec3) -> Next {
        self.arrived.covered = true;
        if self.segment == self.world.bounces {
            return Next::End;
        }
        let outgoing = -self.ray.direction;
        let g = medium.anisotropy;
        let receiver = Receiver { position, normal: None };
        // A wall blocks what comes straight from outside.
        let lit = !medium.walled || self.world.lit_inside;
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
        self.go_on(Ray::new(position, incoming), roulette)
    }

    fn scatter_at(&mut self, hit: &SceneHit, material: &MaterialPoint) -> Next {
        let outgoing = -self.ray.direction;
        let normal = shading_normal(self.world.scene, hit, material.kind, outgoing);
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
        let origin = leave_surface(hit.position, hit.error, hit.normal, incoming);
        match self.go_on(Ray::new(origin, incoming), roulette) {
            Next::Segment if divided => Next::Parts,
            next => next,
        }
    }

    /// Takes the next segment, unless nothing would come of it or Russian roulette ends the path.
    #[inline(always)]
    fn go_on(&mut self, ray: Ray, roulette: f32) -> Next {
        if self.segment >= ROULETTE_AFTER {
            let survival = (self.throughput.max_element() / ROULETTE_BELOW).min(0.99);
            if roulette >= survival {
                return Next::End;
            }
            self.throughput /= survival;
        }
        self.ray = ray;
        self.segment += 1;
        if self.throughput == Vec3::ZERO { Next::End } else { Next::Segment }
    }
}

/// The shading normal. At the silhouette of a mesh an interpolated normal can turn away from the
/// viewer; for the wall of a solid that would take a path that enters for one that leaves, so there
/// the geometric normal stands in.
fn shading_normal(scene: &Scene, hit: &SceneHit, kind: MaterialKind, outgoing: Vec3) -> Vec3 {
    let normal = scene.shading_normal(hit, outgoing);
    let turned = normal.dot(outgoing) * hit.normal.dot(outgoing) < 0.0;
    if kind == MaterialKind::Refractive && turned { hit.normal } else { normal }
}

/// True if light goes to the side of the geometric surface on which the shading normal has it. Where
/// the wall of a solid reflects by one and transmits by the other, a path would lose count of what it is in.
///
/// Opaque surfaces are not asked: there the shading normal alone decides, as in most renderers, and a
/// direction that is below the geometric surface meets the inside of a closed mesh, which is dark.
fn sides_agree(hit: &SceneHit, normal: Vec3, outgoing: Vec3, incoming: Vec3) -> bool {
    let shading = normal.dot(outgoing) * normal.dot(incoming) > 0.0;
    let geometric = hit.normal.dot(outgoing) * hit.normal.dot(incoming) > 0.0;
    shading == geometric
}

/// True if no surface of the scene lets rays go straight through.
fn is_opaque(scene: &Scene) -> bool {
    let image_is_opaque = |texture: &Option<u32>| {
        texture.is_none_or(|texture| scene.textures[texture as usize].is_opaque())
    };
    let is_opaque = |material: &Material| {
        material.opacity >= 1.0
            && material.kind != MaterialKind::Volumetric
            && image_is_opaque(&material.color_tex)
    };
    scene.materials.iter().all(is_opaque)
        && scene.shapes.iter().all(|shape| shape.colors.iter().all(|color| color.w >= 1.0))
}

/// False only if nothing shines inside of the solids that scatter.
fn is_lit_inside(scene: &Scene) -> bool {
    let boxes = |wanted: fn(&Material) -> bool| {
        let of = |instance: &&Instance| wanted(&scene.materials[instance.material as usize]);
        let found = scene.instances.iter().filter(of);
        found.map(|instance| view::instance_bounds(scene, instance)).collect::<Vec<_>>()
    };
    let lamps = boxes(|material| material.emission != Vec3::ZERO);
    let solids = boxes(|material| {
        material.kind == MaterialKind::Refractive && material.scattering != Vec3::ZERO
    });
    let meet = |a: &Aabb, b: &Aabb| a.min.cmple(b.max).all() && b.min.cmple(a.max).all();
    solids.iter().any(|solid| lamps.iter().any(|lamp| meet(solid, lamp)))
}
