//! Cameras.

use glam::Affine3A;

/// A thin-lens camera at the origin of its frame, looking along its -z axis.
#[derive(Clone, Debug)]
pub struct Camera {
    /// How the command line picks it.
    pub name: String,
    /// A rigid frame.
    pub world_from_camera: Affine3A,
    /// Parallel rays, the film scaled by `1 / lens`.
    pub orthographic: bool,
    /// Focal length in meters.
    pub lens: f32,
    /// Longer side of the film in meters.
    pub film: f32,
    /// Width over height.
    pub aspect: f32,
    /// Distance of the plane in focus, in meters.
    pub focus: f32,
    /// Diameter of the lens in meters; zero is a pinhole.
    pub aperture: f32,
}
