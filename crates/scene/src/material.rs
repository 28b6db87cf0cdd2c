//! How a surface scatters and emits light.

use glam::Vec3;

/// The scattering models of surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MaterialKind {
    /// A Lambertian surface.
    #[default]
    Matte,
    /// A dielectric coat over a Lambertian base.
    Glossy,
    /// A conductor.
    Reflective,
    /// The boundary of a dielectric solid.
    Refractive,
    /// A thin dielectric sheet, which transmits light without refraction.
    Transparent,
    /// The boundary of a participating medium, which itself neither reflects nor refracts.
    Volumetric,
}

/// The parameters of a surface. Textures are indices into [`crate::Scene::textures`].
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name for messages; may be empty.
    pub name: String,
    /// The scattering model.
    pub kind: MaterialKind,
    /// Emitted radiance, from both sides.
    pub emission: Vec3,
    /// Albedo, reflectance at normal incidence, or transmittance over [`Material::trdepth`], by the
    /// kind of the material. `0.0..=1.0`: a larger one, which is not refused, creates energy.
    pub color: Vec3,
    /// Perceptual roughness, `0.0..=1.0`; its square is the width of the microfacet distribution.
    pub roughness: f32,
    /// Index of refraction of the solid or coat.
    pub ior: f32,
    /// Distance in meters over which `color` is the transmittance inside a solid or medium.
    pub trdepth: f32,
    /// Single-scattering albedo of the medium inside, `0.0..=1.0`: the fraction of the extinguished
    /// light that is scattered rather than absorbed. Scene files call it `scattering`.
    pub albedo: Vec3,
    /// Mean cosine of the scattering angle inside, strictly between -1 and 1; positive is forward
    /// scattering. Scene files call it `scanisotropy`.
    pub anisotropy: f32,
    /// Probability that a ray meets the surface rather than passing through.
    pub opacity: f32,
    /// Scales [`Material::emission`].
    pub emission_tex: Option<u32>,
    /// Scales [`Material::color`] and, by its alpha, [`Material::opacity`].
    pub color_tex: Option<u32>,
    /// Scales [`Material::roughness`] by its green channel.
    pub roughness_tex: Option<u32>,
    /// Scales [`Material::albedo`], by its color where light enters the medium.
    pub scattering_tex: Option<u32>,
    /// Normal map in tangent space.
    pub normal_tex: Option<u32>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: MaterialKind::Matte,
            emission: Vec3::ZERO,
            color: Vec3::ZERO,
            roughness: 0.0,
            ior: 1.5,
            trdepth: 0.01,
            albedo: Vec3::ZERO,
            anisotropy: 0.0,
            opacity: 1.0,
            emission_tex: None,
            color_tex: None,
            roughness_tex: None,
            scattering_tex: None,
            normal_tex: None,
        }
    }
}

/// A [`Material`] at a surface point, with textures and vertex colours applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPoint {
    /// The scattering model.
    pub kind: MaterialKind,
    /// Emitted radiance, from both sides.
    pub emission: Vec3,
    /// Albedo or reflectance at normal incidence.
    pub color: Vec3,
    /// Probability that a ray meets the surface rather than passing through.
    pub opacity: f32,
    /// Width of the microfacet distribution, the square of the roughness; zero for a perfectly
    /// smooth surface.
    pub alpha: f32,
    /// Index of refraction of the solid or coat.
    pub ior: f32,
    /// Extinction coefficient inside a solid or medium, per meter.
    pub extinction: Vec3,
    /// Single-scattering albedo inside.
    pub albedo: Vec3,
    /// Mean cosine of the scattering angle inside.
    pub anisotropy: f32,
}
