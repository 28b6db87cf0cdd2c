//! The instances whose elements are one body into which one can see.

use crate::{ElementKind, Instance, MaterialKind, Overlap, Scene};

/// The instances of a scene whose elements are one body into which one can see.
#[derive(Clone, Debug)]
pub(crate) struct Unions {
    /// For each material, whether a surface of it hides what is behind.
    hiding: Vec<bool>,
    /// For each shape, whether it can be one body, and whether its vertices are opaque.
    shapes: Vec<(bool, bool)>,
}

impl Unions {
    pub(crate) fn new(scene: &Scene) -> Self {
        let hides = |index: u32| {
            let kind = scene.materials[index as usize].kind;
            let through =
                [MaterialKind::Transparent, MaterialKind::Refractive, MaterialKind::Volumetric];
            !through.contains(&kind) && scene.material_is_opaque(index)
        };
        let shapes = scene.shapes.iter().map(|shape| {
            let round = [ElementKind::Points, ElementKind::Lines].contains(&shape.elements.kind());
            let is_body = round && shape.overlap == Overlap::Union && shape.elements.count() > 1;
            (is_body, !is_body || shape.colors.iter().all(|color| color.w >= 1.0))
        });
        Self {
            hiding: (0..scene.materials.len() as u32).map(hides).collect(),
            shapes: shapes.collect(),
        }
    }

    pub(crate) fn contain(&self, instance: &Instance) -> bool {
        let (is_body, opaque) = self.shapes[instance.shape as usize];
        is_body && !(opaque && self.hiding[instance.material as usize])
    }
}
