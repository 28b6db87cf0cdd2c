//! Scattering at surfaces: one [`Bsdf`] per shading point.
//!
//! | material | lobes |
//! | --- | --- |
//! | matte | Lambert |
//! | glossy | GGX with dielectric Fresnel; Lambert up to 0.999, times 1 - F(normal, outgoing) |
//! | reflective | GGX with conductor Fresnel, or a mirror |
//! | refractive | GGX with dielectric Fresnel, reflected and refracted, or a smooth boundary |
//! | transparent | GGX with dielectric Fresnel and its tinted mirror image, or a smooth sheet |
//! | volumetric | none: light passes straight |
//!
//! Values include the cosine of the incoming direction. Refraction does not scale radiance by the
//! squared ratio of indices, because the factors cancel along every path that leaves a solid again.

mod frame;
pub mod fresnel;
pub mod microfacet;
mod rough_glass;
mod thin_sheet;

use crate::warp;
use frame::Frame;
use glam::{Vec2, Vec3};
use rotund_scene::{MaterialKind, MaterialPoint};
use std::f32::consts::FRAC_1_PI;

/// The BSDF of a surface point for one outgoing direction.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    frame: Frame,
    /// In local coordinates, on the upper side.
    outgoing: Vec3,
    lobes: Lobes,
}

/// The value of a BSDF for an incoming direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfValue {
    /// The BSDF times the absolute cosine between incoming direction and normal, per channel.
    pub value: Vec3,
    /// Density of [`Bsdf::sample`] per solid angle.
    pub pdf: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Direction to the light, of unit length, in world space.
    pub incoming: Vec3,
    /// The BSDF times the cosine, divided by the density: the factor of the throughput.
    pub weight: Vec3,
    /// Density per solid angle, or `None` for a delta direction, which no other technique can
    /// sample.
    pub pdf: Option<f32>,
}

/// The lobes of the materials, with the factors that do not depend on the incoming direction.
#[derive(Clone, Copy, Debug)]
enum Lobes {
    Matte { color: Vec3 },
    Glossy { alpha: f32, eta: f32, base: Vec3, specular_chance: f32 },
    Metal { alpha: f32, color: Vec3 },
    Mirror { color: Vec3 },
    RoughGlass { alpha: f32, eta: f32 },
    Glass { eta: f32 },
    RoughSheet { alpha: f32, ior: f32, color: Vec3 },
    Sheet { ior: f32, color: Vec3 },
    Nothing,
}

/// Largest albedo of the base of a glossy surface.
///
/// The base is weighted by the Fresnel term of the normal, the coat by that of each facet. With a
/// white base they would together reflect up to 1.00072 of white light, at an index of 1.33, an
/// alpha of 0.1 and a cosine of 0.68. A base of 0.99925 or less gains no energy at any index, alpha
/// and angle.
const WHITEST_BASE: f32 = 0.999;

const NOTHING: BsdfValue = BsdfValue { value: Vec3::ZERO, pdf: 0.0 };

