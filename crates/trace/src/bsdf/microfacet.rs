//! The GGX distribution of microfacet normals. All vectors are local: +z is the normal.
//!
//! Source: B. Walter, S. Marschner, H. Li, K. Torrance, "Microfacet Models for Refraction through
//! Rough Surfaces", EGSR 2007.

use crate::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Returns the distribution D: the density of facets with normal `half` per area of the surface and
/// solid angle.
///
/// `half` must have unit length. The tangential part of `half` is computed from its x and y, since
/// `1 - z²` would cancel; so an alpha of 0.0009 keeps all digits.
#[must_use]
pub fn distribution(alpha: f32, half: Vec3) -> f32 {
    if half.z <= 0.0 {
        return 0.0;
    }
    let alpha2 = alpha * alpha;
    let d = (half.x * half.x + half.y * half.y) / alpha2 + half.z * half.z;
    1.0 / (PI * alpha2 * d * d)
}

/// Returns Smith's masking function G1 for GGX: the fraction of facets that are visible from
/// `direction`.
#[must_use]
pub fn visible(alpha: f32, direction: Vec3) -> f32 {
    let cosine = direction.z.abs();
    let sine2 = direction.x * direction.x + direction.y * direction.y;
    2.0 * cosine / (cosine + (cosine * cosine + alpha * alpha * sine2).sqrt())
}

/// Samples a facet normal that is visible from `outgoing`, with the density of [`pdf`].
///
/// Source: J. Dupuy, A. Benyoub, "Sampling Visible GGX Normals with Spherical Caps", Computer
/// Graphics Forum 42(8), 2023. The visible facets of a hemisphere reflect one direction uniformly
/// into a spherical cap about it, and a rough surface is a stretched hemisphere.
#[must_use]
pub fn sample(alpha: f32, outgoing: Vec3, u: Vec2) -> Vec3 {
    let stretch = Vec3::new(alpha, alpha, 1.0);
    let from = (stretch * outgoing).normalize();
    // A point of the cap z > -from.z, by an area-preserving map from the disk.
    let p = warp::disk(u);
    let r2 = p.length_squared();
    let height = 1.0 + from.z;
    // The point lies r² (1 + from.z) below the pole, on a circle of this radius.
    let down = r2 * height;
    let radius = if r2 > 0.0 { ((2.0 - down).max(0.0) * height).sqrt() } else { 0.0 };
    let reflected = (p * radius).extend(1.0 - down);
    (stretch * (reflected + from)).normalize_or(Vec3::Z)
}

/// Returns the density of [`sample`] per solid angle of the facet normal.
#[must_use]
pub fn pdf(alpha: f32, outgoing: Vec3, half: Vec3) -> f32 {
    visible(alpha, outgoing) * distribution(alpha, half) * outgoing.dot(half).max(0.0) / outgoing.z
}

/// Returns `D G / (4 cos cos)` times the cosine of the incoming direction: a reflecting lobe
/// without its Fresnel term. G is the separable product of both G1.
#[must_use]
pub fn reflection(alpha: f32, outgoing: Vec3, incoming: Vec3, half: Vec3) -> f32 {
    // A facet that faces away from either direction is shadowed.
    if outgoing.dot(half) <= 0.0 || incoming.dot(half) <= 0.0 {
        return 0.0;
    }
    distribution(alpha, half) * visible(alpha, outgoing) * visible(alpha, incoming)
        / (4.0 * outgoing.z)
}
