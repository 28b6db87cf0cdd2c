//! Trees that follow a scene whose vertices and frames move.

mod support;

use rotund_geometry::{
    Ray,
    glam::{Affine3A, Vec3},
};
use rotund_scene::{Elements, Instance, Material, Method, Scene, SceneError, Shape, Trees};
use support::{Random, frames, ray_at, shapes};

const SIZE: f32 = 0.3;

/// All kinds of shapes in frames of all kinds; some instances of triangles share a tree.
fn scene(random: &mut Random) -> Scene {
    let mut scene = Scene { shapes: shapes(random, 40, SIZE), ..Scene::default() };
    scene.materials.push(Material::default());
    for (index, (_, frame)) in frames().into_iter().enumerate() {
        let shape = index as u32 % 4;
        scene.instances.push(Instance { world_from_object: frame, ..Instance::new(shape, 0) });
    }
    scene.instances.extend([Instance::new(2, 0), Instance::new(2, 0), Instance::new(0, 0)]);
    scene
}

/// Asserts that refitted and new trees give the same answers to the bit; returns the number of
/// hits.
fn compare(random: &mut Random, scene: &mut Scene, refitted: &Trees) -> u32 {
    let fresh = Trees::build(scene).expect("valid");
    let mut hits = 0;
    for method in [Method::Enhanced, Method::Vanilla] {
        scene.shapes.iter_mut().for_each(|shape| shape.method = method);
        for _ in 0..2000 {
            let ray = ray_at(random, scene, SIZE);
            let expected = fresh.closest(scene, &ray);
            assert_eq!(refitted.closest(scene, &ray), expected, "{ray:?}");
            assert_eq!(refitted.any(scene, &ray), expected.is_some(), "{ray:?}");
            hits += u32::from(expected.is_some());
        }
    }
    hits
}

#[test]
fn refitted_trees_answer_as_new_ones() {
    let mut random = Random(11);
    let mut scene = scene(&mut random);
    let mut trees = Trees::build(&scene).expect("valid");
    for step in 0..6 {
        for shape in &mut scene.shapes {
            for position in &mut shape.positions {
                *position += 0.2 * random.vector();
            }
            for radius in &mut shape.radii {
                *radius = SIZE * (0.05 + 0.3 * random.unit());
            }
        }
        // Alternate between a frame that prevents sharing a tree and one that allows it.
        let count = scene.instances.len();
        let moved = Affine3A::from_translation(0.3 * random.vector());
        scene.instances[count - 2].world_from_object =
            if step % 3 == 0 { moved } else { Affine3A::IDENTITY };
        scene.instances[1].world_from_object.translation.x += 0.1;
        trees.refit(&scene).expect("only vertices and frames moved");
        let hits = compare(&mut random, &mut scene, &trees);
        assert!(hits > 1000, "{hits}");
    }
}

#[test]
fn elements_with_infinite_bounds_leave_and_enter_the_trees() {
    let mut random = Random(12);
    let mut scene = scene(&mut random);
    let mut trees = Trees::build(&scene).expect("valid");
    let kept = scene.shapes[0].radii[3];
    // The largest spheres have no finite bounds and are left out of trees.
    for radius in [f32::MAX, kept, 0.0, kept] {
        scene.shapes[0].radii[3] = radius;
        scene.shapes[0].positions[3].x = if radius == f32::MAX { f32::MAX } else { 0.5 };
        trees.refit(&scene).expect("the counts stay");
        compare(&mut random, &mut scene, &trees);
    }
}

#[test]
fn a_refused_refit_names_the_reason_and_leaves_the_trees_unchanged() {
    type Change = fn(&mut Scene);
    let table: &[(Change, &str)] = &[
        (
            |s| s.shapes[0].elements = Elements::Points(39),
            "shapes[0]: has 39 elements, but the trees were built from 40: build new trees",
        ),
        (
            |s| s.shapes.push(Shape::default()),
            "the scene has 5 shapes, but the trees were built from 4: build new trees",
        ),
        (
            |s| drop(s.instances.pop()),
            "the scene has 13 instances, but the trees were built from 14: build new trees",
        ),
        (
            |s| s.shapes[1].positions[7] = Vec3::NAN,
            "shapes[1]: positions[7] is (NaN, NaN, NaN), expected finite numbers",
        ),
        (|s| s.instances[4].shape = 4, "instances[4]: shape is 4, but the scene has 4 shapes"),
    ];
    let mut random = Random(13);
    let mut scene = scene(&mut random);
    let mut trees = Trees::build(&scene).expect("valid");
    for (change, expected) in table {
        let mut changed = scene.clone();
        changed.shapes[0].positions[0].y += 5.0;
        change(&mut changed);
        let error = trees.refit(&changed).expect_err(expected);
        assert_eq!(error.to_string(), *expected);
    }
    compare(&mut random, &mut scene, &trees);
    let mut fewer = scene.clone();
    fewer.shapes.truncate(3);
    fewer.instances.retain(|instance| instance.shape < 3);
    let error = trees.refit(&fewer).expect_err("a shape is gone");
    assert!(
        matches!(error, SceneError::Changed { what: "shapes", before: 4, now: 3, .. }),
        "{error}"
    );
}

#[test]
fn a_hundred_thousand_capsules_are_picked_after_they_moved() {
    let count = 100_000_u32;
    let grid = |i: u32| Vec3::new((i % 400) as f32, (i / 400) as f32, 0.0);
    let ends = |offset: Vec3| -> Vec<Vec3> {
        (0..count).flat_map(|i| [grid(i) + offset, grid(i) + offset + 0.5 * Vec3::X]).collect()
    };
    let radii = [0.2, 0.1].repeat(count as usize);
    let lines: Vec<_> = (0..count).map(|i| [2 * i, 2 * i + 1]).collect();
    let mut scene = Scene::default();
    scene.add(Shape::lines(ends(Vec3::ZERO), radii, lines), Material::default());
    let mut trees = Trees::build(&scene).expect("valid");
    let pick = |trees: &Trees, scene: &Scene, at: Vec3| {
        let hit = trees.closest(scene, &Ray::new(at + 9.0 * Vec3::Z, Vec3::NEG_Z));
        hit.map(|hit| hit.element)
    };
    let offset = Vec3::new(1000.0, -50.0, 2.0);
    scene.shapes[0].positions = ends(offset);
    trees.refit(&scene).expect("all capsules are there");
    for i in (0..count).step_by(997) {
        assert_eq!(pick(&trees, &scene, grid(i) + offset + 0.25 * Vec3::X), Some(i));
        assert_eq!(pick(&trees, &scene, grid(i) + offset + 0.75 * Vec3::X), None, "beside {i}");
    }
}
