//! The surfaces that pass light on in narrow beams: smooth glass and metal. Paths that start at
//! the lights are aimed at them.

use super::emitter::{self, Emitter};
use super::round::{Ball, Density};
use super::{Lights, Receiver};
use crate::distribution::Table;
use crate::warp;
use glam::{Vec2, Vec3};
use rotund_scene::{ElementKind, Material, MaterialKind, Method, Scene, SceneHit};
use std::f32::consts::{PI, TAU};

/// The surfaces of a scene that pass light on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Casters {
    casters: Vec<Caster>,
    /// Distribution of the casters, in proportion to the light that falls on them.
    choice: Table,
    /// For each instance, its casters.
    groups: Vec<Group>,
}

#[derive(Clone, Debug)]
struct Caster {
    /// A ball around it.
    ball: Ball,
    /// The element, sampled as one that emits; `None` for a mesh.
    element: Option<Emitter>,
}

/// The casters of an instance.
#[derive(Clone, Copy, Debug)]
enum Group {
    None,
    /// One for each of `count` elements, from `first` on. Those of vanilla points and lines are
    /// never chosen.
    Elements {
        first: u32,
        count: u32,
    },
    /// All elements together.
    Mesh(u32),
}

/// A caster that was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chosen {
    pub(crate) caster: u32,
    /// A ball around it.
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
}

/// Width of the microfacet distribution from which on a surface scatters so widely that paths from
/// the camera find what it casts.
const WIDEST: f32 = 0.2;
/// Largest number of faces that are casters of their own; a mesh of more is one caster.
const FACES: usize = 8;
/// Largest number of round elements that are casters of their own: each takes 320 bytes, or
/// 450 as a lens.
pub(super) const ROUND: usize = 1 << 16;

/// Returns true if surfaces of a material pass light on in narrow beams.
pub(crate) fn casts(material: &Material) -> bool {
    let kinds = [MaterialKind::Reflective, MaterialKind::Refractive, MaterialKind::Transparent];
    kinds.contains(&material.kind) && material.roughness * material.roughness < WIDEST
}

impl Casters {
    /// Finds the casters of a scene, and how much light falls on each.
    pub(super) fn new(scene: &Scene, lights: &Lights) -> Self {
        let mut casters = Vec::new();
        let of_instance = |index: usize| {
            let instance = &scene.instances[index];
            if !casts(&scene.materials[instance.material as usize]) {
                return Group::None;
            }
            let shape = &scene.shapes[instance.shape as usize];
            let (first, count) = (casters.len() as u32, shape.elements.count());
            let round = [ElementKind::Points, ElementKind::Lines].contains(&shape.elements.kind());
            // Balls and cones that a frame deforms cannot be sampled as such.
            let deformed = round
                && shape.method == Method::Enhanced
                && emitter::scale(&instance.world_from_object).is_none();
            if !deformed && count <= if round { ROUND } else { FACES } {
                casters.extend((0..count as u32).map(|element| {
                    let emitter = emitter::of_caster(scene, index as u32, element);
                    Caster { ball: emitter.ball(), element: Some(emitter) }
                }));
                Group::Elements { first, count: count as u32 }
            } else {
                casters.push(Caster { ball: ball_around(scene, index), element: None });
                Group::Mesh(first)
            }
        };
        let groups = (0..scene.instances.len()).map(of_instance).collect();
        let power = |caster: &Caster| {
            let Caster { ball, element } = caster;
            let light = lights.arriving(&Receiver { position: ball.center, normal: None });
            let sampled = element.as_ref().is_none_or(|emitter| emitter.power > 0.0);
            let power = ball.radius * ball.radius * light;
            if sampled && power.is_finite() { power } else { 0.0 }
        };
        Self { choice: Table::new(casters.iter().map(power)), casters, groups }
    }

    /// Returns the index of each instance whose elements are casters, and their number.
    pub(super) fn counts(&self) -> impl Iterator<Item = (usize, usize)> {
        let numbered = self.groups.iter().enumerate();
        numbered.filter_map(|(index, group)| match group {
            Group::Elements { count, .. } => Some((index, *count as usize)),
            _ => None,
        })
    }

