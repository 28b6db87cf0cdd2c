//! Solids that scatter, against the theory of radiative transfer.

use glam::Vec3;
use rotund_scene::{
    Camera, ElementKind, Environment, Instance, Material, MaterialKind, Method, Pixels, Scene,
    Shape, Texture,
};
use rotund_trace::{Options, Stage, World};

/// Adds a sky with one row of its texture for each radiance, from the zenith down.
fn sky(scene: &mut Scene, rows: &[f32]) {
    let pixels = rows.iter().flat_map(|&row| [[row, row, row, 1.0]; 2]).collect();
    scene.textures.push(Texture {
        name: String::new(),
        width: 2,
        height: rows.len() as u32,
        pixels: Pixels::Floats(pixels),
    });
    scene.environments.push(Environment {
        name: String::new(),
        world_from_environment: Default::default(),
        emission: Vec3::ONE,
        emission_tex: Some(0),
    });
}

/// Returns a cloud of one free path per meter that fills nearly all below `y = 0`, seen from above.
fn deep_cloud(albedo: f32) -> Scene {
    deep(Vec3::splat((-1.0_f32).exp()), albedo)
}

/// Returns one of this transmittance of a meter.
fn deep(color: Vec3, albedo: f32) -> Scene {
    const FAR: f32 = 1e3;
    let corner = |i: u32| {
        let side = |bit: u32| if i & bit == 0 { -FAR } else { FAR };
        Vec3::new(side(1), side(2) - FAR, side(4))
    };
    let faces =
        [[2, 6, 7, 3], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [0, 2, 3, 1], [4, 5, 7, 6]];
    let top = Shape::quads((0..8).map(corner).collect::<Vec<_>>(), faces);
    assert!(top.is_closed());
    let material = Material {
        kind: MaterialKind::Volumetric,
        color,
        trdepth: 1.0,
        albedo: Vec3::splat(albedo),
        ..Material::default()
    };
    let instance = Instance {
        name: String::new(),
        world_from_object: Default::default(),
        shape: 0,
        material: 0,
    };
    let camera =
        Camera { orthographic: true, ..Camera::look_at(5.0 * Vec3::Y, Vec3::ZERO, Vec3::Z) };
    Scene {
        cameras: vec![camera],
        materials: vec![material],
        shapes: vec![top],
        instances: vec![instance],
        ..Scene::default()
    }
}

/// Returns the mean radiance that the camera sees.
fn brightness(scene: &Scene) -> f64 {
    let options =
        Options { width: 32, height: 32, samples: 256, bounces: 4096, ..Options::default() };
    let film = World::new(scene).expect("a valid scene").render(0, &options).expect("a picture");
    let pixels = film.image().pixels;
    pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / pixels.len() as f64
}

/// Returns H(1) of isotropic scattering, by iteration of its integral equation.
///
/// Source: S. Chandrasekhar, "Radiative Transfer", 1950, sections 37 to 42.
fn h_at_normal_incidence(albedo: f64) -> f64 {
    const CELLS: usize = 400;
    let place = |cell: usize| (cell as f64 + 0.5) / CELLS as f64;
    let next = |h: &[f64], mu: f64| {
        let cells = h.iter().enumerate();
        let sum: f64 = cells.map(|(cell, h)| place(cell) * h / (mu + place(cell))).sum();
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * sum / CELLS as f64)
    };
    let mut h = vec![1.0; CELLS];
    for _ in 0..100 {
        h = (0..CELLS).map(|cell| next(&h, place(cell))).collect();
    }
    next(&h, 1.0)
}

#[test]
fn a_deep_cloud_reflects_a_uniform_sky_as_theory_says() {
    for albedo in [0.3, 0.8] {
        let mut scene = deep_cloud(albedo);
        sky(&mut scene, &[1.0; 8]);
        let albedo = f64::from(albedo);
        let expected = 1.0 - h_at_normal_incidence(albedo) * (1.0 - albedo).sqrt();
        let found = brightness(&scene);
        assert!((found / expected - 1.0).abs() < 0.01, "{albedo}: {found}, not {expected}");
    }
}

#[test]
fn no_light_comes_through_a_deep_cloud() {
    let mut scene = deep_cloud(0.8);
    sky(&mut scene, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.0]);
    assert_eq!(brightness(&scene), 0.0);
}

#[test]
fn a_cloud_without_extinction_in_one_channel_shows_the_sky_behind_in_it() {
    let mut scene = deep(Vec3::new(0.5, 0.5, 1.0), 0.0);
    scene.materials[0].albedo = Vec3::new(0.5, 0.5, 0.0);
    // Aslant, since the nadir shows the row of the zenith.
    let aslant = Camera::look_at(5.0 * Vec3::Y, 3.0 * Vec3::X, Vec3::Y);
    scene.cameras[0] = Camera { orthographic: true, ..aslant };
    sky(&mut scene, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
    let film = World::new(&scene).expect("a valid scene");
    let options = Options { width: 16, height: 16, samples: 64, ..Options::default() };
    let pixels = film.render(0, &options).expect("a picture").image().pixels;
    let mean = |channel: usize| {
        pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / pixels.len() as f32
    };
    assert_eq!([mean(0), mean(1)], [0.0; 2]);
    assert!((mean(2) - 1.0).abs() < 0.02, "{}", mean(2));
}

/// A disc is open, so that rays inside of it must not be traced as those of a ball are.
#[test]
fn a_cloud_whose_method_changes_looks_like_a_new_scene() {
    let mut scene = deep_cloud(0.5);
    scene.shapes = vec![Shape::points([-2.0 * Vec3::Y], 2.0)];
    sky(&mut scene, &[1.0; 8]);
    let options = Options { width: 16, height: 16, samples: 4, ..Options::default() };
    let mut stage = Stage::new(scene.clone()).expect("a valid scene");
    for method in [Method::Vanilla, Method::Enhanced] {
        scene.set_method(ElementKind::Points, method);
        stage.set_method(ElementKind::Points, method);
        let expected = World::new(&scene).expect("a valid scene").render(0, &options);
        assert_eq!(stage.world().render(0, &options), expected, "{method}");
    }
}
