//! Paths with all their means to find light show the same light as plain ones.

mod random_scene;

use crate::context::Context;
use crate::film::{FilmSample, Limits, one_by_one};
use crate::medium::{Media, Medium};
use crate::vertex::{Vertex, sides_agree};
use crate::{Film, Options, Sampler, Sequence, World, camera_ray, phase};
use glam::Vec3;
use random_scene::{Random, add_sky, floor, scene, solid_box};
use rayon::prelude::*;
use rotund_geometry::Ray;
use rotund_scene::{Elements, Material, MaterialKind, Method, Overlap, Scene, Shape};
use std::ops::ControlFlow;

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

const SIZE: [u32; 2] = [12, 8];
/// Number of pictures of each kind.
const RUNS: u64 = 16;
/// Samples of a pixel of the usual pictures and of the plain ones.
const SAMPLES: [u32; 2] = [32, 128];

/// Mean and standard error of each channel over the means of pictures.
fn estimate(pictures: &[Vec<[f32; 3]>]) -> [(f64, f64); 3] {
    std::array::from_fn(|channel| {
        let mean_of = |picture: &Vec<[f32; 3]>| {
            let sum: f64 = picture.iter().map(|pixel| f64::from(pixel[channel])).sum();
            sum / picture.len() as f64
        };
        let means: Vec<f64> = pictures.iter().map(mean_of).collect();
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let squares: f64 = means.iter().map(|x| (x - mean).powi(2)).sum();
        (mean, (squares / (count * (count - 1.0))).sqrt())
    })
}

