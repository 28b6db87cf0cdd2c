//! The GGX distribution of microfacet normals. All vectors are local: +z is the normal.
//!
//! Source: B. Walter, S. Marschner, H. Li, K. Torrance, "Microfacet Models for Refraction through
//! Rough Surfaces", EGSR 2007.

use crate::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Density D of facets with normal `half` per area of the surface and solid angle.
///
/// `half` must have unit length. Squares of its small coordinates stand where the usual `1 - z²`
/// would cancel, so that a width of 0.0009 keeps all digits.
#[must_use]
pub fn distribution(alpha: f32, half: Vec3) -> f32 {
    if half.z <= 0.0 {
        return 0.0;
    }
    let alpha2 = alpha * alpha;
    let d = (half.x * half.x + half.y * half.y) / alpha2 + half.z * half.z;
    1.0 / (PI * alpha2 * d * d)
}

/// The share G1 of facets that are visible from `direction`: Smith's, for GGX.
#[must_use]
pub fn visible(alpha: f32, direction: Vec3) -> f32 {
    let cosine = direction.z.abs();
    let sine2 = direction.x * direction.x + direction.y * direction.y;
    2.0 * cosine / (cosine + (cosine * cosine + alpha * alpha * sine2).sqrt())
}

/// A facet normal that is visible from `outgoing`, with the density of [`pdf`].
///
/// Source: J. Dupuy, A. Benyoub, "Sampling Visible GGX Normals with Spherical Caps", Computer
/// Graphics Forum 42(8), 2023: the visible facets of a hemisphere, lit from one direction,
/// reflect into a spherical cap about it; rough surfaces are stretched hemispheres.
#[must_use]
pub fn sample(alpha: f32, outgoing: Vec3, u: Vec2) -> Vec3 {
    let stretch = Vec3::new(alpha, alpha, 1.0);
    let from = (stretch * outgoing).normalize();
    // A point of the cap z > -from.z: a disk is bent onto it, which keeps area.
    let p = warp::disk(u);
    let r2 = p.length_squared();
    let height = 1.0 + from.z;
    // r² (1 + from.z) is how far below the pole the point lies; the circle there has this radius.
    let down = r2 * height;
    let radius = if r2 > 0.0 { ((2.0 - down).max(0.0) * height).sqrt() } else { 0.0 };
    let reflected = (p * radius).extend(1.0 - down);
    (stretch * (reflected + from)).normalize_or(Vec3::Z)
}

/// Density of [`sample`] per solid angle of the facet normal.
#[must_use]
pub fn pdf(alpha: f32, outgoing: Vec3, half: Vec3) -> f32 {
    visible(alpha, outgoing) * distribution(alpha, half) * outgoing.dot(half).max(0.0) / outgoing.z
}

/// D G / (4 cos cos) times the cosine of the incoming side: a reflecting lobe without its Fresnel
/// term. Shadowing is separable: G is the product of both G1.
#[must_use]
pub fn reflection(alpha: f32, outgoing: Vec3, incoming: Vec3, half: Vec3) -> f32 {
    // A facet whose back is seen from either side is shadowed.
    if outgoing.dot(half) <= 0.0 || incoming.dot(half) <= 0.0 {
        return 0.0;
    }
    distribution(alpha, half) * visible(alpha, outgoing) * visible(alpha, incoming)
        / (4.0 * outgoing.z)
}
