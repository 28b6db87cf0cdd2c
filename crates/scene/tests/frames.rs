//! Instances with frames of every kind.

mod support;

use rotund_geometry::{
    Ray,
    glam::{Affine3A, Vec3},
};
use rotund_scene::{MaterialKind, Method, Route, Scene, SceneHit, Trees};
use support::{Random, frames, ray_at, scene_of, shapes};

/// Size of elements.
const SIZE: f32 = 0.5;

/// Each kind of element under each method with each frame: a description, the frame, scene and
/// trees.
fn cases(count: u32) -> Vec<(String, Affine3A, Scene, Trees)> {
    let mut random = Random(7);
    let mut cases = Vec::new();
    for (why, frame) in frames() {
        for shape in shapes(&mut random, count, SIZE) {
            let mut scene = scene_of(shape, frame, MaterialKind::Matte);
            let trees = Trees::build(&scene).expect("the scene is valid");
            for method in [Method::Vanilla, Method::Enhanced] {
                // The same trees serve both methods.
                scene.shapes[0].method = method;
                let kind = scene.shapes[0].elements.kind();
                let name = format!("{why}, {kind:?}, {method:?}");
                cases.push((name, frame, scene.clone(), trees.clone()));
            }
        }
    }
    cases
}

fn is_ribbon(scene: &Scene) -> bool {
    use rotund_scene::ElementKind::{Lines, Points};
    let shape = &scene.shapes[0];
    shape.method == Method::Vanilla && matches!(shape.elements.kind(), Points | Lines)
}

#[test]
fn a_ray_spawned_on_a_convex_element_never_meets_it_again() {
    let mut random = Random(11);
    let mut left = 0;
    let routes = |(name, _, scene, trees): (String, Affine3A, Scene, Trees)| {
        [Route::Carried, Route::Rebuilt].map(|route| {
            (format!("{name}, {route:?}"), scene.clone(), trees.clone().with_route(route))
        })
    };
    for (name, scene, trees) in cases(1).into_iter().flat_map(routes) {
        let patch = matches!(scene.shapes[0].elements.kind(), rotund_scene::ElementKind::Quads);
        if patch {
            // A concave patch may be met again.
            continue;
        }
        for _ in 0..400 {
            let ray = ray_at(&mut random, &scene, SIZE);
            let Some(hit) = trees.closest(&scene, &ray) else { continue };
            for _ in 0..10 {
                let direction = random.direction();
                let outside = hit.normal.dot(direction) > 1e-3;
                if !outside {
                    continue;
                }
                let next = hit.spawn(direction);
                let again = trees.closest(&scene, &next);
                assert!(
                    again.is_none(),
                    "{name}: {ray:?} hits {hit:?}, left by {next:?} to {again:?}"
                );
                assert!(!trees.any(&scene, &next), "{name}: any disagrees with closest");
                left += 1;
            }
        }
    }
    assert!(left > 60_000, "only {left} rays left a surface");
}

#[test]
fn a_ray_that_enters_a_round_solid_leaves_it_at_the_far_side() {
    let mut random = Random(13);
    let mut crossed = 0;
    for (name, _, scene, trees) in cases(1) {
        let kind = scene.shapes[0].elements.kind();
        use rotund_scene::ElementKind::{Lines, Points};
        if scene.shapes[0].method == Method::Vanilla || !matches!(kind, Points | Lines) {
            continue;
        }
        for _ in 0..400 {
            let ray = ray_at(&mut random, &scene, SIZE);
            let Some(hit) = trees.closest(&scene, &ray) else { continue };
            assert!(hit.normal.dot(ray.direction) < 0.0, "{name}: enters from outside");
            let steep = hit.normal.dot(ray.direction.normalize());
            if steep > -0.05 {
                continue;
            }
            let exit = trees.closest(&scene, &hit.spawn(ray.direction));
            let exit = exit.unwrap_or_else(|| panic!("{name}: no way out after {hit:?}"));
            assert!(exit.normal.dot(ray.direction) > 0.0, "{name}: {hit:?} then {exit:?}");
            crossed += 1;
        }
    }
    assert!(crossed > 2_000, "only {crossed} rays crossed a solid");
}

/// Bound on the distance of a point rebuilt from `uv` from the hit beyond the error of the hit, per
/// unit of the size of the element in the world and of its distance from the origin, since `uv` and
/// the transform are rounded. The documentation of the crate states it.
const ROUND_TRIP: f32 = 2.0 * f32::EPSILON;

/// Bound on the angle between the normals in radians. The worst is 1.1e-5, on a cone that a frame
/// flattens fifty-fold; without a frame it is 1e-6.
const NORMAL_ROUND_TRIP: f64 = 2e-5;

#[test]
fn position_and_normal_rebuilt_from_uv_are_those_of_the_hit() {
    let mut compared = 0;
    for (i, case) in cases(100).iter().enumerate() {
        compared += round_trip(i, case);
    }
    assert!(compared > 1_000_000, "only {compared} hits");
}