impl Bsdf {
    /// Makes the BSDF of a material for light that leaves to `outgoing`. `normal` is the shading
    /// normal; both have unit length. The normal of a refractive material must point out of the
    /// solid; that of others may point to either side.
    #[must_use]
    pub fn new(material: &MaterialPoint, normal: Vec3, outgoing: Vec3) -> Self {
        let &MaterialPoint { kind, color, alpha, ior, .. } = material;
        let inside = normal.dot(outgoing) < 0.0;
        let frame = Frame::new(if inside { -normal } else { normal });
        let mut local = frame.local_from_world(outgoing);
        // An exactly grazing direction is replaced by the limit from above, so that no term divides
        // by 0.
        local.z = local.z.max(f32::MIN_POSITIVE.sqrt());
        let lobes = match kind {
            MaterialKind::Matte => Lobes::Matte { color },
            MaterialKind::Glossy => {
                let reflected = fresnel::dielectric(ior, local.z);
                let base = (1.0 - reflected) * color.min(Vec3::splat(WHITEST_BASE));
                // Square roots sample the coat more often than its reflectance says, a sixth of the
                // time for a twentieth: light samples find most of what the base reflects, but
                // rarely hit the narrow lobe of the coat.
                let [coat, below] = [reflected, base.max_element()].map(f32::sqrt);
                let sum = coat + below;
                let specular_chance = if sum > 0.0 { coat / sum } else { 1.0 };
                Lobes::Glossy { alpha, eta: ior, base, specular_chance }
            }
            MaterialKind::Reflective if alpha == 0.0 => Lobes::Mirror { color },
            MaterialKind::Reflective => Lobes::Metal { alpha, color },
            MaterialKind::Refractive => {
                let eta = if inside { 1.0 / ior } else { ior };
                // Equal indices make no boundary, rough or smooth. If they differ by less than
                // 2^-10, the half vector, a difference of directions, would lose more than 10 of
                // its bits.
                if alpha == 0.0 || (eta - 1.0).abs() < 1.0 / 1024.0 {
                    Lobes::Glass { eta }
                } else {
                    Lobes::RoughGlass { alpha, eta }
                }
            }
            MaterialKind::Transparent if alpha == 0.0 => Lobes::Sheet { ior, color },
            MaterialKind::Transparent => Lobes::RoughSheet { alpha, ior, color },
            MaterialKind::Volumetric => Lobes::Nothing,
        };
        Self { frame, outgoing: local, lobes }
    }

    /// Returns true if all lobes are delta functions, whose directions only [`Bsdf::sample`] finds.
    #[must_use]
    pub fn is_delta(&self) -> bool {
        matches!(
            self.lobes,
            Lobes::Mirror { .. } | Lobes::Glass { .. } | Lobes::Sheet { .. } | Lobes::Nothing
        )
    }

    /// Returns value and density for light from `incoming`, of unit length; both are zero for delta
    /// lobes.
    #[must_use]
    pub fn eval(&self, incoming: Vec3) -> BsdfValue {
        self.eval_local(self.frame.local_from_world(incoming))
    }

    fn eval_local(&self, incoming: Vec3) -> BsdfValue {
        let outgoing = self.outgoing;
        if let Lobes::RoughGlass { alpha, eta } = self.lobes {
            return rough_glass::eval(alpha, eta, outgoing, incoming);
        }
        if let Lobes::RoughSheet { alpha, ior, color } = self.lobes {
            return thin_sheet::eval(alpha, ior, color, outgoing, incoming);
        }
        if incoming.z <= 0.0 {
            return NOTHING;
        }
        match self.lobes {
            Lobes::Matte { color } => {
                let cosine = FRAC_1_PI * incoming.z;
                BsdfValue { value: color * cosine, pdf: cosine }
            }
            Lobes::Glossy { alpha, eta, base, specular_chance } => {
                let half = (outgoing + incoming).normalize();
                let cosine = FRAC_1_PI * incoming.z;
                let f = fresnel::dielectric(eta, incoming.dot(half));
                let specular = f * microfacet::reflection(alpha, outgoing, incoming, half);
                let specular_pdf = reflection_pdf(alpha, outgoing, half);
                BsdfValue {
                    value: base * cosine + specular,
                    pdf: specular_chance * specular_pdf + (1.0 - specular_chance) * cosine,
                }
            }
            Lobes::Metal { alpha, color } => {
                let half = (outgoing + incoming).normalize();
                let f = fresnel::conductor(color, incoming.dot(half));
                BsdfValue {
                    value: f * microfacet::reflection(alpha, outgoing, incoming, half),
                    pdf: reflection_pdf(alpha, outgoing, half),
                }
            }
            Lobes::RoughGlass { .. }
            | Lobes::Mirror { .. }
            | Lobes::Glass { .. }
            | Lobes::RoughSheet { .. }
            | Lobes::Sheet { .. }
            | Lobes::Nothing => NOTHING,
        }
    }

