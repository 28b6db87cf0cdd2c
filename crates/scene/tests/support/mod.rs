//! Random shapes, frames of every kind, and seeded random numbers.

#![allow(dead_code, reason = "each test file uses a part of it")]

use rotund_geometry::{
    Ray,
    glam::{Affine3A, EulerRot, Mat3, Quat, Vec2, Vec3},
};
use rotund_scene::{Elements, Instance, Material, MaterialKind, Scene, Shape};

pub(crate) mod input;
pub(crate) mod whole;

/// The generator SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Returns a number in `0.0..1.0`.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    /// Returns a vector with coordinates in `-1.0..1.0`.
    pub(crate) fn vector(&mut self) -> Vec3 {
        2.0 * Vec3::new(self.unit(), self.unit(), self.unit()) - 1.0
    }

    pub(crate) fn uv(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if v.length_squared() > 0.01 && v.length_squared() < 1.0 {
                return v.normalize();
            }
        }
    }
}

/// Returns shapes with `count` random elements of each kind in `-1..1`, without other vertex data.
pub(crate) fn shapes(random: &mut Random, count: u32, size: f32) -> Vec<Shape> {
    let mut make = |vertices_each: u32, elements: Elements| {
        let mut positions = Vec::new();
        for _ in 0..count {
            let center = random.vector();
            for _ in 0..vertices_each {
                positions.push(center + size * random.vector());
            }
        }
        let radii = positions.iter().map(|_| size * (0.05 + 0.3 * random.unit())).collect();
        Shape { elements, positions, radii, ..Shape::default() }
    };
    vec![
        make(1, Elements::Points(count)),
        make(2, Elements::Lines((0..count).map(|i| [2 * i, 2 * i + 1]).collect())),
        make(3, Elements::Triangles((0..count).map(|i| [0, 1, 2].map(|k| 3 * i + k)).collect())),
        make(4, Elements::Quads((0..count).map(|i| [0, 1, 2, 3].map(|k| 4 * i + k)).collect())),
    ]
}

/// Returns a scene with one instance of a shape and a material of this kind.
pub(crate) fn scene_of(shape: Shape, frame: Affine3A, kind: MaterialKind) -> Scene {
    Scene {
        materials: vec![Material { kind, ..Material::default() }],
        shapes: vec![shape],
        instances: vec![Instance {
            name: String::new(),
            world_from_object: frame,
            shape: 0,
            material: 0,
        }],
        ..Scene::default()
    }
}

/// Returns frames of every kind with their descriptions.
pub(crate) fn frames() -> Vec<(&'static str, Affine3A)> {
    let turn = Quat::from_euler(EulerRot::XYZ, 0.3, 1.1, -0.7);
    let shear = Mat3::from_cols(
        Vec3::new(1.0, 0.2, 0.0),
        Vec3::new(0.8, 1.0, -0.3),
        Vec3::new(0.0, 0.5, 1.0),
    );
    let rotation = Affine3A::from_quat(turn);
    vec![
        ("identity", Affine3A::IDENTITY),
        ("translation", Affine3A::from_translation(Vec3::new(-0.4, 0.2, 3.0))),
        ("rotation", rotation),
        ("mirrored", Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)) * rotation),
        ("scaled alike", Affine3A::from_scale(Vec3::splat(37.0)) * rotation),
        ("small", Affine3A::from_scale(Vec3::splat(1e-3)) * rotation),
        ("scaled differently", rotation * Affine3A::from_scale(Vec3::new(0.1, 3.0, 1.0))),
        ("sheared", Affine3A::from_mat3(shear) * rotation),
        (
            "sheared, mirrored and moved",
            Affine3A::from_translation(Vec3::new(5.0, -7.0, 11.0))
                * Affine3A::from_mat3(shear)
                * Affine3A::from_scale(Vec3::new(1.0, -2.0, 0.5)),
        ),
        ("far away", Affine3A::from_translation(Vec3::new(1e4, -2e4, 3e4)) * rotation),
        ("flat", rotation.inverse() * Affine3A::from_scale(Vec3::new(1.0, 0.02, 1.0)) * rotation),
    ]
}

/// Returns a ray from outside towards a point near a random vertex of the first shape.
pub(crate) fn ray_at(random: &mut Random, scene: &Scene, size: f32) -> Ray {
    let frame = scene.instances[0].world_from_object;
    let positions = &scene.shapes[0].positions;
    let vertex = positions[(random.unit() * positions.len() as f32) as usize % positions.len()];
    let target = frame.transform_point3(vertex + 0.3 * size * random.vector());
    let origin = frame.transform_point3(4.0 * random.direction());
    Ray::new(origin, (target - origin) * (0.1 + random.unit()))
}
