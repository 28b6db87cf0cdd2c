//! Boxes around scenes and instances.

use rotund_geometry::Aabb;
use rotund_scene::{Instance, Scene};

/// Returns a box around all instances.
pub(crate) fn scene_bounds(scene: &Scene) -> Aabb {
    let of_instance = |instance| instance_bounds(scene, instance);
    scene.instances.iter().map(of_instance).fold(Aabb::EMPTY, Aabb::union)
}

/// Returns a box around an instance.
pub(crate) fn instance_bounds(scene: &Scene, instance: &Instance) -> Aabb {
    let shape = &scene.shapes[instance.shape as usize];
    let frame = &instance.world_from_object;
    let stretch = frame.matrix3.x_axis.length().max(frame.matrix3.y_axis.length());
    let stretch = stretch.max(frame.matrix3.z_axis.length());
    let radius = stretch * shape.radii.iter().copied().fold(0.0, f32::max);
    let points = shape.positions.iter().map(|&p| frame.transform_point3(p));
    let Aabb { min, max } = Aabb::from_points(points);
    Aabb { min: min - radius, max: max + radius }
}
