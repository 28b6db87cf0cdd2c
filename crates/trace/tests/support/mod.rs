//! Materials, scenes and statistics that several tests share.

#![allow(dead_code, reason = "each test uses its part")]

use glam::{Affine3A, Vec2, Vec3};
use rotund_scene::{
    Camera, Elements, Environment, Instance, Material, MaterialKind, MaterialPoint, Scene, Shape,
};
use rotund_trace::{Sampler, Sequence};

/// Returns a white, opaque surface that does not emit.
pub(crate) fn white(kind: MaterialKind, alpha: f32) -> MaterialPoint {
    MaterialPoint {
        kind,
        emission: Vec3::ZERO,
        color: Vec3::ONE,
        opacity: 1.0,
        alpha,
        ior: 1.5,
        extinction: Vec3::ZERO,
        albedo: Vec3::ZERO,
        anisotropy: 0.0,
    }
}

/// Returns the direction of unit length with this cosine to +z and this azimuth.
pub(crate) fn direction(cosine: f32, azimuth: f32) -> Vec3 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine)
}

/// Returns the `index`-th random numbers: one for the lobe, two for the direction.
pub(crate) fn numbers(sequence: Sequence, seed: u64, index: u32) -> (f32, Vec2) {
    let [x, y, choice, _] = Sampler::new(sequence, seed, 0, 0, index).set(0);
    (choice, Vec2::new(x, y))
}

/// Returns the value that chi-squared with this many degrees of freedom exceeds with probability
/// 3e-5.
///
/// Source: E. Wilson, M. Hilferty, "The distribution of chi-square", PNAS 17(12), 1931.
pub(crate) fn chi_squared_limit(freedom: usize) -> f64 {
    let k = 2.0 / (9.0 * freedom as f64);
    freedom as f64 * (1.0 - k + 4.0 * k.sqrt()).powi(3)
}

/// Returns a shape of elements, positions and radii only.
pub(crate) fn shape(elements: Elements, positions: Vec<Vec3>, radii: Vec<f32>) -> Shape {
    Shape { elements, positions, radii, ..Shape::default() }
}

/// Returns a quad of four corners, in order around it.
pub(crate) fn quad(corners: [[f32; 3]; 4]) -> Shape {
    let positions = corners.map(Vec3::from_array).to_vec();
    shape(Elements::Quads(vec![[0, 1, 2, 3]]), positions, Vec::new())
}

/// Returns a ball.
pub(crate) fn ball(center: [f32; 3], radius: f32) -> Shape {
    shape(Elements::Points(1), vec![Vec3::from_array(center)], vec![radius])
}

/// A scene of shapes, each with its own material, under a constant sky, before a camera that stands
/// at `z = 4` and looks at the origin.
pub(crate) fn scene(parts: Vec<(Shape, Material)>, sky: Vec3) -> Scene {
    let camera = Camera {
        world_from_camera: Affine3A::from_translation(Vec3::new(0.0, 0.0, 4.0)),
        ..Camera::default()
    };
    let environment = Environment {
        name: String::new(),
        world_from_environment: Affine3A::IDENTITY,
        emission: sky,
        emission_tex: None,
    };
    let mut scene =
        Scene { cameras: vec![camera], environments: vec![environment], ..Scene::default() };
    for (index, (shape, material)) in (0..).zip(parts) {
        scene.shapes.push(shape);
        scene.materials.push(material);
        scene.instances.push(Instance {
            name: String::new(),
            world_from_object: Affine3A::IDENTITY,
            shape: index,
            material: index,
        });
    }
    scene
}

/// All that a path can meet: a glass ball with color inside, a rough metal tube, a sheet that is
/// half there, a glossy floor, a light.
pub(crate) fn glass_over_a_floor() -> Scene {
    let material = |kind, color: [f32; 3], roughness| Material {
        kind,
        color: Vec3::from_array(color),
        roughness,
        ..Material::default()
    };
    let tube = shape(
        Elements::Lines(vec![[0, 1]]),
        vec![Vec3::new(-1.0, -0.4, 0.0), Vec3::new(-0.5, 0.8, -0.5)],
        vec![0.3, 0.1],
    );
    let floor = quad([[-3.0, -0.7, 3.0], [3.0, -0.7, 3.0], [3.0, -0.6, -3.0], [-3.0, -0.7, -3.0]]);
    let sheet = quad([[0.2, -0.5, 1.0], [1.2, -0.5, 1.0], [1.2, 0.5, 1.0], [0.2, 0.5, 1.0]]);
    let light = quad([[-0.5, 2.0, -0.5], [0.5, 2.0, -0.5], [0.5, 2.0, 0.5], [-0.5, 2.0, 0.5]]);
    let shine = Material { emission: Vec3::splat(10.0), ..Material::default() };
    let half = Material { opacity: 0.5, ..material(MaterialKind::Matte, [0.2, 0.3, 0.9], 0.0) };
    scene(
        vec![
            (ball([0.6, 0.0, 0.0], 0.6), material(MaterialKind::Refractive, [0.9, 0.5, 0.4], 0.0)),
            (tube, material(MaterialKind::Reflective, [0.9, 0.6, 0.4], 0.3)),
            (sheet, half),
            (floor, material(MaterialKind::Glossy, [0.6, 0.6, 0.6], 0.2)),
            (light, shine),
        ],
        Vec3::new(0.2, 0.3, 0.4),
    )
}
