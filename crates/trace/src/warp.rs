//! Maps from the unit square to the shapes that samples are drawn from.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// A point of the unit disk, uniform by area; neighbours stay neighbours.
///
/// Source: P. Shirley, K. Chiu, "A low distortion map between disk and square", Journal of Graphics
/// Tools 2(3), 1997.
#[must_use]
pub fn disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - 1.0;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    radius * Vec2::from_angle(angle)
}

/// A direction about +z with density `z / π` per solid angle.
#[must_use]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = disk(u);
    p.extend((1.0 - p.length_squared()).max(0.0).sqrt())
}

/// A direction with density `1 / 4π` per solid angle.
#[must_use]
pub fn sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    // 1 - z² without cancellation near the poles.
    let radius = 2.0 * (u.x * (1.0 - u.x)).sqrt();
    (radius * Vec2::from_angle(TAU * u.y)).extend(z)
}

/// Barycentric weights of the second and third corner of a triangle, uniform by area.
///
/// Source: E. Heitz, "A low-distortion map between triangle and square", 2019.
#[must_use]
pub fn triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let half = 0.5 * u.x;
        Vec2::new(half, u.y - half)
    } else {
        let half = 0.5 * u.y;
        Vec2::new(u.x - half, half)
    }
}
