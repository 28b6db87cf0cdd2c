//! Shapes of a scene that their files made into several, or that are far from the origin.

use super::{assets::LoadedShape, format::SceneFile};
use crate::Scene;
use glam::DVec3;

/// Adds the shapes to the scene, which has all instances. Shapes beyond the first of a file stand
/// behind all others, with an instance for each instance of the first. Instances of a shape far
/// from the origin have its offset in their frames.
pub(super) fn shapes(scene: &mut Scene, file: &SceneFile, loaded: Vec<LoadedShape>) {
    for (instance, (_, described)) in scene.instances.iter_mut().zip(&file.instances.items) {
        let offset = loaded[instance.shape as usize].offset;
        if offset != DVec3::ZERO {
            let frame = described.lookat.map_or(described.frame.0, |l| l.frame().as_daffine3());
            // Rounded once, and exact if the frame is the identity.
            let origin = frame.transform_point3(offset);
            instance.world_from_object.translation = origin.as_vec3().into();
        }
    }
    let mut more = Vec::new();
    for (index, shape) in (0..).zip(loaded) {
        let mut shapes = shape.shapes.into_iter();
        scene.shapes.extend(shapes.next());
        more.extend(shapes.map(|shape| (index, shape)));
    }
    let count = scene.instances.len();
    for (first, shape) in more {
        let of_it = scene.shapes.len() as u32;
        scene.shapes.push(shape);
        for i in 0..count {
            if scene.instances[i].shape == first {
                let instance = scene.instances[i].clone();
                scene.instances.push(crate::Instance { shape: of_it, ..instance });
            }
        }
    }
}
