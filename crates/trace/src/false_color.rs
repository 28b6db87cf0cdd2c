//! Pictures of other quantities than light, in false colours.

use crate::context::{Arrived, Context};
use crate::{Sampler, View};
use glam::{Vec2, Vec3};
use rotund_geometry::{Aabb, Ray, UNIT_ROUNDOFF};
use rotund_scene::{ElementKind, MaterialPoint, Method, SceneHit};

impl Context<'_> {
    /// Returns the value of a view, of which paths are none, along a ray of unit direction.
    pub(crate) fn look(&self, view: View, ray: Ray, sampler: &Sampler) -> Arrived {
        let (found, rays) = self.first_surface(ray, sampler);
        if let Some((hit, material)) = &found {
            let radiance = self.color(view, hit, material, -ray.direction);
            return Arrived { radiance, covered: true, rays };
        }
        if view == View::Eyelight && !self.transparent {
            let radiance = self.scene.eval_environment(ray.direction);
            return Arrived { radiance, covered: !self.scene.environments.is_empty(), rays };
        }
        Arrived { radiance: Vec3::ZERO, covered: false, rays }
    }

    fn color(&self, view: View, hit: &SceneHit, material: &MaterialPoint, outgoing: Vec3) -> Vec3 {
        let scene = self.scene;
        let instance = &scene.instances[hit.instance as usize];
        let shape = &scene.shapes[instance.shape as usize];
        let direction = |d: Vec3| 0.5 * d + 0.5;
        match view {
            View::Path | View::Furnace => Vec3::ZERO,
            View::Eyelight => {
                let normal = scene.shading_normal(hit, outgoing);
                material.emission + material.color * normal.dot(outgoing).abs()
            }
            View::Position => {
                let Aabb { min, max } = self.bounds;
                ((hit.position - min) / (max - min).max(Vec3::splat(f32::MIN_POSITIVE)))
                    .clamp(Vec3::ZERO, Vec3::ONE)
            }
            View::GeometricNormal => direction(hit.normal),
            View::ShadingNormal => direction(scene.shading_normal(hit, outgoing)),
            View::Uv => hit.uv.clamp(Vec2::ZERO, Vec2::ONE).extend(0.0),
            View::Texcoord => {
                let place = scene.eval_texcoord(hit.instance, hit.element, hit.uv);
                (place - place.floor()).extend(0.0)
            }
            View::Element => index_color(hit.element),
            View::Instance => index_color(hit.instance),
            View::Material => index_color(instance.material),
            View::Method => match (shape.elements.kind(), shape.method) {
                (ElementKind::Triangles, _) => Vec3::splat(0.5),
                (_, Method::Enhanced) => Vec3::new(0.1, 0.3, 0.9),
                (_, Method::Vanilla) => Vec3::new(0.9, 0.4, 0.1),
            },
            View::Error => {
                let roundings = hit.error / (UNIT_ROUNDOFF * hit.position.abs().max_element());
                // The ratio is infinite at the origin.
                let share = ((1.0 + roundings).log2() / 10.0).clamp(0.0, 1.0);
                Vec3::new(share, 1.0 - (2.0 * share - 1.0).abs(), 1.0 - share)
            }
        }
    }
}

/// Returns a colour that is not dark and differs much from those of the neighbouring indices.
fn index_color(index: u32) -> Vec3 {
    let hash = (index.wrapping_add(1)).wrapping_mul(0x9e37_79b9);
    let hash = (hash ^ hash >> 15).wrapping_mul(0x85eb_ca6b);
    let hash = hash ^ hash >> 13;
    let channel = |shift: u32| 0.15 + 0.85 * (hash >> shift & 255) as f32 / 255.0;
    Vec3::new(channel(0), channel(8), channel(16))
}
