//! Paths with all their means to find light show the same light as plain ones.

use crate::World;
use crate::light_path::RATE;
use crate::same_light::random_scene::{add_sky, floor, scene};
use crate::same_light::random_shape::solid_box;
use crate::same_light::{difference, plain_picture, scene_numbers, usual_picture};
use glam::Vec3;
use rayon::prelude::*;
use rotund_scene::{Elements, Material, MaterialKind, Method, Overlap, Scene, Shape};

/// Samples of a pixel of the usual pictures and of the plain ones.
const SAMPLES: [u32; 2] = [16, 64];

/// Returns a text if the two kinds of paths do not show the same light.
fn differs(why: &str, scene: &Scene) -> Option<String> {
    let world = World::new(scene).expect("a valid scene");
    let usual = |seed| usual_picture(&world, SAMPLES[0], seed, Some(RATE));
    let plain = |seed| plain_picture(&world, SAMPLES[1], seed);
    difference([&usual, &plain]).map(|what| format!("{why}, not as by plain paths: {what}"))
}

fn same_light(cases: Vec<(String, Scene)>) {
    let all = cases.par_iter().filter_map(|(why, scene)| differs(why, scene));
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
    let named = |number: u64| (format!("scene {number}"), scene(number));
    same_light(scene_numbers(0..24).map(named).collect());
}
