//! Radiance of environments.

use crate::{Environment, Scene};
use glam::{Vec2, Vec3};

impl Environment {
    /// The radiance that comes from `direction`, which need not have unit length.
    #[must_use]
    pub fn radiance(&self, scene: &Scene, direction: Vec3) -> Vec3 {
        let image = self.emission_tex.is_some();
        self.radiance_at(scene, if image { self.uv(direction) } else { Vec2::ZERO })
    }

    /// The radiance that comes from where the image has `uv`; see [`Self::uv`].
    #[must_use]
    pub fn radiance_at(&self, scene: &Scene, uv: Vec2) -> Vec3 {
        let of_image = |index: u32| scene.textures[index as usize].color(uv).truncate();
        self.emission_tex.map_or(self.emission, |index| self.emission * of_image(index))
    }
}

impl Scene {
    /// The radiance that comes from `direction`, which need not have unit length: the sum over all
    /// environments.
    #[must_use]
    pub fn eval_environment(&self, direction: Vec3) -> Vec3 {
        self.environments.iter().map(|environment| environment.radiance(self, direction)).sum()
    }
}
