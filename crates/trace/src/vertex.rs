//! Scattering at a surface as it looks from both ends of a path.

use crate::{Bsdf, Receiver};
use glam::Vec3;
use rotund_scene::{ElementKind, MaterialKind, MaterialPoint, Method, Scene, SceneHit};

/// Returns the shading normal, or for walls of solids the geometric normal where the two face
/// different sides. At the silhouette of a mesh an interpolated normal can face away from the
/// viewer, and a path that enters the solid would be taken for one that leaves it.
pub(crate) fn shading_normal(
    scene: &Scene,
    hit: &SceneHit,
    kind: MaterialKind,
    outgoing: Vec3,
) -> Vec3 {
    let normal = scene.shading_normal(hit, outgoing);
    let turned = normal.dot(outgoing) * hit.normal.dot(outgoing) < 0.0;
    if kind == MaterialKind::Refractive && turned { hit.normal } else { normal }
}

/// True if shading normal and geometric normal agree whether light is reflected or transmitted.
/// Where the wall of a solid reflects by one and transmits by the other, a path would lose track of
/// the solids that it is in.
///
/// Opaque surfaces skip this test: there the shading normal alone decides, as in most renderers,
/// and a direction below the geometric surface meets the inside of a closed mesh, which is dark.
pub(crate) fn sides_agree(hit: &SceneHit, normal: Vec3, outgoing: Vec3, incoming: Vec3) -> bool {
    let shading = normal.dot(outgoing) * normal.dot(incoming) > 0.0;
    let geometric = hit.normal.dot(outgoing) * hit.normal.dot(incoming) > 0.0;
    shading == geometric
}

/// A point where a path scatters.
#[derive(Clone, Copy)]
pub(crate) struct Vertex<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) hit: &'a SceneHit,
    pub(crate) material: &'a MaterialPoint,
}

/// Cosine of the angle between the shading normals of two viewers, above which they are the same.
const SAME: f32 = 1.0 - 1e-5;

impl Vertex<'_> {
    /// Returns the BSDF for light that leaves to `outgoing`, and the shading normal.
    pub(crate) fn bsdf(&self, outgoing: Vec3) -> (Bsdf, Vec3) {
        let normal = self.shading_normal(outgoing);
        (Bsdf::new(self.material, normal, outgoing), normal)
    }

    /// Returns the shading normal for a viewer in the direction `outgoing`.
    pub(crate) fn shading_normal(&self, outgoing: Vec3) -> Vec3 {
        shading_normal(self.scene, self.hit, self.material.kind, outgoing)
    }

    /// Returns the point that lights are sampled for, by the shading normal of its viewer.
    pub(crate) fn receiver(&self, normal: Vec3) -> Receiver {
        let both_sides = [MaterialKind::Refractive, MaterialKind::Transparent];
        let one_side = !both_sides.contains(&self.material.kind);
        Receiver { position: self.hit.position, normal: one_side.then_some(normal) }
    }

    /// Returns the absolute cosine between a direction and the geometric normal.
    pub(crate) fn slant(&self, direction: Vec3) -> f32 {
        self.hit.normal.dot(direction).abs()
    }

    /// True if a path that scatters by this normal keeps track of the solids that it is in.
    pub(crate) fn allows(&self, normal: Vec3, outgoing: Vec3, incoming: Vec3) -> bool {
        self.material.kind != MaterialKind::Refractive
            || sides_agree(self.hit, normal, outgoing, incoming)
    }

    /// True if the surface is the same for all rays; vanilla points and lines face each ray.
    pub(crate) fn is_fixed(&self) -> bool {
        let instance = &self.scene.instances[self.hit.instance as usize];
        let shape = &self.scene.shapes[instance.shape as usize];
        let round = [ElementKind::Points, ElementKind::Lines].contains(&shape.elements.kind());
        !(round && shape.method == Method::Vanilla)
    }

    /// Returns the density of scattering from the light to the camera over that from the camera to
    /// the light, each per area that the vertex beyond shows to this one; `None` if a path in one
    /// of the directions cannot be one in the other.
    ///
    /// At a smooth surface both are delta functions, whose ratio counts as 1. Weights of multiple
    /// importance sampling need not be optimal, but those of all techniques must agree.
    pub(crate) fn reversal(&self, to_camera: Vec3, to_light: Vec3) -> Option<f32> {
        if !self.is_fixed() {
            return None;
        }
        let (forwards, of_camera) = self.bsdf(to_camera);
        let (backwards, of_light) = self.bsdf(to_light);
        if forwards.is_delta() {
            return (of_camera.dot(of_light).abs() > SAME).then_some(1.0);
        }
        let ratio = backwards.eval(to_camera).pdf / forwards.eval(to_light).pdf;
        let ratio = ratio * self.slant(to_light) / self.slant(to_camera);
        ratio.is_finite().then_some(ratio)
    }
}
