//! Published intersectors, written anew from their descriptions in the precision of the
//! publication. They exist for comparison, are not part of the library, and keep their known
//! weaknesses.

pub(crate) mod interval;
pub(crate) mod patch;
pub(crate) mod rounded_cone;
pub(crate) mod sphere;

use glam::{Vec2, Vec3};
use rotund_geometry::{Hit, Ray};

/// Returns a hit without error bound and parameters.
fn hit(t: f32, position: Vec3, normal: Vec3) -> Hit {
    Hit { t, position, error: 0.0, normal, parameters: Vec2::ZERO }
}

/// Returns whether `t` lies in the interval of the ray.
fn inside(ray: &Ray, t: f32) -> bool {
    ray.t_min <= t && t <= ray.t_max
}

/// Returns the smaller of two roots that lies in the interval of the ray.
fn first(ray: &Ray, a: f32, b: f32) -> Option<f32> {
    let (near, far) = if a <= b { (a, b) } else { (b, a) };
    [near, far].into_iter().find(|&t| inside(ray, t))
}
