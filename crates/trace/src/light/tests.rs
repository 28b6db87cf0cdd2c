//! Sampled lights against integrals over their exact surfaces, in `f64`.

mod colors;
mod irradiance;

use super::{Lights, Receiver};
use crate::{Sampler, Sequence, power_heuristic, warp};
use glam::{Affine3A, DVec3, Vec2, Vec3};
use rotund_geometry::{Ray, leave_surface};
use rotund_scene::{
    Elements, Environment, Instance, Material, Method, Pixels, Scene, Shape, Texture, Trees,
};
use std::f64::consts::PI;

const SAMPLES: u32 = 1 << 15;

/// Returns a scene with one shape of radiance 1.
fn shining(elements: Elements, method: Method, positions: &[[f32; 3]], radii: &[f32]) -> Scene {
    let shape = Shape {
        method,
        elements,
        positions: positions.iter().map(|&p| Vec3::from_array(p)).collect(),
        radii: radii.to_vec(),
        ..Shape::default()
    };
    Scene {
        materials: vec![Material { emission: Vec3::ONE, ..Material::default() }],
        shapes: vec![shape],
        instances: vec![Instance {
            name: String::new(),
            world_from_object: Affine3A::IDENTITY,
            shape: 0,
            material: 0,
        }],
        ..Scene::default()
    }
}

fn lights(scene: &Scene) -> Lights {
    Lights::build(scene).expect("a valid scene")
}

/// Estimates the irradiance on a receiver from light samples. Each sample must be visible, and the
/// density of its hit must be that of the sample.
fn drawn(scene: &Scene, position: Vec3, normal: Vec3) -> f64 {
    let (trees, lights) = (
        Trees::build(scene).expect("the scene is valid"),
        Lights::build(scene).expect("a valid scene"),
    );
    let receiver = Receiver { position, normal: Some(normal) };
    let mut sum = 0.0;
    let mut lost = 0;
    for index in 0..SAMPLES {
        let [x, y, choice, _] = Sampler::new(Sequence::Sobol, 1, 0, 0, index).set(0);
        let Some(light) = lights.sample(&receiver, choice, Vec2::new(x, y)) else {
            continue;
        };
        let cosine = normal.dot(light.incoming);
        // Samples below the horizon contribute nothing; near the silhouette a ray may miss by
        // rounding.
        if cosine <= 0.0 {
            continue;
        }
        let source = light.source.expect("the light is near");
        let start = leave_surface(position, 0.0, normal, light.incoming);
        match trees.closest(scene, &Ray::new(start, light.incoming)) {
            Some(hit) if hit.position.distance(source.position) < 1e-3 => {
                let pdf = lights.pdf(&receiver, &hit);
                let slant = hit.normal.dot(light.incoming).abs();
                // At grazing angles the density per solid angle amplifies rounding.
                assert!(
                    (pdf - light.pdf).abs() <= 1e-4 / slant * light.pdf || slant < 0.01,
                    "{pdf} is not {} at {hit:?}",
                    light.pdf
                );
            }
            _ => lost += 1,
        }
        sum += f64::from(cosine / light.pdf * lights.radiance(scene, &light).x);
    }
    // A patch can occlude itself; the other shapes are convex.
    let bends = matches!(scene.shapes[0].elements, Elements::Quads(_));
    assert!(bends || lost * 500 < SAMPLES, "{lost} samples are not seen");
    sum / f64::from(SAMPLES)
}

/// Returns the irradiance from a polygon: the sum over its edges of the subtended angle, along the
/// normal of the plane through the edge and the eye.
///
/// Source: J. Lambert, "Photometria", 1760.
fn lambert(corners: &[DVec3], eye: DVec3, normal: DVec3) -> f64 {
    // The polygon is clipped to the horizon; a great circle is clipped like a line by a plane.
    let mut above = Vec::new();
    for (i, &corner) in corners.iter().enumerate() {
        let [a, b] = [corner, corners[(i + 1) % corners.len()]].map(|c| c - eye);
        let (from, to) = (normal.dot(a), normal.dot(b));
        if from >= 0.0 {
            above.push(a.normalize());
        }
        if from * to < 0.0 {
            above.push((a * to - b * from).normalize() * to.signum());
        }
    }
    let edge = |i: usize| {
        let (a, b) = (above[i], above[(i + 1) % above.len()]);
        a.angle_between(b) * a.cross(b).normalize_or_zero().dot(normal)
    };
    (0.5 * (0..above.len()).map(edge).sum::<f64>()).abs()
}

fn assert_near(why: &str, drawn: f64, expected: f64) {
    assert!(expected > 0.0, "{why}: nothing arrives");
    assert!((drawn / expected - 1.0).abs() < 2e-3, "{why}: {drawn}, not {expected}");
}

