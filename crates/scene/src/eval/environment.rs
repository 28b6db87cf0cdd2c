//! Radiance of environments.

use crate::{Environment, Scene};
use glam::{Vec2, Vec3};

impl Environment {
    /// Returns the radiance from `direction`, which need not have unit length.
    ///
    /// # Panics
    ///
    /// If the scene does not have the texture.
    #[must_use]
    pub fn radiance(&self, scene: &Scene, direction: Vec3) -> Vec3 {
        let image = self.emission_tex.is_some();
        self.radiance_at(scene, if image { self.uv(direction) } else { Vec2::ZERO })
    }

    /// Returns the radiance at the image coordinates `uv`; see [`Self::uv`].
    ///
    /// # Panics
    ///
    /// If the scene does not have the texture.
    #[must_use]
    pub fn radiance_at(&self, scene: &Scene, uv: Vec2) -> Vec3 {
        let texel = |index: u32| scene.textures[index as usize].color(uv).truncate();
        self.emission_tex.map_or(self.emission, |index| self.emission * texel(index))
    }
}

impl Scene {
    /// Returns the radiance from `direction`, which need not have unit length, summed over all
    /// environments.
    ///
    /// # Panics
    ///
    /// If an environment names a texture that the scene does not have.
    #[must_use]
    pub fn eval_environment(&self, direction: Vec3) -> Vec3 {
        self.environments.iter().map(|environment| environment.radiance(self, direction)).sum()
    }
}
