//! Lamps whose colour varies: a sampled point shines as it does where a ray meets it.

use super::{Lights, Receiver, shining};
use crate::{Sampler, Sequence};
use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use rotund_geometry::Ray;
use rotund_scene::{Elements, Method, Pixels, Texture, Trees};

#[test]
fn a_sampled_point_shines_as_it_does_where_a_ray_meets_it() {
    let ball = || (Elements::Points(1), vec![[0.2, 0.1, 0.0]]);
    let rod = || (Elements::Lines(vec![[0, 1]]), vec![[-1.0, 0.0, 0.0], [1.0, 0.3, 0.2]]);
    let corners = vec![[-1.0, 0.0, -0.5], [0.9, 0.2, -0.5], [1.0, 0.0, 0.5], [-0.8, 0.3, 0.6]];
    let quad = || (Elements::Quads(vec![[0, 1, 2, 3]]), corners.clone());
    let triangles = || (Elements::Triangles(vec![[0, 1, 2], [0, 2, 3]]), corners.clone());
    let table = [
        ("a ball", ball(), Method::Enhanced),
        ("a rod", rod(), Method::Enhanced),
        ("a patch", quad(), Method::Enhanced),
        ("two triangles of a quad", quad(), Method::Vanilla),
        ("triangles", triangles(), Method::Vanilla),
    ];
    for (why, (elements, positions), method) in table {
        let radii: &[f32] = match positions.len() {
            1 => &[0.4],
            2 => &[0.4, 0.2],
            _ => &[],
        };
        let mut scene = shining(elements, method, &positions, radii);
        let tone = |i: usize| Vec4::new(1.0, 0.4 + 0.15 * i as f32, 0.9 - 0.25 * i as f32, 1.0);
        scene.shapes[0].colors = (0..positions.len()).map(tone).collect();
        // One wave around: smooth, so that the rounding of parameters changes little.
        let wave = |i: u32| 0.5 + 0.4 * (std::f32::consts::TAU * i as f32 / 64.0).sin();
        let pixels = (0..64 * 64).map(|i| [wave(i % 64), wave(i / 64), 1.0, 1.0]).collect();
        scene.textures = vec![Texture {
            name: String::new(),
            width: 64,
            height: 64,
            pixels: Pixels::Floats(pixels),
        }];
        scene.materials[0].emission_tex = Some(0);
        scene.instances[0].world_from_object = Affine3A::from_scale_rotation_translation(
            Vec3::splat(1.7),
            Quat::from_rotation_z(0.4) * Quat::from_rotation_y(0.8),
            Vec3::new(0.3, 2.0, -0.1),
        );
        let trees = Trees::build(&scene).expect("the scene is valid");
        let lights = Lights::build(&scene).expect("a valid scene");
        let receiver = Receiver { position: Vec3::new(0.1, -1.0, 0.2), normal: None };
        let mut seen = 0;
        for index in 0..1 << 10 {
            let [x, y, choice, _] = Sampler::new(Sequence::Sobol, 1, 0, 0, index).set(0);
            let Some(light) = lights.sample(&receiver, choice, Vec2::new(x, y)) else { continue };
            let ray = Ray::new(receiver.position, light.incoming);
            let source = light.source.expect("the light is near").position;
            let Some(hit) = trees.closest(&scene, &ray) else { continue };
            // At grazing angles a ray may meet another place of the lamp.
            if hit.position.distance(source) > 1e-4 || hit.normal.dot(ray.direction).abs() < 0.05 {
                continue;
            }
            seen += 1;
            let met = scene.eval_emission(hit.instance, hit.element, hit.uv);
            let sampled = lights.radiance(&scene, &light);
            assert!(sampled.abs_diff_eq(met, 5e-3), "{why}: {sampled} is not {met} at {source}");
        }
        assert!(seen > 400, "{why}: {seen} samples are seen");
    }
}
