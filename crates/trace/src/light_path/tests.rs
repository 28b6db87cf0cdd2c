//! Pictures with light paths and without them show the same light.

use super::RATE;
use crate::World;
use crate::same_light::random_scene::scene_of_casters;
use crate::same_light::{
    BLOCKS, Blocks, difference, has_light_paths, mean, scene_numbers, usual_picture,
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use rayon::prelude::*;
use rotund_scene::{
    Camera, Elements, Environment, Material, MaterialKind, Overlap, Pixels, Scene, Shape, Texture,
};
use std::array;
use std::ops::Range;

fn material(kind: MaterialKind, color: [f32; 3], roughness: f32) -> Material {
    Material { kind, color: color.into(), roughness, ..Material::default() }
}

fn shine(radiance: f32) -> Material {
    Material { emission: Vec3::splat(radiance), ..Material::default() }
}

fn quad(corners: [[f32; 3]; 4]) -> Shape {
    Shape::quads(corners.map(Vec3::from_array), [[0, 1, 2, 3]])
}

/// A matte floor before a camera that looks down on it.
fn floor() -> Scene {
    let eye = Vec3::new(0.3, 2.5, 2.5);
    let camera = Camera { lens: 0.036, ..Camera::look_at(eye, Vec3::ZERO, Vec3::Y) };
    let mut scene = Scene { cameras: vec![camera], ..Scene::default() };
    let corners = [[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]];
    scene.add(quad(corners), material(MaterialKind::Matte, [0.8, 0.7, 0.6], 0.0));
    scene
}

fn ball(center: [f32; 3], radius: f32) -> Shape {
    Shape::points([Vec3::from_array(center)], radius)
}

fn lamp(scene: &mut Scene, radius: f32, radiance: f32) {
    scene.add(ball([0.6, 2.2, -0.5], radius), shine(radiance));
}

/// A sky so dim that the light of lamps shows, where a picture would be black without.
fn dim(scene: &mut Scene) {
    let emission = Vec3::splat(0.02);
    scene.environments.push(Environment { emission, ..Environment::default() });
}

/// A sky with a sun.
fn sun(scene: &mut Scene) {
    let texel = |i: usize| {
        if i == 16 * 4 + 5 { [40.0, 36.0, 30.0, 1.0] } else { [0.2, 0.2, 0.3, 1.0] }
    };
    scene.textures.push(Texture {
        name: String::new(),
        width: 16,
        height: 8,
        pixels: Pixels::Floats((0..128).map(texel).collect()),
    });
    scene.environments.push(Environment {
        name: String::new(),
        world_from_environment: Affine3A::from_quat(Quat::from_rotation_y(0.4)),
        emission: Vec3::ONE,
        emission_tex: Some(0),
    });
}

/// A mirror on the far side of the floor, turned to the camera.
fn mirror(scene: &mut Scene) {
    let corners = [[-2.0, 0.0, -0.8], [2.0, 0.0, -0.8], [2.0, 2.0, -1.3], [-2.0, 2.0, -1.3]];
    scene.add(quad(corners), material(MaterialKind::Reflective, [0.9; 3], 0.0));
}

/// Glass that is neither thick enough to be black nor thin enough to be clear.
fn tinted(roughness: f32) -> Material {
    Material { trdepth: 0.5, ..material(MaterialKind::Refractive, [0.9, 0.6, 0.4], roughness) }
}

/// A ring of metal that stands on the floor.
fn ring(material: Material, scene: &mut Scene) {
    const PARTS: u32 = 24;
    let at = |i: u32, y: f32| {
        let around = Vec2::from_angle(std::f32::consts::TAU * i as f32 / PARTS as f32);
        Vec3::new(0.6 * around.x, y, 0.6 * around.y)
    };
    let positions: Vec<Vec3> = (0..PARTS).flat_map(|i| [at(i, 0.0), at(i, 0.4)]).collect();
    let face = |i: u32| {
        let next = (i + 1) % PARTS;
        [2 * i, 2 * next, 2 * next + 1, 2 * i + 1]
    };
    let normals = positions.iter().map(|p| p.with_y(0.0).normalize()).collect();
    let faces: Vec<_> = (0..PARTS).map(face).collect();
    scene.add(Shape { normals, ..Shape::quads(positions, faces) }, material);
}

/// A scene and what it tests.
type Case = (&'static str, Scene);

fn cases() -> Vec<Case> {
    let glass = MaterialKind::Refractive;
    let metal = || material(MaterialKind::Reflective, [0.9, 0.8, 0.7], 0.0);
    let with = |edit: &dyn Fn(&mut Scene)| {
        let mut scene = floor();
        edit(&mut scene);
        scene
    };
    let glass_ball = |scene: &mut Scene| {
        scene.add(ball([0.0, 0.6, 0.0], 0.4), material(glass, [1.0; 3], 0.0));
    };
    vec![
        (
            "a ball of glass under a lamp",
            with(&|scene| {
                glass_ball(scene);
                lamp(scene, 0.3, 20.0);
            }),
        ),
        (
            "a ring of metal, its normals bent",
            with(&|scene| {
                ring(metal(), scene);
                lamp(scene, 0.3, 20.0);
            }),
        ),
        (
            "a ring of rough metal",
            with(&|scene| {
                ring(Material { roughness: 0.3, ..metal() }, scene);
                lamp(scene, 0.3, 20.0);
            }),
        ),
        (
            "tinted balls, one frosted, through a lens",
            with(&|scene| {
                scene.cameras[0].aperture = 0.3;
                scene.add(ball([-0.5, 0.5, 0.0], 0.4), tinted(0.0));
                scene.add(ball([0.5, 0.5, 0.2], 0.4), tinted(0.3));
                lamp(scene, 0.3, 20.0);
            }),
        ),
        (
            "tubes of one body on a glossy floor, seen by parallel rays",
            with(&|scene| {
                scene.cameras[0] = scene.cameras[0].clone().orthographic(3.0);
                scene.materials[0] = material(MaterialKind::Glossy, [0.5; 3], 0.4);
                let ends = [[-0.6, 0.4, -0.3], [0.1, 0.3, 0.1], [0.7, 0.5, 0.0]];
                let shape = Shape {
                    elements: Elements::Lines(vec![[0, 1], [1, 2]]),
                    positions: ends.map(Vec3::from_array).to_vec(),
                    radii: vec![0.2, 0.3, 0.15],
                    overlap: Overlap::Union,
                    ..Shape::default()
                };
                scene.add(shape, tinted(0.0));
                let lamp = [[-0.4, 2.0, -0.8], [0.4, 2.1, -0.8], [0.4, 2.0, 0.0], [-0.4, 2.0, 0.1]];
                scene.add(quad(lamp), shine(20.0));
            }),
        ),
        (
            "a sheet that is half there, a pane and a mirror below a sun",
            with(&|scene| {
                let sheet = |x: f32, y: f32| {
                    quad([[x, y, 0.6], [x + 0.9, y, 0.6], [x + 0.9, y, -0.6], [x, y, -0.6]])
                };
                let half = Material { opacity: 0.5, ..metal() };
                scene.add(sheet(-0.4, 0.9), half);
                scene.add(
                    sheet(-0.6, 0.5),
                    material(MaterialKind::Transparent, [0.5, 0.9, 0.7], 0.0),
                );
                scene.add(
                    quad([[1.0, 0.0, 0.8], [1.2, 1.0, 0.8], [1.2, 1.0, -0.8], [1.0, 0.0, -0.8]]),
                    metal(),
                );
                sun(scene);
            }),
        ),
        (
            "balls of glass before a mirror, behind a sheet that is half there",
            with(&|scene| {
                mirror(scene);
                scene.add(ball([-0.5, 0.5, 0.0], 0.4), material(glass, [1.0; 3], 0.0));
                scene.add(ball([0.5, 0.5, 0.0], 0.3), tinted(0.0));
                let sheet = [[0.2, 1.2, 0.5], [1.0, 1.2, 0.5], [1.0, 1.2, -0.5], [0.2, 1.2, -0.5]];
                scene.add(quad(sheet), Material { opacity: 0.5, ..metal() });
                lamp(scene, 0.3, 20.0);
            }),
        ),
        (
            "balls of glass below a sun, seen through another and in a mirror",
            with(&|scene| {
                mirror(scene);
                scene.add(ball([0.1, 1.3, 1.2], 0.35), material(glass, [1.0; 3], 0.0));
                scene.add(ball([-0.2, 0.5, 0.0], 0.4), material(glass, [1.0; 3], 0.0));
                sun(scene);
            }),
        ),
        (
            "a ball and a tube of glass that frames flatten, below a sun",
            with(&|scene| {
                scene.add(ball([-0.5, 0.8, 0.0], 0.4), material(glass, [1.0; 3], 0.0));
                let ends = [Vec3::new(0.1, 0.7, 0.3), Vec3::new(0.8, 0.5, -0.3)];
                let tube = Shape::lines(ends, vec![0.2, 0.3], [[0, 1]]);
                scene.add(tube, material(glass, [0.9; 3], 0.3));
                let flat = Affine3A::from_scale(Vec3::new(1.0, 0.6, 0.9));
                scene.instances[1..].iter_mut().for_each(|i| i.world_from_object = flat);
                sun(scene);
                lamp(scene, 0.3, 20.0);
            }),
        ),
        (
            "balls of dark glass, the walls of which are half there",
            with(&|scene| {
                let dark = Material { trdepth: 0.1, opacity: 0.5, ..tinted(0.0) };
                scene.add(ball([-0.4, 0.6, 0.0], 0.5), dark.clone());
                scene.add(ball([0.5, 0.6, 0.3], 0.5), dark);
                lamp(scene, 0.4, 20.0);
            }),
        ),
        (
            "a ball of dark glass that reaches into one of clear glass below",
            with(&|scene| {
                let dark = Material { color: Vec3::splat(0.3), trdepth: 0.2, ..tinted(0.0) };
                scene.add(ball([0.0, 0.5, 0.0], 0.35), material(glass, [1.0; 3], 0.0));
                scene.add(ball([0.0, 0.8, 0.0], 0.35), dark);
                lamp(scene, 0.3, 20.0);
            }),
        ),
        (
            "a ball of glass whose color is that of a texture where a path enters",
            with(&|scene| {
                let texel = |i: usize| if i % 4 < 2 { [255; 4] } else { [40, 160, 90, 255] };
                scene.textures.push(Texture {
                    name: String::new(),
                    width: 8,
                    height: 4,
                    pixels: Pixels::Bytes((0..32).map(texel).collect()),
                });
                let glass = Material { color_tex: Some(0), trdepth: 0.2, ..tinted(0.0) };
                scene.add(ball([0.0, 0.6, 0.0], 0.5), glass);
                lamp(scene, 0.3, 20.0);
            }),
        ),
        ("a frosted ball of dark glass below a lamp, before nothing", {
            let camera = Camera::look_at(Vec3::new(0.0, 0.9, 2.5), 0.3 * Vec3::Y, Vec3::Y);
            let mut scene = Scene { cameras: vec![camera], ..Scene::default() };
            dim(&mut scene);
            let dark = material(glass, [0.4, 0.7, 0.4], 0.42);
            scene.add(ball([0.0; 3], 0.3), Material { trdepth: 0.4, ..dark });
            scene.add(ball([-0.1, 1.4, 1.0], 0.4), shine(20.0));
            scene
        }),
        (
            "an awning over metal, below a lamp whose corners a file has rounded",
            with(&|scene| {
                dim(scene);
                scene.materials[0] = Material { roughness: 0.2, ..metal() };
                let camera = Camera::look_at(Vec3::new(0.0, 0.5, 2.5), 0.5 * Vec3::Y, Vec3::Y);
                scene.cameras = vec![camera];
                let awning =
                    [[-0.8, 0.1, -0.4], [0.8, 0.1, -0.4], [0.8, 0.9, 0.2], [-0.8, 0.9, 0.2]];
                scene.add(quad(awning), material(MaterialKind::Matte, [0.8; 3], 0.0));
                // The fourth corner is 3e-6 off the rectangle.
                let corners = [
                    [0.030_799_3, 1.163_59, 0.521_173],
                    [0.385_922, 1.148_81, 0.669_003],
                    [0.497_846, 0.923_541, 0.377_608],
                    [0.142_723, 0.938_324, 0.229_778],
                ];
                scene.add(quad(corners), shine(20.0));
            }),
        ),
        (
            "a lamp inside of glass beside a ball of glass",
            with(&|scene| {
                scene.add(ball([-0.6, 0.7, 0.0], 0.5), material(glass, [1.0; 3], 0.0));
                scene.add(ball([-0.6, 0.7, 0.0], 0.35), shine(10.0));
                scene.add(ball([0.5, 0.5, 0.0], 0.4), tinted(0.0));
            }),
        ),
    ]
}

/// Returns mean and standard error of each block over pictures of different seeds.
fn estimate(scene: &Scene, samples: u32, light_paths: bool) -> [(f64, f64); BLOCKS] {
    let world = World::new(scene).expect("a valid scene");
    assert!(has_light_paths(&world), "there is no caster");
    let picture = |seed: u64| {
        usual_picture(
            &world,
            samples,
            2 * seed + u64::from(light_paths),
            light_paths.then_some(RATE),
        )
    };
    let pictures: Vec<Blocks> = (0..8).map(picture).collect();
    let light = |block: [f64; 3]| block.iter().sum::<f64>() / 3.0;
    array::from_fn(|block| mean(pictures.iter().map(|picture| light(picture[block]))))
}

/// The reference has no light paths: it is the mean of many paths from the camera.
#[test]
fn light_paths_change_no_light() {
    for (why, scene) in cases() {
        let without = estimate(&scene, 256, false);
        let with = estimate(&scene, 64, true);
        for (block, ((a, error_a), (b, error_b))) in with.into_iter().zip(without).enumerate() {
            let error = error_a.hypot(error_b);
            assert!(error < 0.06 * b, "{why}, block {block}: {a} and {b} within {error}");
            let most = (0.005 * b).max(4.5 * error);
            assert!((a - b).abs() < most, "{why}, block {block}: {a}, not {b} within {error}");
        }
    }
}

/// Compares pictures with light paths and without them in random scenes. Returns the number of
/// scenes that have any.
///
/// Weights that prefer light paths leave the light the same, but show all that these would lose.
/// Where light paths are much the worse technique, a few bright ones may be missing in all pictures
/// of a scene: then the difference becomes smaller with more samples.
fn compare_scenes(numbers: Range<u64>) -> usize {
    let compare = |number: u64| {
        let scene = scene_of_casters(number);
        let world = World::new(&scene).expect("a valid scene");
        if !has_light_paths(&world) {
            return (0, None);
        }
        let with = |seed| usual_picture(&world, 64, seed, Some(100.0 * RATE));
        let without = |seed| usual_picture(&world, 256, seed, None);
        let found = difference([&with, &without]);
        (1, found.map(|what| format!("scene {number}, not as without light paths: {what}")))
    };
    let results: Vec<(usize, Option<String>)> = numbers.into_par_iter().map(compare).collect();
    let found: Vec<&str> = results.iter().filter_map(|(_, what)| what.as_deref()).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    results.iter().map(|&(count, _)| count).sum()
}

#[test]
fn light_paths_change_no_light_in_random_scenes() {
    // Frosted glass that light paths do not leave shows in scene 17.
    let numbers = scene_numbers(8..20);
    let asked = numbers.end - numbers.start;
    let compared = compare_scenes(numbers);
    assert!(2 * compared as u64 >= asked, "only {compared} of {asked} scenes have light paths");
}

/// Neither paths from the camera nor those from the lights find this light.
#[test]
fn light_through_a_ball_of_glass_is_found_in_a_mirror() {
    let mut scene = floor();
    // The camera looks into a mirror alone, at the place below the ball, where the mirror sends
    // none of the light of the lamp.
    let (eye, target) = (Vec3::new(0.0, 2.2, 0.6), Vec3::new(0.0, 0.4, -0.9));
    scene.cameras = vec![Camera { lens: 0.15, ..Camera::look_at(eye, target, Vec3::Y) }];
    let mirror = [[-0.5, 0.2, -0.85], [0.5, 0.2, -0.85], [0.5, 0.6, -0.95], [-0.5, 0.6, -0.95]];
    scene.add(quad(mirror), material(MaterialKind::Reflective, [0.9; 3], 0.0));
    scene.add(ball([0.1, 0.5, 0.0], 0.25), material(MaterialKind::Refractive, [1.0; 3], 0.0));
    lamp(&mut scene, 0.05, 700.0);
    let error = |light_paths| {
        let blocks = estimate(&scene, 64, light_paths);
        blocks.map(|(mean, error)| error / mean).into_iter().fold(0.0, f64::max)
    };
    let (without, with) = (error(false), error(true));
    assert!(with < 0.5 * without, "relative errors of {without} without, {with} with lenses");
}

/// A lamp so small that paths from the camera rarely find it through glass.
#[test]
fn light_paths_find_what_glass_casts_of_a_small_lamp() {
    let mut scene = floor();
    scene.add(ball([0.0, 0.6, 0.0], 0.4), material(MaterialKind::Refractive, [1.0; 3], 0.0));
    lamp(&mut scene, 0.05, 700.0);
    let error = |light_paths| {
        let blocks = estimate(&scene, 16, light_paths);
        blocks.map(|(mean, error)| error / mean).into_iter().fold(0.0, f64::max)
    };
    let (without, with) = (error(false), error(true));
    assert!(with < 0.1 * without, "relative errors of {without} without, {with} with light paths");
}
