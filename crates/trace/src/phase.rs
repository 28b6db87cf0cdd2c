//! Scattering inside of solids and clouds.
//!
//! Source: L. Henyey, J. Greenstein, "Diffuse radiation in the galaxy", Astrophysical Journal 93, 1941.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Density per solid angle, and the value, of light from `incoming` that is scattered to `outgoing`;
/// both point away and have unit length. `g` in `-1.0..1.0` is the mean cosine of the deflection.
#[must_use]
pub fn henyey_greenstein(g: f32, outgoing: Vec3, incoming: Vec3) -> f32 {
    let cosine = -outgoing.dot(incoming);
    // 1 + g² - 2 g cos, which cannot become negative in this form.
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine).max(0.0);
    0.25 * FRAC_1_PI * (1.0 - g * g) / (denominator * denominator.sqrt())
}

/// A direction with the density of [`henyey_greenstein`].
#[must_use]
pub fn sample(g: f32, outgoing: Vec3, u: Vec2) -> Vec3 {
    // Nearly isotropic, the inverse below would divide zero by zero; what it loses there, of the order
    // of its roundoff over g, is less than what isotropy loses, of the order of g, down to this g.
    let cosine = if g.abs() < f32::EPSILON.sqrt() {
        1.0 - 2.0 * u.x
    } else {
        let root = (1.0 - g * g) / (1.0 + g - 2.0 * g * u.x);
        ((1.0 + g * g - root * root) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    let (x, y) = outgoing.any_orthonormal_pair();
    let around = Vec2::from_angle(TAU * u.y);
    (-cosine * outgoing + sine * (around.x * x + around.y * y)).normalize()
}
