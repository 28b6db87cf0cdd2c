//! The phase function of participating media.
//!
//! Source: L. Henyey, J. Greenstein, "Diffuse radiation in the galaxy", Astrophysical Journal 93,
//! 1941.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// Returns the Henyey-Greenstein phase function for light from `incoming` that is scattered to
/// `outgoing`, which is also the density of [`sample`] per solid angle. Both directions point away
/// from the vertex and have unit length. `g`, strictly between -1 and 1, is the mean cosine of the
/// scattering angle.
#[must_use]
pub fn henyey_greenstein(g: f32, outgoing: Vec3, incoming: Vec3) -> f32 {
    let cosine = -outgoing.dot(incoming);
    // 1 + g² - 2 g cos, in a form that cannot become negative.
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine).max(0.0);
    0.25 * FRAC_1_PI * (1.0 - g * g) / (denominator * denominator.sqrt())
}

/// Samples an incoming direction with the density of [`henyey_greenstein`].
#[must_use]
pub fn sample(g: f32, outgoing: Vec3, u: Vec2) -> Vec3 {
    // For g near 0 the inverse below would divide zero by zero. Its error, of the order of roundoff
    // over g, is less than that of the isotropic formula, of the order of g, down to this g.
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
