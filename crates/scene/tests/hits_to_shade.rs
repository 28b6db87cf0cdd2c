//! Hits for renderers that need parameters only for colours and textures.

mod support;

use rotund_geometry::glam::{Affine3A, Vec2, Vec4};
use rotund_scene::{ElementKind, MaterialKind, Method, Route, Scene, SceneHit, Texture, Trees};
use support::{Random, ray_at, scene_of, shapes};

const SIZE: f32 = 0.5;

/// The scenes of each kind and method: plain, with vertex colours, and with a texture.
fn scenes() -> Vec<(Scene, bool)> {
    let mut scenes = Vec::new();
    for shape in shapes(&mut Random(5), 20, SIZE) {
        for method in [Method::Vanilla, Method::Enhanced] {
            let mut shape = shape.clone();
            shape.method = method;
            let kind = shape.elements.kind();
            let round = [ElementKind::Points, ElementKind::Lines].contains(&kind);
            let plain = scene_of(shape, Affine3A::IDENTITY, MaterialKind::Matte);
            let mut coloured = plain.clone();
            coloured.shapes[0].colors = vec![Vec4::ONE; plain.shapes[0].positions.len()];
            let mut textured = plain.clone();
            textured.textures.push(Texture::from_rgba8(1, 1, &[255; 4]).expect("one texel"));
            textured.materials[0].roughness_tex = Some(0);
            let skips = round && method == Method::Enhanced;
            scenes.extend([(plain, skips), (coloured, false), (textured, false)]);
        }
    }
    scenes
}

#[test]
fn a_hit_to_shade_is_the_hit_without_parameters_that_nothing_depends_on() {
    for (scene, skips) in scenes() {
        let trees = Trees::build(&scene).expect("the scene is valid");
        let rebuilt = trees.clone().with_route(Route::Rebuilt);
        let (mut random, mut hits) = (Random(6), 0);
        for _ in 0..2000 {
            let ray = ray_at(&mut random, &scene, SIZE);
            let full = trees.closest(&scene, &ray);
            let uv = |hit: SceneHit| if skips { Vec2::ZERO } else { hit.uv };
            let expected = full.map(|hit| SceneHit { uv: uv(hit), ..hit });
            assert_eq!(trees.closest_to_shade(&scene, &ray, None), expected, "{ray:?}");
            let full = rebuilt.closest(&scene, &ray);
            assert_eq!(rebuilt.closest_to_shade(&scene, &ray, None), full, "{ray:?}");
            hits += u32::from(full.is_some());
        }
        assert!(hits > 100, "{hits} hits");
    }
}
