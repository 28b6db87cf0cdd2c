//! Rays from a camera through random points of a pixel.

use crate::{Sampler, warp};
use glam::Vec2;
use rotund_geometry::Ray;
use rotund_scene::Camera;

/// Returns the ray of a sample of pixel `(x, y)` in a picture of `width` x `height`, of unit
/// direction: through a random point of the pixel and of the lens.
///
/// It consumes set 0 of the sampler, so a custom integrator begins with set 1.
#[must_use]
pub fn camera_ray(
    camera: &Camera,
    [width, height]: [u32; 2],
    [x, y]: [u32; 2],
    sampler: &Sampler,
) -> Ray {
    let [u, v, lens_u, lens_v] = sampler.set(0);
    let size = Vec2::new(width as f32, height as f32);
    let image_uv = Vec2::new(x as f32 + u, y as f32 + v) / size;
    // A pinhole has no other point.
    let lens_uv =
        if camera.aperture == 0.0 { Vec2::ZERO } else { warp::disk(Vec2::new(lens_u, lens_v)) };
    camera.ray(image_uv, lens_uv)
}
