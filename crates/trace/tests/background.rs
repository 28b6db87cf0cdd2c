//! The environment as a background: shown by default, transparent on request.

mod support;

use glam::Vec3;
use rotund_scene::{Material, MaterialKind, Scene};
use rotund_trace::{Options, View, World};
use support::{ball, quad, scene};

const SKY: Vec3 = Vec3::new(0.25, 0.5, 1.0);

fn pixels(scene: &Scene, options: &Options) -> Vec<[f32; 4]> {
    World::new(scene).expect("a valid scene").render(0, options).expect("a picture").image().pixels
}

#[test]
fn a_transparent_background_has_no_radiance_and_alpha_0() {
    // A sheet over the left half that is half opaque, before a ball in the middle.
    let sheet = quad([[-2.0, -2.0, 1.0], [0.0, -2.0, 1.0], [0.0, 2.0, 1.0], [-2.0, 2.0, 1.0]]);
    let black = Material { color: Vec3::ZERO, ..Material::default() };
    let grey = Material { color: Vec3::splat(0.5), ..Material::default() };
    let half = Material { opacity: 0.5, ..black.clone() };
    let scene = scene(vec![(sheet, half), (ball([0.0; 3], 0.5), grey)], SKY);
    let options = Options { width: 48, height: 32, samples: 64, ..Options::default() };
    let shown = pixels(&scene, &options);
    let hidden = pixels(&scene, &Options { transparent: true, ..options.clone() });
    let at = |x: usize, y: usize| y * 48 + x;
    for (pixel, seen) in shown.iter().zip(&hidden) {
        assert_eq!(pixel[3], 1.0);
        // Composited over the sky, a transparent picture is the one that shows it.
        let over = |channel: usize| seen[channel] + (1.0 - seen[3]) * SKY[channel];
        assert!((0..3).all(|c| (over(c) - pixel[c]).abs() < 1e-5), "{seen:?} over, not {pixel:?}");
    }
    assert_eq!(hidden[at(45, 2)], [0.0; 4], "the sky alone");
    assert_eq!(hidden[at(2, 2)], [0.0, 0.0, 0.0, 0.5], "the sheet takes a half");
    let ball = hidden[at(26, 16)];
    assert!(ball[3] == 1.0 && ball[2] > 0.2, "the sky lights the ball: {ball:?}");
}

#[test]
fn glass_and_mirrors_show_an_environment_that_is_hidden() {
    for kind in [MaterialKind::Refractive, MaterialKind::Reflective, MaterialKind::Transparent] {
        let material = Material { kind, color: Vec3::ONE, roughness: 0.0, ..Material::default() };
        let scene = scene(vec![(ball([0.0; 3], 0.9), material)], SKY);
        let options =
            Options { width: 9, height: 9, samples: 16, transparent: true, ..Options::default() };
        let [_, _, blue, alpha] = pixels(&scene, &options)[40];
        assert!(alpha == 1.0 && blue > 0.9, "{kind:?}: blue {blue}, alpha {alpha}");
    }
}

#[test]
fn a_clear_cloud_is_transparent_and_a_dense_one_is_not() {
    for (trdepth, alpha) in [(1e4, 0.0), (1e-3, 1.0)] {
        let cloud = Material {
            kind: MaterialKind::Volumetric,
            color: Vec3::splat(0.5),
            albedo: Vec3::splat(0.5),
            trdepth,
            ..Material::default()
        };
        let scene = scene(vec![(ball([0.0; 3], 0.9), cloud)], SKY);
        let options =
            Options { width: 9, height: 9, samples: 64, transparent: true, ..Options::default() };
        let found = pixels(&scene, &options)[40][3];
        assert!((found - alpha).abs() < 0.02, "depth {trdepth}: alpha {found}, not {alpha}");
    }
}

#[test]
fn views_that_show_the_environment_hide_it_too() {
    let scene = scene(vec![(ball([0.0; 3], 0.5), Material::default())], SKY);
    for view in [View::Eyelight, View::Furnace] {
        let options = Options { width: 9, height: 9, samples: 4, view, ..Options::default() };
        assert_eq!(pixels(&scene, &options)[0][3], 1.0, "{view}");
        let transparent = Options { transparent: true, ..options };
        assert_eq!(pixels(&scene, &transparent)[0], [0.0; 4], "{view}");
        assert_eq!(pixels(&scene, &transparent)[40][3], 1.0, "{view}");
    }
}
