//! Neighbouring instances of few triangles share a tree, with the same answers as separate trees.

mod support;

use rotund_geometry::glam::{Affine3A, Vec3};
use rotund_scene::{ElementKind, Instance, MaterialKind, Scene, SceneHit, Shape, Trees};
use support::{Random, ray_at, scene_of, shapes};

const SIZE: f32 = 0.5;

/// Shapes of which some share a tree and some do not: some kinds and frames stand between the
/// triangles, one shape is there twice, one is empty, and the last has too many triangles.
fn scene() -> Scene {
    let mut random = Random(3);
    let mut of = |kind: ElementKind, count: u32| -> Shape {
        let all = shapes(&mut random, count, SIZE);
        all.into_iter().find(|shape| shape.elements.kind() == kind).expect("all kinds are there")
    };
    use ElementKind::{Points, Quads, Triangles};
    let shapes = vec![
        of(Triangles, 3),
        of(Triangles, 1),
        of(Triangles, 0),
        of(Quads, 3),
        of(Points, 3),
        of(Triangles, 64),
        of(Triangles, 65),
    ];
    let moved = Affine3A::from_translation(Vec3::new(0.1, -0.2, 0.3));
    let still = Affine3A::IDENTITY;
    let places = [
        (3, still),
        (0, still),
        (1, still),
        (1, still),
        (2, still),
        (0, moved),
        (4, still),
        (5, still),
        (0, still),
        (2, still),
        (6, still),
        (1, still),
    ];
    let instance = |&(shape, world_from_object): &(u32, Affine3A)| Instance {
        name: String::new(),
        world_from_object,
        shape,
        material: 0,
    };
    let first = scene_of(shapes[0].clone(), still, MaterialKind::Matte);
    Scene { shapes, instances: places.iter().map(instance).collect(), ..first }
}

#[test]
fn rays_meet_instances_that_share_a_tree_as_they_meet_each_alone() {
    let whole = scene();
    let trees = Trees::build(&whole).expect("the scene is valid");
    assert_eq!(trees.statistics().len(), whole.shapes.len(), "one for each shape");
    let alone: Vec<(Scene, Trees)> = whole
        .instances
        .iter()
        .map(|instance| {
            let scene = Scene { instances: vec![instance.clone()], ..whole.clone() };
            let trees = Trees::build(&scene).expect("the scene is valid");
            (scene, trees)
        })
        .collect();
    let mut random = Random(5);
    let mut met = vec![0; whole.instances.len()];
    for _ in 0..20_000 {
        let ray = ray_at(&mut random, &whole, SIZE);
        let hits = alone.iter().enumerate().filter_map(|(index, (scene, trees))| {
            Some(SceneHit { instance: index as u32, ..trees.closest(scene, &ray)? })
        });
        // Of equal `t` the first, as `min_by` returns.
        let expected = hits.min_by(|a, b| a.t.total_cmp(&b.t));
        assert_eq!(trees.closest(&whole, &ray), expected, "{ray:?}");
        assert_eq!(trees.any(&whole, &ray), expected.is_some(), "{ray:?}");
        if let Some(hit) = expected {
            met[hit.instance as usize] += 1;
        }
    }
    // The second of two instances that coincide is never hit, nor is one without triangles.
    let never = [3, 4, 8, 9, 11];
    for (instance, &count) in met.iter().enumerate() {
        assert_eq!(count == 0, never.contains(&instance), "instance {instance}: {count}");
    }
}
