//! A rough boundary between dielectrics. All vectors are local: +z is the normal on the side of
//! `outgoing`; `eta` is the index beyond the boundary over the index on that side.
//!
//! Source: B. Walter et al., EGSR 2007, equations 16, 17 and 21; without the scaling of radiance.

use super::{BsdfValue, NOTHING, fresnel, microfacet, reflect, reflection_pdf, refract};
use glam::{Vec2, Vec3};

pub(super) fn eval(alpha: f32, eta: f32, outgoing: Vec3, incoming: Vec3) -> BsdfValue {
    if incoming.z > 0.0 {
        let half = (outgoing + incoming).normalize();
        let f = fresnel::dielectric(eta, outgoing.dot(half));
        return BsdfValue {
            value: Vec3::splat(f * microfacet::reflection(alpha, outgoing, incoming, half)),
            pdf: f * reflection_pdf(alpha, outgoing, half),
        };
    }
    let sum = eta * incoming + outgoing;
    let half = sum.normalize_or_zero() * if sum.z < 0.0 { -1.0 } else { 1.0 };
    let (o, i) = (outgoing.dot(half), incoming.dot(half));
    // Refraction connects opposite sides of a facet.
    if o <= 0.0 || i >= 0.0 {
        return NOTHING;
    }
    let f = fresnel::dielectric(eta, o);
    // Solid angle of facet normals per solid angle of incoming directions.
    let d = eta * i + o;
    let jacobian = eta * eta * i.abs() / (d * d);
    let facets = (1.0 - f) * microfacet::pdf(alpha, outgoing, half) * jacobian;
    BsdfValue { value: Vec3::splat(facets * microfacet::visible(alpha, incoming)), pdf: facets }
}

pub(super) fn sample(alpha: f32, eta: f32, outgoing: Vec3, choice: f32, u: Vec2) -> Option<Vec3> {
    let half = microfacet::sample(alpha, outgoing, u);
    let reflected = choice < fresnel::dielectric(eta, outgoing.dot(half));
    let incoming = if reflected { reflect(outgoing, half) } else { refract(eta, outgoing, half)? };
    // A facet may reflect light to the far side of the surface or refract it to the near side,
    // where it would meet another facet. The model ignores multiple scattering: that light is lost.
    ((incoming.z > 0.0) == reflected).then_some(incoming)
}
