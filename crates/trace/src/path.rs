//! Light along one path from the camera.
//!
//! At each vertex one direction is drawn from the lights and one from the BSDF. Either could have
//! found what the other found, so both are weighted by the power heuristic. The direction from the
//! BSDF goes on; what it hits tells by itself with which density the lights would have found it.

use crate::light::{LightSample, Receiver};
use crate::medium::Media;
use crate::{Bsdf, Lights, Sampler, power_heuristic};
use glam::{Vec2, Vec3};
use rotund_geometry::{Ray, UNIT_ROUNDOFF, leave_surface};
use rotund_scene::{MaterialKind, Scene, SceneHit, Trees};

/// What all paths of a render share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct World<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) trees: &'a Trees,
    pub(crate) lights: &'a Lights,
    pub(crate) bounces: u32,
    /// No surface lets rays through unscattered.
    pub(crate) opaque: bool,
}

/// What a path brings home.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrived {
    pub(crate) radiance: Vec3,
    /// A surface or an environment was met.
    pub(crate) covered: bool,
    /// Rays traced.
    pub(crate) rays: u64,
}

/// Segments after which a path may end by Russian roulette.
const ROULETTE_AFTER: u32 = 4;
/// Sheets of partial opacity that one segment may pass. It ends paths that would otherwise not.
const SHEETS: u32 = 1024;
/// Dimension sets of a path: the camera takes the first, each vertex two.
const CAMERA_SET: u32 = 0;
const SETS_PER_VERTEX: u32 = 2;
/// Sets of decisions at sheets of partial opacity, which come in any number.
const SHEET_SETS: u32 = 1 << 16;

/// Where the last direction was drawn, unless from a discrete few.
struct Origin {
    receiver: Receiver,
    /// Density of the direction.
    pdf: f32,
}