/// Compares carried and rebuilt hits; returns their number.
fn round_trip(seed: usize, (name, frame, scene, trees): &(String, Affine3A, Scene, Trees)) -> u32 {
    let mut random = Random(17 + seed as u64);
    let mut compared = 0;
    let matrix = frame.matrix3;
    let size = matrix.x_axis.length().max(matrix.y_axis.length()).max(matrix.z_axis.length());
    for _ in 0..25_000 {
        let ray = ray_at(&mut random, scene, SIZE);
        let Some(hit) = trees.closest(scene, &ray) else { continue };
        compared += 1;
        let SceneHit { instance, element, uv, .. } = hit;
        let position = scene.eval_position(instance, element, uv);
        let bound = hit.error + ROUND_TRIP * (size + hit.position.length());
        let distance = position.distance(hit.position);
        assert!(distance <= bound, "{name}: {distance} > {bound} apart: {hit:?}");
        if !is_ribbon(scene) {
            let normal = scene.eval_normal(instance, element, uv).as_dvec3();
            let carried = hit.normal.as_dvec3();
            let angle = normal.cross(carried).length().atan2(normal.dot(carried));
            assert!(angle <= NORMAL_ROUND_TRIP, "{name}: normals {angle} apart: {hit:?}");
        }
    }
    compared
}

#[test]
fn a_rebuilt_hit_has_the_position_and_normal_of_its_uv() {
    let mut random = Random(31);
    for (name, _, scene, trees) in cases(20) {
        let rebuilt = trees.clone().with_route(Route::Rebuilt);
        for _ in 0..100 {
            let ray = ray_at(&mut random, &scene, SIZE);
            let (carried, hit) = (trees.closest(&scene, &ray), rebuilt.closest(&scene, &ray));
            let Some((carried, hit)) = carried.zip(hit) else {
                assert_eq!(carried, hit, "{name}: both miss");
                continue;
            };
            let SceneHit { instance, element, uv, t, .. } = hit;
            assert_eq!(
                (instance, element, uv, t),
                (carried.instance, carried.element, carried.uv, carried.t)
            );
            if is_ribbon(&scene) {
                assert_eq!(hit, carried, "{name}: only the ray knows");
            } else {
                assert_eq!(hit.position, scene.eval_position(instance, element, uv), "{name}");
                assert_eq!(hit.normal, scene.eval_normal(instance, element, uv), "{name}");
                assert!(hit.position.distance(carried.position) <= hit.error, "{name}: {hit:?}");
            }
        }
    }
}

#[test]
fn t_counts_in_the_direction_given_whatever_the_frame() {
    let mut random = Random(19);
    for (name, _, scene, trees) in cases(20) {
        if is_ribbon(&scene) {
            continue;
        }
        for _ in 0..100 {
            let ray = ray_at(&mut random, &scene, SIZE);
            let Some(hit) = trees.closest(&scene, &ray) else { continue };
            let bound =
                hit.error + 64.0 * f32::EPSILON * (ray.origin.length() + hit.position.length());
            // At grazing rays `t` is less accurate than the position.
            let cosine = hit.normal.dot(ray.direction.normalize()).abs();
            let distance = ray.at(hit.t).distance(hit.position);
            assert!(distance * cosine.max(0.01) <= 4.0 * bound, "{name}: {distance}, {hit:?}");
            let double = Ray { direction: 2.0 * ray.direction, ..ray };
            let twice = trees.closest(&scene, &double).map(|hit| 2.0 * hit.t);
            assert_eq!(twice, Some(hit.t), "{name}: a direction twice as long");
        }
    }
}

#[test]
fn a_mirror_does_not_turn_normals_inwards() {
    let mut random = Random(23);
    let shape = shapes(&mut random, 1, 0.5).swap_remove(0);
    let center = shape.positions[0];
    for (why, frame) in frames() {
        let scene = scene_of(shape.clone(), frame, MaterialKind::Matte);
        let trees = Trees::build(&scene).expect("the scene is valid");
        let origin = frame.transform_point3(center + Vec3::new(3.0, 2.0, 1.0));
        let inside = frame.transform_point3(center);
        let hit = trees.closest(&scene, &Ray::new(origin, inside - origin)).expect("aimed at it");
        assert!(hit.normal.dot(hit.position - inside) > 0.0, "{why}: {hit:?}");
        assert!((hit.normal.length() - 1.0).abs() < 1e-6, "{why}: unit length");
    }
}

#[test]
fn an_identity_frame_adds_no_error() {
    let mut random = Random(29);
    let shape = shapes(&mut random, 1, 0.5).swap_remove(0);
    let ray = Ray::new(shape.positions[0] + 3.0 * Vec3::X, Vec3::NEG_X);
    let alone = rotund_geometry::Sphere { center: shape.positions[0], radius: shape.radii[0] };
    let error = alone.closest(&ray).expect("aimed at it").error;
    let scene = scene_of(shape, Affine3A::IDENTITY, MaterialKind::Matte);
    let hit = Trees::build(&scene)
        .expect("the scene is valid")
        .closest(&scene, &ray)
        .expect("aimed at it");
    assert_eq!(hit.error, error);
}