    /// Returns true if there is no caster that a light shines on.
    pub(crate) fn is_empty(&self) -> bool {
        self.choice.sum <= 0.0
    }

    /// Samples a caster.
    pub(crate) fn choose(&self, u: f32) -> Option<Chosen> {
        let caster = self.choice.draw(u)?.cell;
        let Ball { center, radius } = self.casters[caster].ball;
        Some(Chosen { caster: caster as u32, center, radius })
    }

    /// Samples a direction to a caster, or returns `None` if it would miss.
    pub(crate) fn aim(&self, caster: u32, from: Vec3, u: Vec2) -> Option<Vec3> {
        let Caster { ball, element } = &self.casters[caster as usize];
        let point = match element {
            Some(emitter) => emitter.sample(from, u)?.source.position,
            None if ball.holds(from) => return Some(warp::sphere(u)),
            None => ball.sample(from, u).position,
        };
        (point - from).try_normalize()
    }

    /// Returns the number of the caster that a surface is part of.
    pub(crate) fn caster(&self, hit: &SceneHit) -> Option<u32> {
        match *self.groups.get(hit.instance as usize)? {
            Group::Elements { first, count } => {
                (hit.element < count).then_some(first + hit.element)
            }
            Group::Mesh(caster) => Some(caster),
            Group::None => None,
        }
    }

    /// Returns the density with which paths start at a point of a light and go to a point of a
    /// caster: per area of the light, solid angle and cosine at the light.
    pub(crate) fn density(&self, lights: &Lights, source: &SceneHit, hit: &SceneHit) -> f32 {
        let Some(index) = self.caster(hit) else { return 0.0 };
        let Caster { ball, element } = &self.casters[index as usize];
        let receiver = Receiver { position: ball.center, normal: None };
        let (to_center, to_hit) = (source.position - ball.center, source.position - hit.position);
        let slant = |to: Vec3| (to.dot(source.normal) / to.length()).abs();
        let per_area =
            lights.pdf(&receiver, source) * slant(to_center) / to_center.length_squared();
        let aimed = match element {
            Some(emitter) => emitter.pdf(source.position, hit),
            None => match ball.density(source.position) {
                Density::SolidAngle(pdf) => pdf,
                Density::Area(_) => 0.5 / TAU,
            },
        };
        let density = self.choice.chance(index as usize) * per_area * aimed / slant(to_hit);
        if density.is_finite() { density } else { 0.0 }
    }

    /// Returns the density with which paths come from a direction of the environments and go to a
    /// point of a caster: per solid angle and area across the direction.
    pub(crate) fn density_of_sky(&self, lights: &Lights, sky: Vec3, hit: &SceneHit) -> f32 {
        let Some(index) = self.caster(hit) else { return 0.0 };
        let chance = self.choice.chance(index as usize);
        // The ball around what is never chosen may have no size, or no place.
        if chance <= 0.0 {
            return 0.0;
        }
        let Ball { center, radius } = self.casters[index as usize].ball;
        let receiver = Receiver { position: center, normal: None };
        chance * lights.environment_pdf(&receiver, sky) / (PI * radius * radius)
    }
}

/// Returns a ball around an instance.
fn ball_around(scene: &Scene, index: usize) -> Ball {
    let instance = &scene.instances[index];
    let shape = &scene.shapes[instance.shape as usize];
    let bounds = scene.instance_bounds(index as u32);
    let center = bounds.center();
    let to_corner = 0.5 * (bounds.max - bounds.min).length();
    if !shape.radii.is_empty() || shape.positions.is_empty() {
        return Ball { center, radius: to_corner };
    }
    let reach =
        |&vertex: &Vec3| instance.world_from_object.transform_point3(vertex).distance(center);
    let radius = shape.positions.iter().map(reach).fold(0.0, f32::max);
    Ball { center, radius: 1.0001 * radius }
}
