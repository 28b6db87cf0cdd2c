//! Solids of clear glass conserve energy: they are invisible in a white furnace.

use glam::{Affine3A, Vec3};
use rotund_scene::{Camera, Elements, Environment, Instance, Material, MaterialKind, Scene, Shape};
use rotund_trace::{Options, View, World};

/// Elements, and their vertices as `[x, y, z, radius]`.
type Solid = (Elements, &'static [[f32; 4]]);

/// Returns a scene of glass solids, each shape in an instance of its own.
fn glass(shapes: &[Solid], roughness: f32) -> Scene {
    let shape = |(elements, balls): &Solid| Shape {
        elements: elements.clone(),
        positions: balls.iter().map(|&[x, y, z, _]| Vec3::new(x, y, z)).collect(),
        radii: balls.iter().map(|ball| ball[3]).collect(),
        ..Shape::default()
    };
    let instance = |index: usize| Instance {
        name: String::new(),
        world_from_object: Affine3A::IDENTITY,
        shape: index as u32,
        material: 0,
    };
    let material = Material {
        kind: MaterialKind::Refractive,
        color: Vec3::ONE,
        roughness,
        ..Material::default()
    };
    Scene {
        cameras: vec![Camera {
            world_from_camera: Affine3A::from_translation(Vec3::new(0.0, 0.0, 4.0)),
            ..Camera::default()
        }],
        materials: vec![material],
        shapes: shapes.iter().map(shape).collect(),
        instances: (0..shapes.len()).map(instance).collect(),
        ..Scene::default()
    }
}

/// Returns the least, mean and largest pixel of a furnace.
fn furnace(scene: &Scene) -> [f64; 3] {
    pixels(scene, View::Furnace)
}

fn pixels(scene: &Scene, view: View) -> [f64; 3] {
    let options =
        Options { width: 48, height: 32, samples: 64, bounces: 4096, view, ..Options::default() };
    let film = World::new(scene).expect("a valid scene").render(0, &options).expect("a picture");
    assert_eq!(film.rejected(), 0, "every sample is a radiance");
    let pixels = film.image().pixels;
    let values = || pixels.iter().map(|pixel| f64::from(pixel[0]));
    [
        values().fold(f64::INFINITY, f64::min),
        values().sum::<f64>() / pixels.len() as f64,
        values().fold(0.0, f64::max),
    ]
}

#[test]
fn clear_glass_cannot_be_seen_in_a_white_furnace() {
    let point = || Elements::Points(1);
    let line = || Elements::Lines(vec![[0, 1]]);
    let balls: &'static [[f32; 4]] = &[[-0.5, 0.0, 0.0, 0.5], [0.5, 0.0, 0.0, 0.5]];
    let table: [(&str, Vec<Solid>); 6] = [
        ("a ball", vec![(point(), &[[0.0, 0.0, 0.0, 0.8]])]),
        ("two balls that touch, of one shape", vec![(Elements::Points(2), balls)]),
        (
            "a ball in a ball, and one that touches it from inside",
            vec![
                (point(), &[[0.0, 0.0, 0.0, 0.9]]),
                (point(), &[[0.1, 0.1, 0.0, 0.5]]),
                (point(), &[[-0.7, 0.0, 0.0, 0.2]]),
            ],
        ),
        ("a tube", vec![(line(), &[[-0.8, -0.2, 0.0, 0.3], [0.8, 0.2, 0.0, 0.3]])]),
        (
            "a cone in a tube",
            vec![
                (line(), &[[-0.8, 0.0, 0.0, 0.5], [0.8, 0.0, 0.0, 0.5]]),
                (line(), &[[-0.7, 0.0, 0.0, 0.3], [0.7, 0.1, 0.0, 0.05]]),
            ],
        ),
        (
            "tubes that touch and a tube across both",
            vec![
                (line(), &[[-0.8, 0.2, 0.0, 0.2], [0.8, 0.2, 0.0, 0.2]]),
                (line(), &[[-0.8, -0.2, 0.0, 0.2], [0.8, -0.2, 0.0, 0.2]]),
                (line(), &[[0.0, -0.7, 0.05, 0.1], [0.0, 0.7, 0.05, 0.1]]),
            ],
        ),
    ];
    for (why, shapes) in table {
        let [least, mean, largest] = furnace(&glass(&shapes, 0.0));
        // All weights are 1 except by Russian roulette, which ends 1 % of the paths at each
        // segment.
        assert!((mean - 1.0).abs() < 2e-3, "{why}: {mean} on average");
        // Long paths in the glass make pixels noisy by that, but none is dark.
        assert!(least > 0.25 && largest < 2.0, "{why}: between {least} and {largest}");
    }
}

fn white_sky() -> Environment {
    Environment {
        name: String::new(),
        world_from_environment: Affine3A::IDENTITY,
        emission: Vec3::ONE,
        emission_tex: None,
    }
}

/// Glass is followed both ways, but each sample has the light of one path.
#[test]
fn no_sample_of_clear_glass_is_brighter_than_a_white_sky() {
    let tube: Solid =
        (Elements::Lines(vec![[0, 1]]), &[[-0.8, -0.2, 0.0, 0.4], [0.8, 0.2, 0.0, 0.2]]);
    let mut scene = glass(&[tube], 0.0);
    scene.environments.push(white_sky());
    // Russian roulette, which makes samples brighter, begins later.
    let options = Options { width: 48, height: 32, samples: 64, bounces: 4, ..Options::default() };
    let film = World::new(&scene).expect("a valid scene").render(0, &options).expect("a picture");
    assert_eq!(film.fireflies(), 0);
}

#[test]
fn frosted_glass_gains_no_light() {
    let balls: &'static [[f32; 4]] = &[[0.0, 0.0, 0.0, 0.8]];
    for roughness in [0.1, 0.2, 0.3, 0.4] {
        let [_, mean, _] = furnace(&glass(&[(Elements::Points(1), balls)], roughness));
        // Russian roulette adds noise of a few in ten thousand.
        assert!(mean < 1.0005, "{roughness}: {mean}");
        assert!(mean > 0.8, "{roughness}: {mean}, it does not go black");
    }
}

/// Paths are split where they enter, and lights are sampled inside only where there may be some.
#[test]
fn milk_that_absorbs_nothing_cannot_be_seen_in_white_light() {
    let ball: Solid = (Elements::Points(1), &[[0.0, 0.0, 0.0, 1.0]]);
    let shell: Solid = (Elements::Points(1), &[[0.0, 0.0, 0.0, 50.0]]);
    for anisotropy in [0.0, 0.7] {
        let mut in_sky = glass(std::slice::from_ref(&ball), 0.0);
        let milk = &mut in_sky.materials[0];
        milk.color = Vec3::splat(0.3);
        milk.trdepth = 1.0;
        milk.albedo = Vec3::ONE;
        milk.anisotropy = anisotropy;
        in_sky.environments.push(white_sky());
        let mut in_shell = glass(&[ball.clone(), shell.clone()], 0.0);
        in_shell.materials = vec![
            in_sky.materials[0].clone(),
            Material { emission: Vec3::ONE, ..Material::default() },
        ];
        in_shell.instances[1].material = 1;
        let views = [
            ("a furnace", &in_sky, View::Furnace),
            ("a sky", &in_sky, View::Path),
            ("a shell that shines", &in_shell, View::Path),
        ];
        for (what, scene, view) in views {
            let [_, mean, _] = pixels(scene, view);
            assert!((mean - 1.0).abs() < 2e-3, "in {what}, anisotropy {anisotropy}: {mean}");
        }
    }
}