    /// Returns the two directions that a smooth boundary of dielectrics reflects and transmits,
    /// each as [`Self::sample`] does, and the probability of the first; `None` for other surfaces,
    /// and where the boundary reflects everything.
    pub(crate) fn both(&self) -> Option<([BsdfSample; 2], f32)> {
        let outgoing = self.outgoing;
        let (f, through, color) = match self.lobes {
            Lobes::Sheet { ior, color } => (fresnel::dielectric(ior, outgoing.z), -outgoing, color),
            Lobes::Glass { eta } => {
                let through = refract(eta, outgoing, Vec3::Z)?;
                (fresnel::dielectric(eta, outgoing.z), through, Vec3::ONE)
            }
            _ => return None,
        };
        let mirrored = Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
        let delta = |incoming: Vec3, weight: Vec3| {
            let incoming = self.frame.world_from_local(incoming);
            BsdfSample { incoming, weight, pdf: None }
        };
        Some(([delta(mirrored, Vec3::ONE), delta(through, color)], f))
    }

    /// Samples an incoming direction: `choice` picks the lobe, `u` the direction in it, all uniform
    /// in `0.0..1.0`. Returns `None` if the surface absorbs the path.
    #[must_use]
    pub fn sample(&self, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let outgoing = self.outgoing;
        let mirrored = Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
        let delta = |incoming: Vec3, weight: Vec3| {
            let incoming = self.frame.world_from_local(incoming);
            Some(BsdfSample { incoming, weight, pdf: None })
        };
        let incoming = match self.lobes {
            Lobes::Matte { .. } => warp::cosine_hemisphere(u),
            Lobes::Glossy { alpha, specular_chance, .. } => {
                if choice < specular_chance {
                    reflect(outgoing, microfacet::sample(alpha, outgoing, u))
                } else {
                    warp::cosine_hemisphere(u)
                }
            }
            Lobes::Metal { alpha, .. } => reflect(outgoing, microfacet::sample(alpha, outgoing, u)),
            Lobes::RoughGlass { alpha, eta } => {
                rough_glass::sample(alpha, eta, outgoing, choice, u)?
            }
            Lobes::RoughSheet { alpha, ior, .. } => {
                thin_sheet::sample(alpha, ior, outgoing, choice, u)?
            }
            Lobes::Sheet { ior, color } => {
                return if choice < fresnel::dielectric(ior, outgoing.z) {
                    delta(mirrored, Vec3::ONE)
                } else {
                    delta(-outgoing, color)
                };
            }
            Lobes::Nothing => return delta(-outgoing, Vec3::ONE),
            Lobes::Mirror { color } => {
                return delta(mirrored, fresnel::conductor(color, outgoing.z));
            }
            Lobes::Glass { eta } => {
                return if choice < fresnel::dielectric(eta, outgoing.z) {
                    delta(mirrored, Vec3::ONE)
                } else {
                    delta(refract(eta, outgoing, Vec3::Z)?, Vec3::ONE)
                };
            }
        };
        // The comparison is false for NaN.
        let BsdfValue { value, pdf } = self.eval_local(incoming);
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample {
            incoming: self.frame.world_from_local(incoming),
            weight: value / pdf,
            pdf: Some(pdf),
        })
    }
}

/// Reflects `direction` about `half`; both point away from the surface.
fn reflect(direction: Vec3, half: Vec3) -> Vec3 {
    2.0 * direction.dot(half) * half - direction
}

/// Returns the direction beyond a boundary with normal `half` whose light is refracted to
/// `outgoing`, or `None` at total internal reflection. `eta` is the index beyond over the index on
/// this side.
fn refract(eta: f32, outgoing: Vec3, half: Vec3) -> Option<Vec3> {
    let cosine = outgoing.dot(half);
    let transmitted2 = 1.0 - (1.0 - cosine * cosine).max(0.0) / (eta * eta);
    (transmitted2 > 0.0)
        .then(|| ((cosine / eta - transmitted2.sqrt()) * half - outgoing / eta).normalize())
}

/// Returns the density of reflected directions when visible facet normals are sampled.
fn reflection_pdf(alpha: f32, outgoing: Vec3, half: Vec3) -> f32 {
    // microfacet::pdf over the Jacobian 4 (outgoing . half): the dot product cancels.
    if outgoing.dot(half) <= 0.0 {
        return 0.0;
    }
    microfacet::visible(alpha, outgoing) * microfacet::distribution(alpha, half)
        / (4.0 * outgoing.z)
}
