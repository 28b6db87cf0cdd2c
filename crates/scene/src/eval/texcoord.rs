//! Texture coordinates and vertex colours.

use super::weights::Weights;
use crate::Scene;
use glam::{Vec2, Vec4};

impl Scene {
    /// Returns whether colours or textures of an instance vary with the parameters of its elements.
    #[inline]
    pub(crate) fn is_textured(&self, instance: u32) -> bool {
        let (_, shape) = self.placed(instance);
        let material = &self.materials[self.instances[instance as usize].material as usize];
        let textures = [
            material.color_tex,
            material.emission_tex,
            material.roughness_tex,
            material.scattering_tex,
            material.normal_tex,
        ];
        !shape.colors.is_empty() || textures.iter().any(Option::is_some)
    }

    /// Returns texture coordinates: interpolated between vertices, or the parameters of the element
    /// if the shape has none, which map a globe onto a sphere and stripes onto a tube.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_texcoord(&self, instance: u32, element: u32, uv: Vec2) -> Vec2 {
        let (_, shape) = self.placed(instance);
        if shape.texcoords.is_empty() {
            return uv;
        }
        Weights::new(shape, element, uv).of(&shape.texcoords).unwrap_or(uv)
    }

    /// Returns the interpolated vertex colour, linear, and opacity; ones if the shape has none.
    ///
    /// # Panics
    ///
    /// If an index is out of range, among the arguments or in a scene that [`Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn eval_color(&self, instance: u32, element: u32, uv: Vec2) -> Vec4 {
        let (_, shape) = self.placed(instance);
        if shape.colors.is_empty() {
            return Vec4::ONE;
        }
        Weights::new(shape, element, uv).of(&shape.colors).unwrap_or(Vec4::ONE)
    }
}
