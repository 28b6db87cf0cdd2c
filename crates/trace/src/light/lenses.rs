//! The balls of smooth glass of a scene, sampled like lights.

use super::lens::Lens;
use super::tree::{Extent, LightTree};
use super::{LightSource, Lights, Receiver, casters, emitter};
use glam::Vec3;
use rotund_scene::{ElementKind, MaterialKind, Scene, SceneHit};

/// The balls of smooth glass of a scene. Paths through one of them from a light to a point have a
/// closed form.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lenses {
    lenses: Vec<Lens>,
    tree: LightTree,
    /// For each instance, the number of its first lens, if it has lenses.
    first: Vec<Option<u32>>,
}

/// A lens that was chosen for a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChosenLens {
    pub(crate) number: u32,
    chance: f32,
}

impl Lenses {
    /// Finds the lenses of a scene, and how much light falls on each.
    pub(super) fn new(scene: &Scene, lights: &Lights) -> Self {
        let (mut lenses, mut extents) = (Vec::new(), Vec::new());
        let mut of_instance = |index: usize| {
            let first = lenses.len() as u32;
            let instance = &scene.instances[index];
            let material = &scene.materials[instance.material as usize];
            let shape = &scene.shapes[instance.shape as usize];
            let count = shape.elements.count();
            let clear = material.kind == MaterialKind::Refractive
                && material.roughness == 0.0
                && material.albedo == Vec3::ZERO
                && material.ior > 1.0
                && material.normal_tex.is_none()
                && scene.material_is_opaque(instance.material);
            let bare = shape.elements.kind() == ElementKind::Points
                && shape.colors.iter().all(|color| color.w >= 1.0);
            if !clear || !bare || count > casters::ROUND {
                return None;
            }
            for element in 0..count as u32 {
                let element = emitter::of_caster(scene, index as u32, element);
                // The elements of an instance are all balls, or none is.
                let ball = element.as_ball()?;
                let light = lights.arriving(&Receiver { position: ball.center, normal: None });
                let power = ball.radius * ball.radius * light;
                // The tree holds all lenses, also those that no light reaches.
                let power = if power.is_finite() { power } else { 0.0 };
                let power = power.max(f32::MIN_POSITIVE);
                extents.push(Extent { power, ..element.extent() });
                lenses.push(Lens { ball, ior: material.ior });
            }
            Some(first)
        };
        let first = (0..scene.instances.len()).map(&mut of_instance).collect();
        Self { tree: LightTree::new(&extents), lenses, first }
    }

    /// Returns true if there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.lenses.is_empty()
    }

    /// Samples a lens for a point.
    pub(crate) fn choose(&self, receiver: &Receiver, u: f32) -> Option<ChosenLens> {
        let (number, chance) = self.tree.choose(receiver, u)?;
        Some(ChosenLens { number, chance })
    }

    /// Returns the number of the lens that a surface is part of.
    pub(crate) fn lens(&self, hit: &SceneHit) -> Option<u32> {
        (*self.first.get(hit.instance as usize)?).map(|first| first + hit.element)
    }

    /// Returns the lens of a number as [`Self::choose`] would for this point.
    pub(crate) fn chosen(&self, receiver: &Receiver, number: u32) -> ChosenLens {
        ChosenLens { number, chance: self.tree.chance(receiver, number) }
    }

    /// Returns the lens of a number.
    pub(crate) fn get(&self, number: u32) -> &Lens {
        &self.lenses[number as usize]
    }

    /// Returns the point at which lights are sampled for all paths through a lens.
    pub(crate) fn receiver(&self, number: u32) -> Receiver {
        Receiver { position: self.lenses[number as usize].ball.center, normal: None }
    }

    /// Returns the density per area across the path, or per solid angle of the sky, with which a
    /// lens is chosen for a point, and for the lens a light, which it samples with density `pdf`.
    /// `source` is a point of the light and the direction in which the path arrives there.
    pub(crate) fn density(
        &self,
        chosen: &ChosenLens,
        pdf: f32,
        source: Option<(&LightSource, Vec3)>,
    ) -> f32 {
        let Some((source, incoming)) = source else { return chosen.chance * pdf };
        let to = source.position - self.get(chosen.number).ball.center;
        let slant = to.normalize().dot(source.normal) / incoming.dot(source.normal);
        chosen.chance * pdf * slant.abs() / to.length_squared()
    }
}
