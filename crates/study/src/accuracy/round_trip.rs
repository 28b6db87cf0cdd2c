//! `accuracy --round-trip COUNT`: do the parameters of a hit evaluate to the point of the hit?
//!
//! Random elements of every kind are placed by frames that rotate, scale, flatten, shear, mirror
//! and translate far. Rays are aimed at random parameters of random elements. Each hit is compared
//! with `eval_position` and `eval_normal` of its instance, element and `uv`, within the bounds that
//! the documentation of `rotund-scene` states. The command fails if a bound is exceeded.

use anyhow::{Result, ensure};
use glam::{Affine3A, EulerRot, Mat3, Quat, Vec2, Vec3};
use rayon::prelude::*;
use rotund_geometry::Ray;
use rotund_scene::{ElementKind, Elements, Instance, Material, Method, Scene, Shape, Trees};

use crate::random::Random;
use rotund_report::console::{Table, say};

/// Elements in a scene, all of one kind.
const ELEMENTS: u32 = 200;

/// Size of an element in meters; the scene measures two.
const SIZE: f32 = 0.5;

/// Allowed distance beyond the error of the hit, relative to the size of an element in the world
/// plus its distance from the origin.
const POSITION: f32 = 2.0 * f32::EPSILON;

/// Allowed angle between normals in radians, to be multiplied by [`flattening`].
const NORMAL: f64 = 1e-6;

/// Rounding of `uv`: normals may also differ by as much as they turn within it.
const PARAMETERS: f64 = 2.0 * f32::EPSILON as f64;

/// Compares at least `count` hits.
pub(crate) fn run(count: u64, seed: u64) -> Result<()> {
    let frames = frames();
    let cases: Vec<_> = KINDS
        .iter()
        .flat_map(|&case| frames.iter().map(move |&(name, frame)| (case, name, frame)))
        .collect();
    let each = count.div_ceil(cases.len() as u64);
    let tallies: Vec<_> = cases
        .par_iter()
        .map(|&((kind, method), name, frame)| {
            let mut random = Random::of(seed, &format!("{kind:?} {method:?} {name}"), 0);
            tally(&scene_of(kind, method, frame, &mut random), name, each, &mut random)
        })
        .collect();
    let mut table =
        Table::new(&["elements", "method", "hits", "points", "in frame", "normals", "in frame"]);
    let mut within = true;
    let mut hits = 0;
    for (&(kind, method), tallies) in KINDS.iter().zip(tallies.chunks(frames.len())) {
        let worst = |of: fn(&Tally) -> f64| {
            let mut worst = &tallies[0];
            for tally in tallies.iter().filter(|tally| of(tally) > of(worst)) {
                worst = tally;
            }
            (of(worst), worst.frame)
        };
        let (position, in_frame) = worst(|tally| tally.position);
        let (normal, turned_in) = worst(|tally| tally.normal);
        let own: u64 = tallies.iter().map(|tally| tally.hits).sum();
        hits += own;
        within &= position <= 1.0 && normal <= 1.0;
        let mut row = vec![
            format!("{kind:?}").to_lowercase(),
            format!("{method:?}").to_lowercase(),
            own.to_string(),
            format!("{position:.3}"),
            in_frame.to_owned(),
        ];
        if is_ribbon(kind, method) {
            row.push("-".to_owned());
        } else {
            row.extend([format!("{normal:.3}"), turned_in.to_owned()]);
        }
        table.row(row);
    }
    say(format!("{table}"))?;
    say(format!(
        "\n{hits} hits in {} frames. Largest errors of rebuilt points and normals, as shares of\n\
         their bounds. A point may be error + 2^-22 (size + distance) away; a normal may\n\
         differ by {NORMAL:e} radians times the condition of the frame, and by as much as it\n\
         turns while uv change by 2^-22.",
        frames.len()
    ))?;
    ensure!(within, "a hit is farther from the point of its parameters than allowed");
    Ok(())
}

const KINDS: [(ElementKind, Method); 7] = [
    (ElementKind::Points, Method::Enhanced),
    (ElementKind::Points, Method::Vanilla),
    (ElementKind::Lines, Method::Enhanced),
    (ElementKind::Lines, Method::Vanilla),
    (ElementKind::Quads, Method::Enhanced),
    (ElementKind::Quads, Method::Vanilla),
    (ElementKind::Triangles, Method::Enhanced),
];

/// Returns whether the shape is a ribbon that faces the ray, so that `uv` do not define its normal.
fn is_ribbon(kind: ElementKind, method: Method) -> bool {
    method == Method::Vanilla && matches!(kind, ElementKind::Points | ElementKind::Lines)
}

struct Tally {
    frame: &'static str,
    hits: u64,
    /// The largest errors, as shares of their bounds.
    position: f64,
    normal: f64,
}

