//! Texture coordinates and vertex colours.

use super::weights::Weights;
use crate::Scene;
use glam::{Vec2, Vec4};

impl Scene {
    /// Texture coordinates: interpolated between vertices, or the parameters of the element if the
    /// vertices have none, so that a sphere is a globe and a tube has stripes.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn eval_texcoord(&self, instance: u32, element: u32, uv: Vec2) -> Vec2 {
        let (_, shape) = self.placed(instance);
        if shape.texcoords.is_empty() {
            return uv;
        }
        Weights::new(shape, element, uv).of(&shape.texcoords).unwrap_or(uv)
    }

    /// Vertex colour, linear, and opacity; ones if the vertices have none.
    ///
    /// # Panics
    ///
    /// If an index is out of range.
    #[must_use]
    pub fn eval_color(&self, instance: u32, element: u32, uv: Vec2) -> Vec4 {
        let (_, shape) = self.placed(instance);
        if shape.colors.is_empty() {
            return Vec4::ONE;
        }
        Weights::new(shape, element, uv).of(&shape.colors).unwrap_or(Vec4::ONE)
    }
}