#[test]
fn a_ball_overhead_lights_as_the_closed_form_says() {
    let scene = shining(Elements::Points(1), Method::Enhanced, &[[0.0; 3]], &[0.5]);
    for distance in [0.5001_f32, 0.7, 2.0, 1000.0] {
        let expected = PI * f64::from(0.5 / distance).powi(2);
        let drawn = drawn(&scene, Vec3::new(0.0, -distance, 0.0), Vec3::Y);
        assert_near(&format!("{distance}"), drawn, expected);
    }
}

#[test]
fn a_rectangle_lights_as_the_closed_form_says() {
    // As quads of either method, and as two triangles of a mesh.
    let corners = [[-0.5, 0.0, -0.3], [0.5, 0.0, -0.3], [0.5, 0.0, 0.3], [-0.5, 0.0, 0.3]];
    let quad = || Elements::Quads(vec![[0, 1, 2, 3]]);
    let scenes = [
        shining(quad(), Method::Vanilla, &corners, &[]),
        shining(quad(), Method::Enhanced, &corners, &[]),
        shining(Elements::Triangles(vec![[0, 1, 2], [0, 2, 3]]), Method::Vanilla, &corners, &[]),
    ];
    for (why, position, normal) in [
        ("below its middle", [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]),
        ("aside", [1.0, -0.7, 0.4], [0.0, 1.0, 0.0]),
        ("turned away", [1.0, -2.0, 0.4], [0.5, 0.8, 0.1]),
        ("partly below the horizon", [0.2, -0.7, 0.1], [0.9, 0.1, 0.0]),
        ("very near", [0.1, -0.02, 0.1], [0.0, 1.0, 0.0]),
    ] {
        let (position, normal) = (Vec3::from(position), Vec3::from(normal).normalize());
        let outline = corners.map(|c| Vec3::from(c).as_dvec3());
        let expected = lambert(&outline, position.as_dvec3(), normal.as_dvec3());
        for scene in &scenes {
            assert_near(why, drawn(scene, position, normal), expected);
        }
    }
}

#[test]
fn the_triangles_of_a_rectangle_shine_as_one() {
    let corners = [[-0.5, 0.0, -0.3], [0.5, 0.0, -0.3], [0.5, 0.0, 0.3], [-0.5, 0.0, 0.3]];
    let bent = [corners[0], corners[1], corners[2], [-0.5, 0.1, 0.3]];
    let mesh = |triangles: &[[u32; 3]], corners: &[[f32; 3]; 4]| {
        shining(Elements::Triangles(triangles.to_vec()), Method::Vanilla, corners, &[])
    };
    let quad = shining(Elements::Quads(vec![[0, 1, 2, 3]]), Method::Vanilla, &corners, &[]);
    let receiver = Receiver { position: Vec3::new(0.5, -0.5, 0.1), normal: Some(Vec3::Y) };
    let pdf = |scene: &Scene, choice| {
        let light = lights(scene).sample(&receiver, choice, Vec2::new(0.3, 0.6));
        light.expect("the light is above").pdf
    };
    for (why, scene, one) in [
        ("a fan", mesh(&[[0, 1, 2], [0, 2, 3]], &corners), true),
        ("the other diagonal", mesh(&[[1, 2, 3], [0, 1, 3]], &corners), true),
        ("turned differently", mesh(&[[2, 0, 1], [3, 0, 2]], &corners), true),
        ("one from behind", mesh(&[[0, 1, 2], [0, 3, 2]], &corners), true),
        ("bent", mesh(&[[0, 1, 2], [0, 2, 3]], &bent), false),
        ("a triangle twice", mesh(&[[0, 1, 2], [0, 1, 2]], &corners), false),
        ("a triangle alone", mesh(&[[0, 1, 2]], &corners), false),
    ] {
        for choice in [0.01, 0.99] {
            let (found, expected) = (pdf(&scene, choice), pdf(&quad, choice));
            let same = (found / expected - 1.0).abs() < 1e-4;
            assert_eq!(same, one, "{why}: {found}, of the rectangle {expected}");
        }
    }
}

