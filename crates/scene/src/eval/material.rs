//! Evaluation of materials with textures and vertex colours.

use crate::{Material, MaterialKind, MaterialPoint, Scene};
use glam::{Vec2, Vec3, Vec4};

/// The width of the narrowest microfacet distribution, a roughness of 0.03 squared. Narrower ones
/// are perfectly smooth.
const LEAST_ALPHA: f32 = 0.03 * 0.03;

impl Scene {
    /// Returns the radiance that a point emits to both sides: emission of the material times vertex
    /// colour and texture. Opacity is not applied.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_emission(&self, instance: u32, element: u32, uv: Vec2) -> Vec3 {
        let material = &self.materials[self.instances[instance as usize].material as usize];
        if material.emission == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let Some(index) = material.emission_tex else {
            return material.emission * self.eval_color(instance, element, uv).truncate();
        };
        let glow = self.textures[index as usize].color(self.eval_texcoord(instance, element, uv));
        let vertex = self.eval_color(instance, element, uv);
        (material.emission * glow.truncate() * vertex.truncate()).max(Vec3::ZERO)
    }

    /// Returns the material at a point: colour and emission times vertex colour and texture,
    /// opacity times both alphas, roughness times the green of its texture, single-scattering
    /// albedo times its texture.
    ///
    /// `alpha` of matte and glossy surfaces is at least 0.0009. Others with a smaller one are
    /// perfectly smooth.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_material(&self, instance: u32, element: u32, uv: Vec2) -> MaterialPoint {
        let placed = &self.instances[instance as usize];
        let material = &self.materials[placed.material as usize];
        let textured = [material.color_tex, material.roughness_tex, material.scattering_tex]
            .iter()
            .any(Option::is_some);
        let coloured = !self.shapes[placed.shape as usize].colors.is_empty();
        if !(textured || coloured || material.emission_tex.is_some()) {
            // The usual case, for which all factors are known to be one.
            return point(material, Vec4::ONE, [Vec4::ONE; 3], material.emission);
        }
        let vertex = self.eval_color(instance, element, uv);
        let texcoord =
            if textured { self.eval_texcoord(instance, element, uv) } else { Vec2::ZERO };
        let texture = |index: Option<u32>| index.map(|index| &self.textures[index as usize]);
        let color_texel = texture(material.color_tex).map_or(Vec4::ONE, |t| t.color(texcoord));
        let roughness_texel =
            texture(material.roughness_tex).map_or(Vec4::ONE, |t| t.data(texcoord));
        let scattering_texel =
            texture(material.scattering_tex).map_or(Vec4::ONE, |t| t.color(texcoord));
        let texels = [color_texel, roughness_texel, scattering_texel];
        point(material, vertex, texels, self.eval_emission(instance, element, uv))
    }
}

/// Returns the material at a point with this colour of the vertices and these texels of colour,
/// roughness and scattering.
#[inline(always)]
fn point(
    material: &Material,
    vertex: Vec4,
    [color_texel, roughness_texel, scattering_texel]: [Vec4; 3],
    emission: Vec3,
) -> MaterialPoint {
    let roughness = material.roughness * roughness_texel.y;
    let alpha = roughness * roughness;
    // Floating-point images may contain negative values.
    let color = (material.color * vertex.truncate() * color_texel.truncate()).max(Vec3::ZERO);
    let (alpha, extinction) = match material.kind {
        MaterialKind::Matte | MaterialKind::Glossy => (alpha.clamp(LEAST_ALPHA, 1.0), Vec3::ZERO),
        MaterialKind::Reflective | MaterialKind::Transparent => {
            (smooth_below_least(alpha), Vec3::ZERO)
        }
        MaterialKind::Refractive | MaterialKind::Volumetric => {
            // White light that travels `trdepth` is attenuated to `color`.
            let remains = color.clamp(Vec3::splat(1e-4), Vec3::ONE);
            // Zero and not minus zero, of which one over it would be minus infinity, for white.
            (smooth_below_least(alpha), (Vec3::ZERO - remains.map(f32::ln)) / material.trdepth)
        }
    };
    MaterialPoint {
        kind: material.kind,
        emission,
        color,
        opacity: (material.opacity * color_texel.w * vertex.w).clamp(0.0, 1.0),
        alpha,
        ior: material.ior,
        extinction,
        albedo: (material.albedo * scattering_texel.truncate()).max(Vec3::ZERO),
        anisotropy: material.anisotropy,
    }
}

fn smooth_below_least(alpha: f32) -> f32 {
    if alpha < LEAST_ALPHA { 0.0 } else { alpha.min(1.0) }
}
