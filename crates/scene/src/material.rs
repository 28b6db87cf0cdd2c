//! How a surface scatters and emits light.

use glam::Vec3;

/// The scattering models that scenes name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MaterialKind {
    /// Lambertian.
    #[default]
    Matte,
    /// A dielectric coat over a Lambertian base.
    Glossy,
    /// A conductor.
    Reflective,
    /// The wall of a solid dielectric.
    Refractive,
    /// A thin sheet of a dielectric, which does not bend light.
    Transparent,
    /// The border of a cloud: it does nothing to light, but what is inside does.
    Volumetric,
}

/// The parameters of a surface as a file states them; textures are indices into
/// [`crate::Scene::textures`].
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Which model.
    pub kind: MaterialKind,
    /// Emitted radiance, from both sides.
    pub emission: Vec3,
    /// Albedo, reflectance at normal incidence, or transmission over [`Material::trdepth`].
    pub color: Vec3,
    /// Perceptual, `0.0..=1.0`: the width of the microfacet distribution is its square.
    pub roughness: f32,
    /// Index of refraction of the solid or coat.
    pub ior: f32,
    /// Depth in meters at which `color` is what remains of the light inside a solid or cloud.
    pub trdepth: f32,
    /// Single-scattering albedo of the medium inside: the fraction of the extinguished light that is
    /// scattered rather than absorbed. Scene files call it `scattering`.
    pub albedo: Vec3,
    /// Mean cosine of the scattering angle inside, strictly between -1 and 1; positive is forward
    /// scattering. Scene files call it `scanisotropy`.
    pub anisotropy: f32,
    /// Probability that the surface is there at all.
    pub opacity: f32,
    /// Scales emission.
    pub emission_tex: Option<u32>,
    /// Scales colour and, by its alpha, opacity.
    pub color_tex: Option<u32>,
    /// Its green scales roughness.
    pub roughness_tex: Option<u32>,
    /// Scales [`Material::albedo`], by its color where light enters the medium.
    pub scattering_tex: Option<u32>,
    /// A normal map.
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

/// A [`Material`] evaluated at a point: textures and vertex colours applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPoint {
    /// Which model.
    pub kind: MaterialKind,
    /// Emitted radiance, from both sides.
    pub emission: Vec3,
    /// Albedo or reflectance at normal incidence.
    pub color: Vec3,
    /// Probability that the surface is there at all.
    pub opacity: f32,
    /// Width of the microfacet distribution, the square of the roughness; zero means perfectly
    /// smooth.
    pub alpha: f32,
    /// Index of refraction of the solid or coat.
    pub ior: f32,
    /// Extinction per meter inside a solid or cloud.
    pub extinction: Vec3,
    /// Single-scattering albedo inside.
    pub albedo: Vec3,
    /// Mean cosine of the scattering angle inside.
    pub anisotropy: f32,
}