impl World<'_> {
    /// The radiance that comes along a ray of unit direction.
    pub(crate) fn trace(&self, mut ray: Ray, sampler: &Sampler) -> Arrived {
        let scene = self.scene;
        let mut arrived = Arrived { radiance: Vec3::ZERO, covered: false, rays: 0 };
        let mut throughput = Vec3::ONE;
        let mut origin: Option<Origin> = None;
        let mut media = Media::default();
        let mut segment = 1;
        let mut sheets = 0;
        while segment <= self.bounces {
            arrived.rays += 1;
            let Some(hit) = self.trees.closest(scene, &ray) else {
                let weight = origin.as_ref().map_or(1.0, |origin| {
                    let other = self.lights.environment_pdf(&origin.receiver, ray.direction);
                    power_heuristic(origin.pdf, other)
                });
                arrived.radiance += weight * throughput * scene.eval_environment(ray.direction);
                arrived.covered |= !scene.environments.is_empty();
                break;
            };
            throughput *= media.transmittance(hit.t);
            let outgoing = -ray.direction;
            let material = scene.eval_material(hit.instance, hit.element, hit.uv);
            if material.opacity < 1.0 {
                let [chance, ..] = sampler.set(SHEET_SETS + sheets);
                sheets += 1;
                if sheets > SHEETS {
                    break;
                }
                if chance >= material.opacity {
                    ray.origin = leave_surface(hit.position, hit.error, hit.normal, ray.direction);
                    continue;
                }
            }
            arrived.covered = true;
            if material.emission != Vec3::ZERO {
                let weight = origin.as_ref().map_or(1.0, |origin| {
                    power_heuristic(origin.pdf, self.lights.hit_pdf(&origin.receiver, &hit))
                });
                arrived.radiance += weight * throughput * material.emission;
            }
            if segment == self.bounces {
                break;
            }

            let normal = shading_normal(scene, &hit, material.kind, outgoing);
            let bsdf = Bsdf::new(&material, normal, outgoing);
            let transmits = material.kind == MaterialKind::Refractive;
            let receiver =
                Receiver { position: hit.position, normal: (!transmits).then_some(normal) };
            let set = CAMERA_SET + 1 + SETS_PER_VERTEX * (segment - 1);
            if !bsdf.is_delta() {
                let [choice, x, y, _] = sampler.set(set);
                let drawn = self.lights.sample(scene, &receiver, choice, Vec2::new(x, y));
                if let Some(light) = drawn {
                    let value = bsdf.eval(light.incoming);
                    if value.value != Vec3::ZERO
                        && (!transmits || sides_agree(&hit, normal, outgoing, light.incoming))
                    {
                        let weight = power_heuristic(light.pdf, value.pdf) / light.pdf;
                        let through = self.visibility(&hit, &light, &media, &mut arrived.rays);
                        arrived.radiance +=
                            throughput * through * weight * value.value * light.radiance;
                    }
                }
            }

            let [choice, x, y, roulette] = sampler.set(set + 1);
            let Some(scattered) = bsdf.sample(choice, Vec2::new(x, y)) else { break };
            let incoming = scattered.incoming;
            if transmits && !sides_agree(&hit, normal, outgoing, incoming) {
                break;
            }
            throughput *= scattered.weight;
            if throughput == Vec3::ZERO {
                break;
            }
            if transmits && hit.normal.dot(outgoing) * hit.normal.dot(incoming) < 0.0 {
                if hit.normal.dot(outgoing) > 0.0 {
                    media.enter(hit.instance, material.density);
                } else {
                    media.leave(hit.instance);
                }
            }
            if segment >= ROULETTE_AFTER {
                let survival = throughput.max_element().min(0.99);
                if roulette >= survival {
                    break;
                }
                throughput /= survival;
            }
            origin = scattered.pdf.map(|pdf| Origin { receiver, pdf });
            ray = Ray::new(leave_surface(hit.position, hit.error, hit.normal, incoming), incoming);
            segment += 1;
        }
        arrived
    }

    /// The share of the light that is not blocked on its way to a hit.
    fn visibility(
        &self,
        hit: &SceneHit,
        light: &LightSample,
        media: &Media,
        rays: &mut u64,
    ) -> Vec3 {
        let incoming = light.incoming;
        // Both ends leave their surfaces. How far along the ray an end is off its surface can be
        // less than the rounding of `t`, which is some units in the last place.
        let end = light
            .source
            .map(|source| leave_surface(source.position, source.error, source.normal, -incoming));
        let segment = |origin: Vec3| match end {
            None => Ray::new(origin, incoming),
            Some(end) => {
                Ray { t_max: 1.0 - 32.0 * UNIT_ROUNDOFF, ..Ray::new(origin, end - origin) }
            }
        };
        let mut ray = segment(leave_surface(hit.position, hit.error, hit.normal, incoming));
        let mut share = match end {
            Some(end) => media.transmittance(end.distance(ray.origin)),
            None => Vec3::ONE,
        };
        *rays += 1;
        if self.opaque {
            return if self.trees.any(self.scene, &ray) { Vec3::ZERO } else { share };
        }
        for _ in 0..SHEETS {
            let Some(sheet) = self.trees.closest(self.scene, &ray) else { return share };
            let material = self.scene.eval_material(sheet.instance, sheet.element, sheet.uv);
            if material.opacity >= 1.0 {
                break;
            }
            share *= 1.0 - material.opacity;
            ray = segment(leave_surface(sheet.position, sheet.error, sheet.normal, incoming));
            *rays += 1;
        }
        Vec3::ZERO
    }
}

/// The shading normal. At the silhouette of a mesh an interpolated normal can turn away from the
/// viewer; for the wall of a solid that would take a path that enters for one that leaves, so there
/// the geometric normal stands in.
fn shading_normal(scene: &Scene, hit: &SceneHit, kind: MaterialKind, outgoing: Vec3) -> Vec3 {
    let normal = scene.eval_shading_normal(hit, outgoing);
    let turned = normal.dot(outgoing) * hit.normal.dot(outgoing) < 0.0;
    if kind == MaterialKind::Refractive && turned { hit.normal } else { normal }
}

/// True if light goes to the side of the geometric surface on which the shading normal has it. Where
/// the wall of a solid reflects by one and transmits by the other, a path would lose count of what it is in.
///
/// Opaque surfaces are not asked: there the shading normal alone decides, as in most renderers, and a
/// direction that is below the geometric surface meets the inside of a closed mesh, which is dark.
fn sides_agree(hit: &SceneHit, normal: Vec3, outgoing: Vec3, incoming: Vec3) -> bool {
    let shading = normal.dot(outgoing) * normal.dot(incoming) > 0.0;
    let geometric = hit.normal.dot(outgoing) * hit.normal.dot(incoming) > 0.0;
    shading == geometric
}
