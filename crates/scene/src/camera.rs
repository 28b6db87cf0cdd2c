//! Cameras.

use glam::{Affine3A, Mat3A, Vec2, Vec3};
use rotund_geometry::Ray;

/// A thin-lens camera at the origin of its frame, looking along its -z axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name by which a program selects the camera; may be empty.
    pub name: String,
    /// A rigid frame: right is +x, up is +y, and the view runs along -z.
    pub world_from_camera: Affine3A,
    /// Orthographic projection: the longer side shows `film / lens` meters.
    pub orthographic: bool,
    /// Focal length in meters.
    pub lens: f32,
    /// Longer side of the film in meters.
    pub film: f32,
    /// Width over height.
    pub aspect: f32,
    /// Distance to the plane in focus, in meters.
    pub focus: f32,
    /// Diameter of the lens in meters; zero for a pinhole.
    pub aperture: f32,
}

impl Default for Camera {
    /// A pinhole camera with a 50 mm lens on 35 mm film, at the origin.
    fn default() -> Self {
        Self {
            name: String::new(),
            world_from_camera: Affine3A::IDENTITY,
            orthographic: false,
            lens: 0.05,
            film: 0.036,
            aspect: 1.5,
            focus: 10_000.0,
            aperture: 0.0,
        }
    }
}

impl Camera {
    /// Creates the default camera at `eye`, looking at `target`, which is in focus. `up` points up
    /// in the picture and need not be orthogonal to the view.
    ///
    /// If `eye` equals `target`, or `up` is parallel to the view, the frame is not finite, which
    /// [`crate::Scene::validate`] reports.
    #[must_use]
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3) -> Self {
        let (world_from_camera, focus) = (look_at(eye, target, up), eye.distance(target));
        Self { world_from_camera, focus, ..Self::default() }
    }

    /// Returns this camera with parallel rays, the longer side of whose picture shows `width`
    /// meters: `Camera::look_at(eye, target, Vec3::Y).orthographic(2.0)`.
    #[must_use]
    pub fn orthographic(self, width: f32) -> Self {
        Self { orthographic: true, lens: 1.0, film: width, ..self }
    }

    /// Returns the ray through a point of the picture and a point of the lens, with unit direction.
    ///
    /// `image_uv` is `0.0..=1.0` over the picture: u runs right, v runs down. `lens_uv` is a point
    /// of the unit disk, and counts only if the aperture is not zero. The rays of all points of the
    /// lens meet in the plane in focus.
    #[must_use]
    pub fn ray(&self, image_uv: Vec2, lens_uv: Vec2) -> Ray {
        let film = if self.aspect >= 1.0 {
            Vec2::new(self.film, self.film / self.aspect)
        } else {
            Vec2::new(self.film * self.aspect, self.film)
        };
        let on_film = Vec2::new(image_uv.x - 0.5, 0.5 - image_uv.y) * film;
        let on_lens = (0.5 * self.aperture * lens_uv).extend(0.0);
        let (origin, focused) = if self.orthographic {
            let across = (on_film / self.lens).extend(0.0);
            (across + on_lens, across - self.focus * Vec3::Z)
        } else {
            (on_lens, self.focus * (on_film / self.lens).extend(-1.0))
        };
        Ray::new(
            self.world_from_camera.transform_point3(origin),
            self.world_from_camera.transform_vector3(focused - origin).normalize(),
        )
    }

    /// Returns width and height in pixels of a picture whose longer side is `longer_side`; neither
    /// is zero.
    #[must_use]
    pub fn resolution(&self, longer_side: u32) -> (u32, u32) {
        let longer_side = longer_side.max(1);
        // Pixel counts are far below 2^24, so these conversions are exact.
        let shorter = |ratio: f32| ((longer_side as f32 * ratio).round() as u32).max(1);
        if self.aspect >= 1.0 {
            (longer_side, shorter(1.0 / self.aspect))
        } else {
            (shorter(self.aspect), longer_side)
        }
    }
}

/// Returns the frame at `eye` whose -z axis points to `target`; not finite if there is none.
pub(crate) fn look_at(eye: Vec3, target: Vec3, up: Vec3) -> Affine3A {
    let z = (eye - target).normalize();
    let x = up.cross(z).normalize();
    let matrix3 = Mat3A::from_cols(x.into(), z.cross(x).into(), z.into());
    Affine3A { matrix3, translation: eye.into() }
}
