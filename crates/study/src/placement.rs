//! Scenes moved away from the origin, or modelled in other units.

use glam::{Affine3A, DAffine3, DVec3};
use rotund_scene::Scene;

/// Returns the scene scaled by `scale` in its own data (vertices, radii, frames, cameras and the
/// depths inside materials), then moved by `offset` meters along each axis.
///
/// Frames are composed in `f64` and rounded once. A camera sees the same picture, but for rounding.
pub fn placed(scene: &Scene, scale: f64, offset: f64) -> Scene {
    let mut scene = scene.clone();
    let factor = scale as f32;
    for shape in &mut scene.shapes {
        shape.positions.iter_mut().for_each(|position| *position *= factor);
        shape.radii.iter_mut().for_each(|radius| *radius *= factor);
    }
    let frame = |frame: Affine3A| {
        let frame = frame.as_daffine3();
        let translation = DVec3::splat(offset) + scale * frame.translation;
        DAffine3 { translation, ..frame }.as_affine3a()
    };
    for instance in &mut scene.instances {
        instance.world_from_object = frame(instance.world_from_object);
    }
    for camera in &mut scene.cameras {
        camera.world_from_camera = frame(camera.world_from_camera);
        camera.focus *= factor;
        camera.aperture *= factor;
        if camera.orthographic {
            camera.film *= factor;
        }
    }
    scene.materials.iter_mut().for_each(|material| material.trdepth *= factor);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rotund_scene::{Camera, Material};

    #[test]
    fn everything_with_a_length_is_scaled_and_frames_carry_the_offset() {
        let camera = Camera { aperture: 0.1, focus: 2.0, ..Camera::default() };
        let material = Material { trdepth: 0.5, ..Material::default() };
        let scene = Scene { cameras: vec![camera], materials: vec![material], ..Scene::default() };
        let placed = placed(&scene, 10.0, 3.0);
        let camera = &placed.cameras[0];
        assert_eq!(Vec3::from(camera.world_from_camera.translation), Vec3::splat(3.0));
        assert_eq!((camera.aperture, camera.focus, camera.film), (1.0, 20.0, 0.036));
        assert_eq!(placed.materials[0].trdepth, 5.0);
    }
}
