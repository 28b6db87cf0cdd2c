//! Plain paths: one direction at each vertex, and light only where they meet it.

use super::random_shape::Random;
use super::{Blocks, OPTIONS, SIZE, to_blocks};
use crate::context::Context;
use crate::medium::{Media, Medium};
use crate::vertex::{Vertex, sides_agree};
use crate::{Sampler, Sequence, World, camera_ray, phase};
use glam::Vec3;
use rotund_geometry::Ray;
use rotund_scene::MaterialKind;
use std::cell::RefCell;

/// Returns the light that arrives along a ray by the plainest path there is: one direction at each
/// vertex, from its BSDF or phase function, and light only where the path meets it.
fn plain(context: &Context<'_>, mut ray: Ray, random: &mut Random) -> Vec3 {
    let Context { scene, trees, bounces, .. } = *context;
    let (mut light, mut throughput, mut media) = (Vec3::ZERO, Vec3::ONE, Media::default());
    let (mut left, mut segment) = (None, 1);
    loop {
        let medium = media.innermost().copied().filter(Medium::scatters);
        let distance =
            medium.map_or(f32::INFINITY, |medium| medium.sample(random.unit(), random.unit()));
        // A ray that meets nothing is not inside of a medium.
        let Some(hit) = trees.closest_after(scene, &ray, left) else {
            return light + throughput * scene.eval_environment(ray.direction);
        };
        if let Some(medium) = medium.filter(|_| distance < hit.t) {
            if segment == bounces {
                return light;
            }
            throughput *= medium.scattered(distance);
            let direction = phase::sample(medium.anisotropy, -ray.direction, random.pair());
            (ray, left) = (Ray::new(ray.at(distance), direction), None);
            segment += 1;
            continue;
        }
        throughput *= match medium {
            Some(medium) => medium.passed(hit.t),
            None => media.transmittance(hit.t),
        };
        let material = scene.eval_material(hit.instance, hit.element, hit.uv);
        if random.unit() >= material.opacity {
            (ray, left) = (hit.spawn(ray.direction), hit.left_by(ray.direction));
            continue;
        }
        light += throughput * material.emission;
        if segment == bounces {
            return light;
        }
        segment += 1;
        if material.kind == MaterialKind::Volumetric {
            media.cross(&hit, ray.direction, Medium::new(&material));
            (ray, left) = (hit.spawn(ray.direction), hit.left_by(ray.direction));
            continue;
        }
        let outgoing = -ray.direction;
        let (bsdf, normal) = Vertex { scene, hit: &hit, material: &material }.bsdf(outgoing);
        let Some(sample) = bsdf.sample(random.unit(), random.pair()) else { return light };
        let incoming = sample.incoming;
        if material.kind == MaterialKind::Refractive {
            if !sides_agree(&hit, normal, outgoing, incoming) {
                return light;
            }
            if hit.normal.dot(outgoing) * hit.normal.dot(incoming) < 0.0 {
                media.cross(&hit, incoming, Medium::new(&material));
            }
        }
        throughput *= sample.weight;
        if throughput == Vec3::ZERO {
            return light;
        }
        (ray, left) = (hit.spawn(incoming), hit.left_by(incoming));
    }
}

/// Renders a picture by plain paths, with numbers that are independent of each other.
pub(crate) fn plain_picture(world: &World<'_>, samples: u32, seed: u64) -> Blocks {
    let (context, camera) = (world.context(&OPTIONS), &world.scene().cameras[0]);
    let random = RefCell::new(Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let sample = |x: u32, y: u32, sample: u32| {
        let sampler = Sampler::new(Sequence::Independent, seed, x, y, sample);
        plain(&context, camera_ray(camera, SIZE, [x, y], &sampler), &mut random.borrow_mut())
    };
    to_blocks(&|x, y| {
        let sum: Vec3 = (0..samples).map(|index| sample(x, y, index)).sum();
        (sum / samples as f32).to_array()
    })
}
