//! A thin sheet of a rough dielectric: the transmitted lobe is the mirror image of the reflected
//! one. All vectors are local: +z is the normal on the side of `outgoing`.

use super::{BsdfValue, fresnel, microfacet, reflect, reflection_pdf};
use glam::{Vec2, Vec3};

pub(super) fn eval(alpha: f32, ior: f32, color: Vec3, outgoing: Vec3, incoming: Vec3) -> BsdfValue {
    let mirrored = incoming.with_z(incoming.z.abs());
    let half = (outgoing + mirrored).normalize();
    let f = fresnel::dielectric(ior, outgoing.dot(half));
    let (chance, tint) = if incoming.z > 0.0 { (f, Vec3::ONE) } else { (1.0 - f, color) };
    BsdfValue {
        value: chance * tint * microfacet::reflection(alpha, outgoing, mirrored, half),
        pdf: chance * reflection_pdf(alpha, outgoing, half),
    }
}

pub(super) fn sample(alpha: f32, ior: f32, outgoing: Vec3, choice: f32, u: Vec2) -> Option<Vec3> {
    let half = microfacet::sample(alpha, outgoing, u);
    let reflected = reflect(outgoing, half);
    let through = choice >= fresnel::dielectric(ior, outgoing.dot(half));
    let incoming = if through { reflected.with_z(-reflected.z) } else { reflected };
    // Light that a facet reflects into the surface is lost: the model ignores multiple scattering.
    (reflected.z > 0.0).then_some(incoming)
}
