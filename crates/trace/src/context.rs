//! The state that all paths of a render share.

use crate::sensor::Sensor;
use crate::{Lights, Options, View};
use glam::Vec3;
use rotund_geometry::Aabb;
use rotund_scene::{
    ElementKind, Instance, Material, MaterialKind, Method, Overlap, Scene, Shape, Trees,
};

/// The state that all paths of a render share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) trees: &'a Trees,
    pub(crate) lights: &'a Lights,
    pub(crate) facts: Facts,
    pub(crate) bounces: u32,
    /// Every direction sends radiance 1, and nothing else emits.
    pub(crate) furnace: bool,
    /// Camera rays that reach the environment straight do not see it.
    pub(crate) transparent: bool,
    /// The film that paths from the lights are connected to, if there are any.
    pub(crate) sensor: Option<Sensor>,
    /// A distance that is larger than the scene, if there are paths from the lights.
    pub(crate) reach: f32,
    /// Number of light paths of a sample that all weights count on. Any number leaves the light the
    /// same; that of the light paths that are traced makes the least noise.
    pub(crate) rate: f32,
    /// Bounds of the scene for [`View::Position`], else empty.
    pub(crate) bounds: Aabb,
}

/// Properties of a whole scene that save work on each path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facts {
    /// No surface lets rays go straight through.
    pub(crate) opaque: bool,
    /// Something may emit inside of a solid that scatters.
    pub(crate) lit_inside: bool,
    /// Rays inside of solids and clouds that scatter always meet their surface.
    pub(crate) closed: bool,
}

/// Radiance that a camera ray finds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Arrived {
    pub(crate) radiance: Vec3,
    /// The ray met a surface or a visible environment.
    pub(crate) covered: bool,
    /// Rays traced.
    pub(crate) rays: u64,
}

impl<'a> Context<'a> {
    pub(crate) fn new(
        scene: &'a Scene,
        trees: &'a Trees,
        lights: &'a Lights,
        facts: Facts,
        options: &Options,
    ) -> Self {
        let &Options { view, bounces, transparent, .. } = options;
        let bounds = if view == View::Position { scene.bounds() } else { Aabb::EMPTY };
        let furnace = view == View::Furnace;
        Self {
            scene,
            trees,
            lights,
            facts,
            bounces,
            furnace,
            transparent,
            sensor: None,
            reach: 0.0,
            rate: 0.0,
            bounds,
        }
    }
}

impl Facts {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self {
            opaque: is_opaque(scene),
            lit_inside: is_lit_inside(scene),
            closed: is_closed(scene),
        }
    }

    /// Returns the facts after the methods of shapes have changed.
    pub(crate) fn after_methods(self, scene: &Scene) -> Self {
        Self { closed: is_closed(scene), ..self }
    }
}

/// True if no surface of the scene lets rays go straight through.
fn is_opaque(scene: &Scene) -> bool {
    let is_opaque = |(index, material): (u32, &Material)| {
        material.kind != MaterialKind::Volumetric && scene.material_is_opaque(index)
    };
    (0..).zip(&scene.materials).all(is_opaque)
        && scene.shapes.iter().all(|shape| shape.colors.iter().all(|color| color.w >= 1.0))
}

/// True if rays inside of all solids and clouds that scatter always meet their surface.
fn is_closed(scene: &Scene) -> bool {
    let is_round =
        |shape: &Shape| matches!(shape.elements.kind(), ElementKind::Points | ElementKind::Lines);
    // A ray that meets a vanilla point goes on from its center, which may be outside of a solid
    // that the ray is inside of.
    if scene.shapes.iter().any(|shape| is_round(shape) && shape.method == Method::Vanilla) {
        return false;
    }
    let scatters = |instance: &&Instance| {
        let Material { kind, albedo, .. } = scene.materials[instance.material as usize];
        [MaterialKind::Refractive, MaterialKind::Volumetric].contains(&kind) && albedo != Vec3::ZERO
    };
    let solids = || scene.instances.iter().filter(scatters);
    // A surface that lets rays go straight through does not take them out of the solid.
    let is_there = |instance: &Instance| scene.material_is_opaque(instance.material);
    let mut shapes: Vec<u32> = solids().map(|instance| instance.shape).collect();
    shapes.sort_unstable();
    shapes.dedup();
    let mut shapes = shapes.iter().map(|&index| &scene.shapes[index as usize]);
    // Where two lines are separate solids, rays leave both through the ball at their joint, which
    // they meet once: the path still counts as inside of one of them then.
    let is_one = |shape: &Shape| {
        !is_round(shape) || shape.overlap == Overlap::Union || shape.elements.count() == 1
    };
    let is_whole = |shape: &Shape| shape.colors.iter().all(|color| color.w >= 1.0);
    solids().all(is_there)
        && shapes.all(|shape| is_whole(shape) && is_one(shape) && shape.is_closed())
}

/// False only if nothing emits inside of the solids that scatter.
fn is_lit_inside(scene: &Scene) -> bool {
    let boxes = |wanted: fn(&Material) -> bool| {
        let of =
            |(_, instance): &(u32, &Instance)| wanted(&scene.materials[instance.material as usize]);
        let found = (0..).zip(&scene.instances).filter(of);
        found.map(|(index, _)| scene.instance_bounds(index)).collect::<Vec<_>>()
    };
    let lamps = boxes(|material| material.emission != Vec3::ZERO);
    let solids = boxes(|material| {
        material.kind == MaterialKind::Refractive && material.albedo != Vec3::ZERO
    });
    let meet = |a: &Aabb, b: &Aabb| a.min.cmple(b.max).all() && b.min.cmple(a.max).all();
    solids.iter().any(|solid| lamps.iter().any(|lamp| meet(solid, lamp)))
}
