//! The film of a camera, as light from the scene finds it.

use glam::{Affine3A, Vec2, Vec3};
use rotund_scene::Camera;

/// The film of a camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sensor {
    camera_from_world: Affine3A,
    world_from_camera: Affine3A,
    /// Size of the picture at distance 1 from the lens; of an orthographic camera, at any distance.
    size: Vec2,
    orthographic: bool,
    focus: f32,
    lens_radius: f32,
}

/// A point as a camera sees it through a point of its lens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// Place in the picture, `0.0..1.0`; v runs down.
    pub(crate) image_uv: Vec2,
    /// The start of the camera ray.
    pub(crate) lens: Vec3,
    /// Unit direction from the point to it.
    pub(crate) direction: Vec3,
    /// Density of the point among those that camera rays of the whole picture reach, per area
    /// across the ray.
    pub(crate) density: f32,
}

impl Sensor {
    pub(crate) fn new(camera: &Camera) -> Self {
        let film = if camera.aspect >= 1.0 {
            Vec2::new(camera.film, camera.film / camera.aspect)
        } else {
            Vec2::new(camera.film * camera.aspect, camera.film)
        };
        Self {
            camera_from_world: camera.world_from_camera.inverse(),
            world_from_camera: camera.world_from_camera,
            size: film / camera.lens,
            orthographic: camera.orthographic,
            focus: camera.focus,
            lens_radius: 0.5 * camera.aperture,
        }
    }

    /// Returns how the camera sees a point, if it does. `lens_uv` is a point of the unit disk.
    pub(crate) fn see(&self, point: Vec3, lens_uv: Vec2) -> Option<Seen> {
        let place = self.camera_from_world.transform_point3(point);
        if place.z >= 0.0 {
            return None;
        }
        let on_lens = self.lens_radius * lens_uv;
        // Where the line from the lens to the point meets the plane in focus.
        let (focused, start) = if self.orthographic {
            let share = -place.z / self.focus;
            let across = place.truncate() - (1.0 - share) * on_lens;
            (across, across + on_lens)
        } else {
            let across = on_lens + (place.truncate() - on_lens) * (self.focus / -place.z);
            (across / self.focus, on_lens)
        };
        let image_uv = Vec2::new(0.5, 0.5) + Vec2::new(1.0, -1.0) * focused / self.size;
        let inside = image_uv.cmpge(Vec2::ZERO).all() && image_uv.cmplt(Vec2::ONE).all();
        let lens = self.world_from_camera.transform_point3(start.extend(0.0));
        let direction = (lens - point).try_normalize()?;
        let density = self.density(lens, point);
        let seen = Seen { image_uv, lens, direction, density };
        (inside && density.is_finite()).then_some(seen)
    }

    /// Returns the density of a point on a camera ray that starts at `lens`; see [`Seen::density`].
    pub(crate) fn density(&self, lens: Vec3, point: Vec3) -> f32 {
        let to = point - lens;
        let distance2 = to.length_squared();
        let cosine = to.dot((-self.world_from_camera.matrix3.z_axis).into()) / distance2.sqrt();
        let area = self.size.x * self.size.y;
        if self.orthographic {
            1.0 / (area * cosine)
        } else {
            1.0 / (area * cosine * cosine * cosine * distance2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_seen_where_the_rays_of_the_camera_go() {
        let pinhole = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 0.5, 0.0), Vec3::Y);
        let lens = Camera { aperture: 0.3, aspect: 0.7, ..pinhole.clone() };
        let parallel = pinhole.clone().orthographic(2.0);
        let thick = Camera { aperture: 0.2, ..parallel.clone() };
        for camera in [pinhole, lens, parallel, thick] {
            let sensor = Sensor::new(&camera);
            for (u, v) in [(0.1, 0.2), (0.5, 0.5), (0.9, 0.3)] {
                for lens_uv in [Vec2::ZERO, Vec2::new(0.3, -0.8)] {
                    let ray = camera.ray(Vec2::new(u, v), lens_uv);
                    let point = ray.at(2.5);
                    let seen = sensor.see(point, lens_uv).expect("it is in the picture");
                    assert!(seen.image_uv.abs_diff_eq(Vec2::new(u, v), 1e-5), "{seen:?}");
                    assert!(seen.lens.abs_diff_eq(ray.origin, 1e-5), "{seen:?}");
                    assert!(seen.direction.abs_diff_eq(-ray.direction, 1e-5), "{seen:?}");
                    // The area across the ray that a small part of the picture covers.
                    let step = 1e-3;
                    let at = |du: f32, dv: f32| {
                        let ray = camera.ray(Vec2::new(u + du, v + dv), lens_uv);
                        let normal = seen.direction;
                        let t = (point - ray.origin).dot(normal) / ray.direction.dot(normal);
                        ray.at(t)
                    };
                    let (a, b) = (at(step, 0.0) - at(-step, 0.0), at(0.0, step) - at(0.0, -step));
                    let expected = 4.0 * step * step / a.cross(b).length();
                    assert!((seen.density / expected - 1.0).abs() < 1e-2, "{seen:?}, {expected}");
                }
            }
            assert!(
                sensor.see(camera.ray(Vec2::splat(0.5), Vec2::ZERO).at(-1.0), Vec2::ZERO).is_none()
            );
        }
    }
}
