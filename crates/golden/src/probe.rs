//! The rays that find the surfaces of a picture.

use glam::{Vec2, Vec3};
use rotund_scene::{Camera, Scene, Trees};
use std::f32::consts::TAU;

/// A pixel has this many rays in each direction, on a regular grid.
pub(crate) const SIDE: usize = 4;
/// Number of rays through a pixel.
pub(crate) const RAYS: usize = SIDE * SIDE;
/// Number of values of a probe.
pub(crate) const VALUES: usize = 12;
/// More crossings than this indicate repeated self-intersection.
const MAX_CROSSINGS: u32 = 64;

/// Result of one ray of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Probe {
    /// Number of surfaces along the whole ray.
    pub(crate) crossings: u32,
    /// True if a second ray, from the first surface in a fixed direction, meets nothing.
    pub(crate) escapes: bool,
    /// `t` of the first surface.
    pub(crate) depth: f32,
    /// Shading normal of the first surface.
    pub(crate) normal: Vec3,
    /// Texture coordinates of the first surface.
    pub(crate) texcoord: Vec2,
    /// Material colour of the first surface.
    pub(crate) color: Vec3,
}

impl Probe {
    /// Follows a camera ray through all surfaces. `index` is that of the ray in its pixel,
    /// `0..RAYS`.
    pub(crate) fn new(
        scene: &Scene,
        trees: &Trees,
        camera: &Camera,
        image_uv: Vec2,
        index: usize,
    ) -> Self {
        let mut ray = camera.ray(image_uv, Vec2::ZERO);
        let Some(first) = trees.closest(scene, &ray) else { return Self::default() };
        let mut crossings = 1;
        let mut hit = first;
        while crossings < MAX_CROSSINGS {
            ray.origin = hit.spawn(ray.direction).origin;
            let left = hit.left_by(ray.direction);
            let Some(next) = trees.closest_after(scene, &ray, left) else { break };
            (hit, crossings) = (next, crossings + 1);
        }
        let away = {
            let direction = fixed_direction(index);
            let side = first.normal.dot(direction) * first.normal.dot(ray.direction);
            if side > 0.0 { -direction } else { direction }
        };
        let material = scene.eval_material(first.instance, first.element, first.uv);
        Self {
            crossings,
            escapes: !trees.any_after(scene, &first.spawn(away), first.left_by(away)),
            depth: first.t,
            normal: scene.shading_normal(&first, -ray.direction),
            texcoord: scene.eval_texcoord(first.instance, first.element, first.uv),
            color: material.color,
        }
    }

    /// Returns all numbers, in the order of the channels of a surface.
    pub(crate) fn values(&self) -> [f32; VALUES] {
        let Self { crossings, escapes, depth, normal: n, texcoord: uv, color: c } = *self;
        let coverage = f32::from(u8::from(crossings > 0));
        let shadow = f32::from(u8::from(escapes));
        [coverage, crossings as f32, shadow, depth, n.x, n.y, n.z, uv.x, uv.y, c.x, c.y, c.z]
    }
}

/// Returns one of [`RAYS`] directions spread evenly over the sphere (R. Swinbank, R. Purser,
/// "Fibonacci grids", Quarterly Journal of the Royal Meteorological Society 132, 2006).
fn fixed_direction(index: usize) -> Vec3 {
    const GOLDEN_RATIO: f32 = 1.618_034;
    let z = 1.0 - (2 * index + 1) as f32 / RAYS as f32;
    let (sin, cos) = (TAU * (index as f32 / GOLDEN_RATIO).fract()).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fixed_directions_have_unit_length_and_cover_the_sphere() {
        let directions: Vec<Vec3> = (0..RAYS).map(fixed_direction).collect();
        let sum: Vec3 = directions.iter().sum();
        assert!(directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-6));
        assert!(sum.length() < 0.1 * RAYS as f32, "{sum}");
    }
}