/// Ten thousand balls of very unequal power: the estimate must be unbiased, and better than by
/// power alone.
#[test]
fn many_lights_are_chosen_by_what_they_add() {
    const COUNT: usize = 10_000;
    let number = |i: usize, set: u32| Sampler::new(Sequence::Sobol, 9, 0, 0, i as u32).set(set);
    let positions: Vec<[f32; 3]> = (0..COUNT)
        .map(|i| {
            let [x, y, z, _] = number(i, 0);
            [20.0 * (x - 0.5), 0.5 + 2.0 * y, 20.0 * (z - 0.5)]
        })
        .collect();
    let radii: Vec<f32> = (0..COUNT).map(|i| 0.002 + 0.02 * number(i, 1)[0].powi(8)).collect();
    let scene = shining(Elements::Points(COUNT as u32), Method::Enhanced, &positions, &radii);
    let (position, normal) = (Vec3::ZERO, Vec3::Y);
    let expected: f64 = positions
        .iter()
        .zip(&radii)
        .map(|(&p, &r)| {
            let to = Vec3::from(p).as_dvec3();
            PI * f64::from(r).powi(2) * to.y / to.length().powi(3)
        })
        .sum();
    let lights = lights(&scene);
    let receiver = Receiver { position, normal: Some(normal) };
    let values: Vec<f64> = (0..SAMPLES)
        .map(|index| {
            let [x, y, choice, _] = Sampler::new(Sequence::Independent, 1, 0, 0, index).set(0);
            let light = lights.sample(&receiver, choice, Vec2::new(x, y));
            light.map_or(0.0, |l| f64::from(normal.dot(l.incoming).max(0.0) / l.pdf))
        })
        .collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance =
        values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64;
    let error = (variance / values.len() as f64).sqrt();
    assert!((mean - expected).abs() < 4.0 * error, "{mean} +- {error}, not {expected}");
    // Sampling by power alone has a relative standard deviation of about 9 here.
    assert!(variance.sqrt() < 2.0 * mean, "deviation {} of {mean}", variance.sqrt());
}

#[test]
fn an_image_and_its_density_integrate_to_what_they_should() {
    let (width, height) = (16_u32, 8_u32);
    let pixels = (0..width * height)
        .map(|i| {
            let bright = if i == 45 { 500.0 } else { 1.0 + (i % 7) as f32 };
            [bright, 0.5 * bright, 2.0, 1.0]
        })
        .collect();
    let turn = Affine3A::from_rotation_x(0.7) * Affine3A::from_rotation_y(2.0);
    let scene = Scene {
        environments: vec![Environment {
            name: String::new(),
            world_from_environment: turn,
            emission: Vec3::new(1.0, 2.0, 0.5),
            emission_tex: Some(0),
        }],
        textures: vec![Texture {
            name: String::new(),
            width,
            height,
            pixels: Pixels::Floats(pixels),
        }],
        ..Scene::default()
    };
    let lights = lights(&scene);
    let receiver = Receiver { position: Vec3::ZERO, normal: None };
    // The expected irradiance and the integral of the density, by the midpoint rule.
    const STEPS: usize = 800;
    let (mut truth, mut total) = (0.0, 0.0);
    for i in 0..STEPS {
        for j in 0..2 * STEPS {
            let theta = (i as f64 + 0.5) / STEPS as f64 * PI;
            let azimuth = (j as f64 + 0.5) / STEPS as f64 * PI;
            let (sine, cosine) = theta.sin_cos();
            let d = DVec3::new(sine * azimuth.cos(), cosine, sine * azimuth.sin()).as_vec3();
            let weight = sine * (PI / STEPS as f64).powi(2);
            let (radiance, pdf) = lights.environment(&scene, Some(&lights.aim(&receiver)), d);
            assert_eq!(radiance, scene.eval_environment(d));
            truth += weight * f64::from(radiance.x);
            total += weight * f64::from(pdf);
        }
    }
    assert!((total - 1.0).abs() < 2e-3, "the density sums to {total}");
    // The density is 0 where the sky is darker than its mean, so a second technique is needed.
    let uniform = 1.0 / (4.0 * PI as f32);
    let (mut sum, mut edges) = (0.0, 0);
    for index in 0..SAMPLES {
        let [x, y, choice, _] = Sampler::new(Sequence::Sobol, 1, 0, 0, index).set(0);
        let light = lights.sample(&receiver, choice, Vec2::new(x, y)).expect("it shines");
        let (_, again) = lights.environment(&scene, Some(&lights.aim(&receiver)), light.incoming);
        // Rounding moves some directions across the edge of their cell.
        edges += u32::from((again - light.pdf).abs() > 1e-3 * light.pdf);
        sum += f64::from(
            power_heuristic(light.pdf, uniform) * lights.radiance(&scene, &light).x / light.pdf,
        );
        let [x, y, ..] = Sampler::new(Sequence::Sobol, 1, 0, 0, index).set(1);
        let d = warp::sphere(Vec2::new(x, y));
        let (value, other) = lights.environment(&scene, Some(&lights.aim(&receiver)), d);
        sum += f64::from(power_heuristic(uniform, other) * value.x / uniform);
    }
    assert!(edges * 1000 < SAMPLES, "{edges} directions have another density when they are met");
    assert_near("the image", sum / f64::from(SAMPLES), truth);
}
