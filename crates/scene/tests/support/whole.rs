//! Invariants of every scene that loads.

use rotund_geometry::{
    Ray,
    glam::{Vec2, Vec3},
};
use rotund_scene::{Elements, Method, Scene, Trees};

/// Checks that the scene is valid, and that ray queries and evaluation return finite results.
///
/// # Panics
///
/// If that is not the case.
pub(crate) fn check(scene: &Scene) {
    assert_eq!(scene.validate(), Ok(()));
    let mut size = 0;
    for shape in &scene.shapes {
        let count = shape.positions.len();
        let in_range = |vertices: &[u32]| vertices.iter().all(|&v| (v as usize) < count);
        assert!(
            match &shape.elements {
                Elements::Points(points) => *points as usize == count,
                Elements::Lines(lines) => in_range(lines.as_flattened()),
                Elements::Triangles(triangles) => in_range(triangles.as_flattened()),
                Elements::Quads(quads) => in_range(quads.as_flattened()),
            },
            "elements name existing vertices"
        );
        for length in [shape.normals.len(), shape.texcoords.len(), shape.colors.len()] {
            assert!(length == 0 || length == count, "{length} values at {count} vertices");
        }
        assert!(shape.positions.iter().all(|p| p.is_finite()), "positions are finite");
        assert!(shape.radii.iter().all(|&r| r.is_finite() && r >= 0.0), "radii are lengths");
        size += shape.elements.count();
    }
    // Larger scenes would only be slower.
    if size > 4096 {
        return;
    }
    let mut scene = scene.clone();
    let trees = Trees::build(&scene).expect("the scene is valid");
    for method in [Method::Enhanced, Method::Vanilla] {
        scene.shapes.iter_mut().for_each(|shape| shape.method = method);
        for instance in 0..scene.instances.len().min(16) {
            check_instance(&scene, &trees, instance);
        }
    }
}

fn check_instance(scene: &Scene, trees: &Trees, instance: usize) {
    let placed = &scene.instances[instance];
    let shape = &scene.shapes[placed.shape as usize];
    let uvs = [Vec2::ZERO, Vec2::splat(0.5), Vec2::new(1.0, 0.25), Vec2::ONE];
    for element in 0..shape.elements.count().min(16) as u32 {
        let instance = instance as u32;
        for uv in uvs {
            let normal = scene.eval_normal(instance, element, uv);
            assert!(!normal.is_nan(), "{normal} at element {element} {uv}");
            let point = scene.eval_material(instance, element, uv);
            assert!(!point.color.is_nan() && !point.opacity.is_nan(), "{point:?}");
            let (by_u, by_v) = scene.eval_tangents(instance, element, uv);
            assert!(!by_u.is_nan() && !by_v.is_nan(), "{by_u}, {by_v}");
        }
        let target = scene.eval_position(instance, element, Vec2::splat(0.25));
        for from in [Vec3::ONE, Vec3::new(-2.0, 0.1, 3.0)] {
            let ray = Ray::new(from, target - from);
            let Some(hit) = trees.closest(scene, &ray) else { continue };
            assert!(trees.any(scene, &ray), "any disagrees with closest: {ray:?}, {hit:?}");
            let normal = scene.shading_normal(&hit, -ray.direction);
            assert!(normal.is_finite(), "{normal} at {hit:?}");
        }
    }
}