fn tally(scene: &Scene, name: &'static str, hits: u64, random: &mut Random) -> Tally {
    let trees = Trees::build(scene).expect("the scene is valid");
    let frame = scene.instances[0].world_from_object;
    let shape = &scene.shapes[0];
    let ribbon = is_ribbon(shape.elements.kind(), shape.method);
    let matrix = frame.matrix3;
    let stretch = matrix.x_axis.length().max(matrix.y_axis.length()).max(matrix.z_axis.length());
    let flattening = flattening(&frame);
    let mut tally = Tally { frame: name, hits: 0, position: 0.0, normal: 0.0 };
    // Nearly all rays hit; the limit keeps a failing intersector from looping forever.
    for _ in 0..4 * hits {
        if tally.hits == hits {
            break;
        }
        let element = random.index(ELEMENTS as usize) as u32;
        let uv = Vec2::new(random.unit() as f32, random.unit() as f32);
        let target = scene.eval_position(0, element, uv);
        let origin = frame.transform_point3(4.0 * random.direction().as_vec3());
        let ray = Ray::new(origin, (target - origin) * random.range(0.1, 1.0) as f32);
        let Some(hit) = trees.closest(scene, &ray) else { continue };
        tally.hits += 1;
        let apart = scene.eval_position(0, hit.element, hit.uv).distance(hit.position);
        let bound = hit.error + POSITION * (SIZE * stretch + hit.position.length());
        tally.position = worse(tally.position, f64::from(apart / bound));
        if !ribbon {
            let rebuilt = scene.eval_normal(0, hit.element, hit.uv);
            let bound = NORMAL * flattening + PARAMETERS * turning(scene, hit.element, hit.uv);
            tally.normal = worse(tally.normal, angle(rebuilt, hit.normal) / bound);
        }
    }
    tally
}

/// Returns how far the normal turns for each unit of `u` and `v`, summed. There is no limit to it
/// where a patch folds, and at the poles of a needle.
fn turning(scene: &Scene, element: u32, uv: Vec2) -> f64 {
    const STEP: f32 = 1.0 / 16_384.0;
    let normal = |uv: Vec2| scene.eval_normal(0, element, uv);
    let inwards = Vec2::select(uv.cmplt(Vec2::splat(0.5)), Vec2::splat(STEP), Vec2::splat(-STEP));
    let here = normal(uv);
    [Vec2::new(inwards.x, 0.0), Vec2::new(0.0, inwards.y)]
        .map(|step| angle(here, normal(uv + step)) / f64::from(STEP))
        .iter()
        .sum()
}

fn angle(a: Vec3, b: Vec3) -> f64 {
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    a.cross(b).length().atan2(a.dot(b))
}

/// Returns the larger error; a NaN is the largest.
fn worse(so_far: f64, next: f64) -> f64 {
    if next.is_nan() { f64::INFINITY } else { so_far.max(next) }
}

/// Returns a bound on the condition number of a frame: 1 if it scales all directions alike.
pub(super) fn flattening(frame: &Affine3A) -> f64 {
    let matrix = Mat3::from(frame.matrix3).as_dmat3();
    let norm = |m: glam::DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    // Frobenius norms bound the largest singular value and the inverse of the smallest.
    (norm(matrix) * norm(matrix.inverse()) / 3.0).max(1.0)
}

fn scene_of(kind: ElementKind, method: Method, frame: Affine3A, random: &mut Random) -> Scene {
    let elements = match kind {
        ElementKind::Points => Elements::Points(ELEMENTS),
        ElementKind::Lines => Elements::Lines((0..ELEMENTS).map(|i| corners(2 * i)).collect()),
        ElementKind::Triangles => {
            Elements::Triangles((0..ELEMENTS).map(|i| corners(3 * i)).collect())
        }
        ElementKind::Quads => Elements::Quads((0..ELEMENTS).map(|i| corners(4 * i)).collect()),
    };
    let vertices = match kind {
        ElementKind::Points => 1,
        ElementKind::Lines => 2,
        ElementKind::Triangles => 3,
        ElementKind::Quads => 4,
    };
    let mut vector = || Vec3::from_array(std::array::from_fn(|_| random.range(-1.0, 1.0) as f32));
    let mut positions = Vec::new();
    for _ in 0..ELEMENTS {
        let center = vector();
        positions.extend((0..vertices).map(|_| center + SIZE * vector()));
    }
    let radii = positions.iter().map(|_| SIZE * random.range(0.02, 0.35) as f32).collect();
    let shape = Shape { method, elements, positions, radii, ..Shape::default() };
    let (name, world_from_object) = (String::new(), frame);
    Scene {
        materials: vec![Material::default()],
        shapes: vec![shape],
        instances: vec![Instance { name, world_from_object, shape: 0, material: 0 }],
        ..Scene::default()
    }
}

fn corners<const N: usize>(first: u32) -> [u32; N] {
    std::array::from_fn(|i| first + i as u32)
}

/// Returns frames of every kind and their names.
pub(super) fn frames() -> Vec<(&'static str, Affine3A)> {
    let rotation = Affine3A::from_quat(Quat::from_euler(EulerRot::XYZ, 0.3, 1.1, -0.7));
    let scale = |x, y, z| Affine3A::from_scale(Vec3::new(x, y, z));
    let moved = |x, y, z| Affine3A::from_translation(Vec3::new(x, y, z));
    let sheared = Affine3A::from_mat3(Mat3::from_cols(
        Vec3::new(1.0, 0.2, 0.0),
        Vec3::new(0.8, 1.0, -0.3),
        Vec3::new(0.0, 0.5, 1.0),
    ));
    vec![
        ("nothing", Affine3A::IDENTITY),
        ("turned", rotation),
        ("mirrored", scale(-1.0, 1.0, 1.0) * rotation),
        ("large", scale(1e3, 1e3, 1e3) * rotation),
        ("small", scale(1e-3, 1e-3, 1e-3) * rotation),
        ("stretched", rotation * scale(0.1, 3.0, 1.0)),
        ("flattened", rotation.inverse() * scale(1.0, 0.02, 1.0) * rotation),
        ("sheared", sheared * rotation),
        ("combined", moved(5.0, -7.0, 11.0) * sheared * scale(1.0, -2.0, 0.5)),
        ("far", moved(1e4, -2e4, 3e4) * rotation),
    ]
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_parameters_of_a_hit_evaluate_to_its_point_and_normal() {
        super::run(20_000, 5).expect("all within the bounds");
    }
}
