//! A loaded scene, with what the viewer adds to it.

use crate::content::Content;
use crate::settings::{OverlapChoice, Settings};
use crate::side::Side;
use glam::{Vec2, Vec3};
use rotund_geometry::Aabb;
use rotund_scene::{Camera, Elements, Overlap, Scene, SceneError};
use rotund_trace::{Stage, World};

/// A loaded scene on a stage.
#[derive(Debug)]
pub(crate) struct Place {
    pub(crate) name: String,
    pub(crate) warnings: Vec<String>,
    /// Number of points, lines, triangles and quads, each instance counted.
    pub(crate) elements: [u64; 4],
    stage: Stage,
    /// Number of cameras of the scene. The one after them is that of the client whose turn it is.
    cameras: usize,
    /// Overlap of each shape by the file.
    overlaps: Vec<Overlap>,
    /// Center and radius of what is to be seen.
    extent: (Vec3, f32),
}

impl Place {
    /// Builds the trees and lights of a scene.
    pub(crate) fn new(content: Content) -> Result<Self, SceneError> {
        let Content { name, scene, warnings, files: _ } = content;
        let cameras = scene.cameras.len();
        let overlaps = scene.shapes.iter().map(|shape| shape.overlap).collect();
        let elements = count_elements(&scene);
        let extent = extent(&scene);
        let stage = Stage::new(scene)?;
        Ok(Self { name, warnings, elements, stage, cameras, overlaps, extent })
    }

    /// Returns the cameras of the scene.
    pub(crate) fn cameras(&self) -> &[Camera] {
        &self.stage.scene().cameras[..self.cameras]
    }

    /// Returns the index of the camera that [`Self::configure`] sets.
    pub(crate) fn seat_camera(&self) -> usize {
        self.cameras
    }

    pub(crate) fn world(&self) -> World<'_> {
        self.stage.world()
    }

    /// Returns center and radius of what is to be seen.
    pub(crate) fn extent(&self) -> (Vec3, f32) {
        self.extent
    }

    /// Makes the scene what one side of a client shows.
    pub(crate) fn configure(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        side: Side,
    ) -> Result<(), SceneError> {
        self.stage.set_camera(self.cameras, camera.clone())?;
        for (kind, method) in settings.methods(side) {
            self.stage.set_method(kind, method);
        }
        let overlaps = &self.overlaps;
        self.stage.set_overlap(|shape| match settings.overlap {
            OverlapChoice::Scene => overlaps[shape],
            OverlapChoice::Union => Overlap::Union,
            OverlapChoice::Separate => Overlap::Separate,
        })
    }

    /// Returns the point that a camera turns about before anything is grabbed: what the center of
    /// the picture shows, or what is in focus.
    pub(crate) fn pivot(&self, camera: &Camera) -> Vec3 {
        let ray = camera.ray(Vec2::splat(0.5), Vec2::ZERO);
        if let Some(hit) = self.world().closest(&ray) {
            return hit.position;
        }
        let (center, radius) = self.extent;
        let along = (center - ray.origin).dot(ray.direction);
        let distance = if along > 0.0 { along } else { camera.focus.min(radius) };
        ray.origin + ray.direction * distance
    }
}

fn count_elements(scene: &Scene) -> [u64; 4] {
    let mut counts = [0; 4];
    for instance in &scene.instances {
        let shape = &scene.shapes[instance.shape as usize];
        let kind = match &shape.elements {
            Elements::Points(_) => 0,
            Elements::Lines(_) => 1,
            Elements::Triangles(_) => 2,
            Elements::Quads(_) => 3,
        };
        counts[kind] += shape.elements.count() as u64;
    }
    counts
}

/// Returns center and radius of the bounds of all instances, grounds and backdrops left out: flat
/// ones that are much larger than all others together.
fn extent(scene: &Scene) -> (Vec3, f32) {
    let boxes = (0..scene.instances.len() as u32).map(|index| scene.instance_bounds(index));
    let boxes: Vec<Aabb> = boxes.filter(|it| it.min.is_finite() && it.max.is_finite()).collect();
    let is_flat = |it: &&Aabb| {
        let size = it.max - it.min;
        size.min_element() <= 1e-3 * size.max_element()
    };
    let around =
        |boxes: &mut dyn Iterator<Item = &Aabb>| boxes.fold(Aabb::EMPTY, |all, it| all.union(*it));
    let radius = |it: &Aabb| 0.5 * (it.max - it.min).length();
    let solids = around(&mut boxes.iter().filter(|it| !is_flat(it)));
    let has_solids = solids.min.cmple(solids.max).all();
    let seen = around(
        &mut boxes
            .iter()
            .filter(|it| !(has_solids && is_flat(it) && radius(it) > 4.0 * radius(&solids))),
    );
    if !seen.min.cmple(seen.max).all() {
        return (Vec3::ZERO, 1.0);
    }
    let least = 1e-6 * seen.center().abs().max_element();
    (seen.center(), radius(&seen).max(least).max(1e-6))
}
