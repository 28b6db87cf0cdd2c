//! The density of light paths that would find a path from the camera.

use super::Path;
use crate::medium::{Media, Medium, WayBack};
use crate::vertex::Vertex;
use crate::{LightSample, Lights};
use glam::Vec3;
use rotund_scene::{MaterialKind, SceneHit};

/// What light paths that would find a path from the camera need to be weighted.
#[derive(Clone, Copy)]
pub(super) struct Reverse {
    /// Density of light paths over that of this one, without the first segment from the light.
    ratio: f32,
    /// The last vertex, if it is on a caster.
    caster: Option<SceneHit>,
}

/// Crosses the surface of a solid, and returns whether light paths that cross it in the other
/// direction are inside of the same media.
pub(super) fn crosses_both_ways(
    media: &mut Media,
    hit: &SceneHit,
    direction: Vec3,
    medium: Medium,
) -> bool {
    match media.cross_known(hit, direction, medium) {
        WayBack::SameMedia => true,
        // They enter the solid here, and are inside of it up to the camera.
        WayBack::Unknown => medium.is_clear() && media.is_clear(),
        WayBack::OtherMedia => false,
    }
}

impl Path<'_> {
    /// Returns what becomes of [`Self::reverse`] if the path goes on from a vertex to `to_light`,
    /// which the BSDF samples with density `pdf`.
    pub(super) fn reversed(
        &self,
        vertex: &Vertex<'_>,
        to_light: Vec3,
        pdf: Option<f32>,
    ) -> Option<Reverse> {
        let sensor = self.context.sensor.as_ref()?;
        let to_camera = -self.ray.direction;
        if self.straight {
            if self.segment > 1 || !vertex.is_fixed() {
                return None;
            }
            let density = sensor.density(self.lens, vertex.hit.position);
            let [shown, lit] = [to_camera, to_light].map(|d| vertex.slant(d));
            let ratio = self.context.rate * lit / (density * shown * pdf?);
            return ratio.is_finite().then_some(Reverse { ratio, caster: None });
        }
        let Reverse { ratio, .. } = self.reverse?;
        self.context.lights.casters().caster(vertex.hit)?;
        let ratio = ratio * vertex.reversal(to_camera, to_light)?;
        Some(Reverse { ratio, caster: Some(*vertex.hit) })
    }

    /// Returns the density of light paths from a light that the path has hit, over that of this
    /// one.
    pub(super) fn found_from(&self, source: &SceneHit) -> f32 {
        self.found(self.reverse.as_ref(), &self.media, |lights, caster| {
            lights.casters().density(lights, source, caster)
        })
    }

    /// Returns the density of light paths from a direction of the environments over that of this
    /// one.
    pub(super) fn found_from_sky(&self, sky: Vec3) -> f32 {
        self.found(self.reverse.as_ref(), &self.media, |lights, caster| {
            lights.casters().density_of_sky(lights, sky, caster)
        })
    }

    /// Returns the density of light paths from a sampled light over that of this path if the BSDF
    /// found the light; `None` if light paths find none of this path.
    pub(super) fn found_with(
        &self,
        vertex: &Vertex<'_>,
        light: &LightSample,
        pdf: f32,
    ) -> Option<f32> {
        self.reverse?;
        let incoming = light.incoming;
        let reverse = self.reversed(vertex, incoming, Some(pdf))?;
        let mut media = self.media;
        let crosses = vertex.hit.normal.dot(self.ray.direction) * vertex.hit.normal.dot(incoming);
        if vertex.material.kind == MaterialKind::Refractive && crosses > 0.0 {
            let medium = Medium::new(vertex.material);
            if !crosses_both_ways(&mut media, vertex.hit, incoming, medium) {
                return Some(0.0);
            }
        }
        Some(self.found(Some(&reverse), &media, |lights, caster| match lights.hit(light) {
            Some(source) => lights.casters().density(lights, &source, caster),
            None => lights.casters().density_of_sky(lights, incoming, caster),
        }))
    }

    fn found(
        &self,
        reverse: Option<&Reverse>,
        media: &Media,
        density: impl Fn(&Lights, &SceneHit) -> f32,
    ) -> f32 {
        match reverse {
            // Media around a light are unknown to paths that start at it.
            Some(Reverse { ratio, caster: Some(caster) }) if media.is_outside() => {
                ratio * density(self.context.lights, caster)
            }
            _ => 0.0,
        }
    }
}
