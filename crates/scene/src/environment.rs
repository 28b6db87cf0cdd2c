//! Light from infinitely far away.

use crate::Scene;
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A constant or a latitude-longitude image times a colour.
#[derive(Clone, Debug)]
pub struct Environment {
    /// For messages.
    pub name: String,
    /// A rigid frame; `y` points to the first row of the image.
    pub world_from_environment: Affine3A,
    /// Radiance.
    pub emission: Vec3,
    /// Index into [`crate::Scene::textures`]; scales `emission`.
    pub emission_tex: Option<u32>,
}

impl Environment {
    /// Where the image holds what comes from `direction`, which need not have unit length:
    /// `u = atan2(z, x) / 2 pi` in `0.0..1.0`, `v = acos(y) / pi`, in the environment's frame.
    #[must_use]
    pub fn uv(&self, direction: Vec3) -> Vec2 {
        // The frame is rigid: its inverse is its transpose.
        let axes = self.world_from_environment.matrix3;
        let local = Vec3::new(
            Vec3::from(axes.x_axis).dot(direction),
            Vec3::from(axes.y_axis).dot(direction),
            Vec3::from(axes.z_axis).dot(direction),
        )
        .normalize_or_zero();
        let turn = local.z.atan2(local.x) / TAU;
        let u = if turn < 0.0 { turn + 1.0 } else { turn };
        Vec2::new(u, local.y.clamp(-1.0, 1.0).acos() / PI)
    }

    /// The direction, of unit length, that [`Self::uv`] maps to `uv`.
    #[must_use]
    pub fn direction(&self, uv: Vec2) -> Vec3 {
        let (sin_u, cos_u) = (TAU * uv.x).sin_cos();
        let (sin_v, cos_v) = (PI * uv.y).sin_cos();
        let local = Vec3::new(cos_u * sin_v, cos_v, sin_u * sin_v);
        self.world_from_environment.transform_vector3(local)
    }

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