fn usual_picture(world: &World<'_>, seed: u64) -> Vec<[f32; 3]> {
    let [width, height] = SIZE;
    let options = Options { width, height, samples: SAMPLES[0], seed, ..Options::default() };
    let camera = &world.scene().cameras[0];
    let context = world.context(&options).with_light_paths(camera, &options);
    let sample = one_by_one(|[x, y, sample], splats| {
        let sampler = Sampler::new(options.sequence, seed, x, y, sample);
        let ray = camera_ray(camera, SIZE, [x, y], &sampler);
        let found = context.trace(ray, &sampler, &context.camera_hit(&ray));
        context.trace_light(&options, [x, y, sample], &mut |splat| splats.push(splat));
        FilmSample { radiance: found.radiance, covered: found.covered, rays: 0 }
    });
    let mut film = Film::for_options(&options).expect("a film");
    film.take_samples(SAMPLES[0], Limits::NONE, &sample, &mut |_| ControlFlow::Continue(()));
    assert_eq!(film.rejected(), 0);
    film.image().pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

fn plain_picture(world: &World<'_>, seed: u64) -> Vec<[f32; 3]> {
    let options = Options::default();
    let (context, camera) = (world.context(&options), &world.scene().cameras[0]);
    let random = &mut Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let mut sample = |x: u32, y: u32, sample: u32| {
        let sampler = Sampler::new(Sequence::Independent, seed, x, y, sample);
        plain(&context, camera_ray(camera, SIZE, [x, y], &sampler), random)
    };
    let mut pixel = |index: u32| {
        let (x, y) = (index % SIZE[0], index / SIZE[0]);
        let sum: Vec3 = (0..SAMPLES[1]).map(|index| sample(x, y, index)).sum();
        (sum / SAMPLES[1] as f32).to_array()
    };
    (0..SIZE[0] * SIZE[1]).map(&mut pixel).collect()
}

/// Returns a text if the means of a picture differ by more than their errors.
fn difference(why: &str, scene: &Scene) -> Option<String> {
    let world = World::new(scene).expect("a valid scene");
    let pictures = |of: fn(&World<'_>, u64) -> Vec<[f32; 3]>, first: u64| {
        let seeds = first..first + RUNS;
        estimate(&seeds.map(|seed| of(&world, seed)).collect::<Vec<_>>())
    };
    let (usual, plain) = (pictures(usual_picture, 0), pictures(plain_picture, RUNS));
    let differs = |&((a, error_a), (b, error_b)): &((f64, f64), (f64, f64))| {
        (a - b).abs() > 5.0 * error_a.hypot(error_b) + 1e-6
    };
    let channels: Vec<_> = usual.into_iter().zip(plain).collect();
    let any = channels.iter().any(differs);
    any.then(|| format!("{why}: usual and plain (mean, standard error): {channels:?}"))
}

fn same_light(cases: Vec<(String, Scene)>) {
    let all = cases.par_iter().filter_map(|(why, scene)| difference(why, scene));
    let found: Vec<String> = all.collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A scene and what it tests.
fn case(why: &str, edit: impl Fn(&mut Scene)) -> (String, Scene) {
    let mut scene = floor(Vec3::new(0.3, 2.0, 2.8));
    edit(&mut scene);
    (why.into(), scene)
}

fn lamp() -> Material {
    Material { emission: Vec3::new(4.0, 3.0, 2.0), ..Material::default() }
}

/// Glass of a colour.
fn glass() -> Material {
    let kind = MaterialKind::Refractive;
    Material { kind, color: Vec3::new(0.9, 0.5, 0.4), trdepth: 0.3, ..Material::default() }
}

fn milk() -> Material {
    Material { albedo: Vec3::new(0.9, 0.8, 0.95), anisotropy: 0.3, ..glass() }
}

fn ball(center: [f32; 3], radius: f32) -> Shape {
    Shape::points([Vec3::from_array(center)], radius)
}

/// A tube with a bend.
fn tube() -> Shape {
    let ends = [[-0.7, 0.8, -0.3], [0.1, 0.5, 0.1], [0.7, 0.9, 0.0]].map(Vec3::from_array);
    Shape::lines(ends, [0.15, 0.3, 0.2], [[0, 1], [1, 2]])
}

#[test]
fn all_paths_show_the_light_of_plain_ones() {
    same_light(vec![
        case("a lamp whose two lines share a ball", |scene| {
            scene.add(tube(), lamp());
        }),
        case("a lamp that the scene has twice, from either end", |scene| {
            let (mut once, mut twice) = (tube(), tube());
            once.elements = Elements::Lines(vec![[0, 1]]);
            twice.elements = Elements::Lines(vec![[1, 0]]);
            scene.add(once, lamp());
            scene.add(twice, lamp());
            let again = [Vec3::new(0.5, 0.4, 0.6); 2];
            scene.add(Shape::points(again, 0.2), lamp());
            // Both sides of a face.
            let face = [[-0.9, 1.0, 0.3], [-0.3, 1.0, 0.3], [-0.3, 1.5, 0.2], [-0.9, 1.4, 0.3]];
            let sides = [[0, 1, 2, 3], [2, 1, 0, 3]];
            scene.add(Shape::quads(face.map(Vec3::from_array), sides), lamp());
        }),
        case("a sheet that is half there inside of a solid that scatters", |scene| {
            scene.add(ball([0.0, 0.7, 0.0], 0.6), milk());
            let sheet = solid_box(Vec3::new(0.0, 0.7, 0.0), Vec3::new(0.3, 0.1, 0.3));
            let color = Vec3::splat(0.3);
            scene.add(sheet, Material { color, opacity: 0.5, ..Material::default() });
            add_sky(scene, true, 0.0);
        }),
        case("a cloud whose border is half there", |scene| {
            let kind = MaterialKind::Volumetric;
            scene.add(ball([0.0, 0.7, 0.0], 0.6), Material { kind, opacity: 0.5, ..milk() });
            scene.add(ball([0.5, 1.8, -0.5], 0.4), lamp());
        }),
        case("a vanilla mirror that reaches into a cloud", |scene| {
            let kind = MaterialKind::Volumetric;
            scene.add(ball([0.0, 0.7, 0.0], 0.6), Material { kind, ..milk() });
            let mirror = ball([0.8, 0.8, 0.3], 0.5);
            let shape = Shape { method: Method::Vanilla, ..mirror };
            let (kind, color) = (MaterialKind::Reflective, Vec3::splat(0.9));
            scene.add(shape, Material { kind, color, ..Material::default() });
            add_sky(scene, false, 0.0);
        }),
        case("lines that scatter, each a solid of its own", |scene| {
            scene.add(Shape { overlap: Overlap::Separate, ..tube() }, milk());
            add_sky(scene, false, 0.0);
        }),
    ]);
}

#[test]
fn paths_in_random_scenes_show_the_light_of_plain_ones() {
    same_light((0..24).map(|number| (format!("scene {number}"), scene(number))).collect());
}
