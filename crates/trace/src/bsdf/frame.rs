//! An orthonormal basis about a normal.

use glam::Vec3;

/// Local coordinates whose +z axis is a normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Frame {
    /// `normal` must have unit length.
    ///
    /// Source: T. Duff et al., "Building an Orthonormal Basis, Revisited", Journal of Computer
    /// Graphics Techniques 6(1), 2017.
    pub(crate) fn new(normal: Vec3) -> Self {
        let (x, y) = normal.any_orthonormal_pair();
        Self { x, y, z: normal }
    }

    pub(crate) fn local_from_world(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// Rotates a vector. Rounding may change the length of a direction by some 1e-6 along a path of
    /// a thousand mirrors.
    pub(crate) fn world_from_local(&self, v: Vec3) -> Vec3 {
        v.x * self.x + v.y * self.y + v.z * self.z
    }
}
