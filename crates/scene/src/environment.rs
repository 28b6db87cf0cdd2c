//! Light from infinitely far away.

use glam::{Affine3A, Vec3};

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
