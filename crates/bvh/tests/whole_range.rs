//! Packed trees give the answer of a loop over all primitives in the whole range of `f32`.

mod support;

use glam::Vec3;
use rotund_bvh::{
    ConeTree, Crossing, Isa, Method, PatchTree, PrimitiveHit, SphereTree, TriangleTree,
};
use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere, Triangle, vanilla};
use std::ops::ControlFlow;
use support::{Random, cones, patches, spheres, triangles};

/// The exponents of the scales of scenes.
const EXPONENTS: [i32; 15] = [-145, -130, -110, -75, -60, 0, 30, 37, 39, 42, 45, 60, 90, 115, 126];

/// Returns rays at the primitives of a scene of this scale, from near and far, with directions of
/// every length.
fn rays(random: &mut Random, scale: f32, count: usize) -> Vec<Ray> {
    let power = |random: &mut Random, low: f32, high: f32| {
        2f64.powf(f64::from(low + (high - low) * random.unit()))
    };
    (0..count)
        .map(|i| {
            let target = random.in_cube().as_dvec3() * f64::from(scale);
            let direction = random.in_cube().as_dvec3().normalize();
            let far = [f64::from(scale), power(random, -20.0, 127.0)][i % 2];
            let (low, high) = [(-149.0, 127.0), (-125.0, -110.0), (-10.0, 10.0)][i % 3];
            let length = power(random, low, high);
            let mut ray = Ray::new(
                (target - 3.0 * far * direction).as_vec3(),
                (direction * length).as_vec3(),
            );
            if i % 5 == 0 {
                ray.direction[i % 3] = 0.0;
            }
            if i % 7 == 0 {
                ray.t_min = f32::NEG_INFINITY;
            }
            if i % 11 == 0 {
                ray.t_max = (far * 3.0 / length) as f32;
            }
            ray
        })
        .collect()
}

/// Compares a tree with the loop on every instruction set, and returns the number of hits.
macro_rules! hits {
    ($tree:ty, $primitives:expr, $rays:expr, $vanilla:expr) => {{
        let (primitives, rays) = (&$primitives, &$rays);
        let trees: Vec<$tree> = Isa::available()
            .into_iter()
            .map(|isa| <$tree>::build(primitives).with_isa(isa))
            .collect();
        let mut hits = 0;
        for method in Method::ALL {
            for ray in rays {
                let closest = |id: usize| match method {
                    Method::Enhanced => primitives[id].closest(ray),
                    Method::Vanilla => $vanilla(&primitives[id]).closest(ray),
                };
                let expected = loop_over(primitives.len(), closest);
                hits += usize::from(expected.is_some());
                let mut all: Option<Vec<Crossing>> = None;
                for tree in &trees {
                    let found = (tree.closest(ray, method), tree.any(ray, method));
                    let kind = stringify!($tree);
                    let why = format!("{kind}, {method:?}, {:?}, {ray:?}", tree.isa());
                    assert_eq!(found, (expected, expected.is_some()), "{why}");
                    let mut crossings = Vec::new();
                    _ = tree.crossings(ray, method, |crossing| {
                        crossings.push(*crossing);
                        ControlFlow::Continue(())
                    });
                    let first = crossings.first().map(|crossing| crossing.hit.t);
                    assert!(expected.is_none_or(|hit| Some(hit.hit.t) >= first), "{why}");
                    assert_eq!(&crossings, all.get_or_insert(crossings.clone()), "{why}");
                }
            }
        }
        hits
    }};
}

/// The loop: lowest id among the smallest `t`.
fn loop_over(count: usize, closest: impl Fn(usize) -> Option<Hit>) -> Option<PrimitiveHit> {
    (0..count).fold(None, |best: Option<PrimitiveHit>, id| match closest(id) {
        Some(hit) if best.is_none_or(|best| hit.t < best.hit.t) => {
            Some(PrimitiveHit { id: id as u32, hit })
        }
        _ => best,
    })
}

fn point(s: &Sphere) -> vanilla::Point {
    vanilla::Point { center: s.center, radius: s.radius }
}

fn line(c: &RoundedCone) -> vanilla::Line {
    vanilla::Line { p0: c.p0, r0: c.r0, p1: c.p1, r1: c.r1 }
}

fn quad(p: &BilinearPatch) -> vanilla::Quad {
    vanilla::Quad { p0: p.p00, p1: p.p10, p2: p.p11, p3: p.p01 }
}

/// Checks all kinds of primitives at each scale; `change` changes a point of each.
fn check(count: usize, change: impl Fn(usize, Vec3) -> Vec3) -> usize {
    let mut hits = 0;
    for exponent in EXPONENTS {
        let scale = 2f64.powi(exponent) as f32;
        let mut random = Random(exponent as u64);
        let at = |i: usize, p: Vec3| change(i, p * scale);
        let mut balls = spheres(&mut random, count, 0.4);
        for (i, ball) in balls.iter_mut().enumerate() {
            *ball = Sphere { center: at(i, ball.center), radius: scale * ball.radius };
        }
        let mut tubes = cones(&mut random, count, 0.8);
        for (i, c) in tubes.iter_mut().enumerate() {
            let (p0, p1) = (at(i, c.p0), c.p1 * scale);
            *c = RoundedCone { p0, r0: scale * c.r0, p1, r1: scale * c.r1 };
        }
        let mut sheet = patches(&mut random, count, 0.8);
        for (i, p) in sheet.iter_mut().enumerate() {
            let [p10, p01, p11] = [p.p10, p.p01, p.p11].map(|p| p * scale);
            *p = BilinearPatch { p00: at(i, p.p00), p10, p01, p11 };
        }
        let mut faces = triangles(&mut random, count, 0.8);
        for (i, t) in faces.iter_mut().enumerate() {
            *t = Triangle { p0: at(i, t.p0), p1: t.p1 * scale, p2: t.p2 * scale };
        }
        let rays = rays(&mut random, scale, 300);
        hits += hits!(SphereTree, balls, rays, point);
        hits += hits!(ConeTree, tubes, rays, line);
        hits += hits!(PatchTree, sheet, rays, quad);
        hits += hits!(TriangleTree, faces, rays, |t: &Triangle| *t);
    }
    hits
}

#[test]
fn scenes_of_every_scale_agree_with_a_loop() {
    let hits = check(40, |_, p| p);
    assert!(hits > 5_000, "{hits} hits test little");
}

#[test]
fn a_coordinate_of_any_size_changes_no_answer() {
    for far in [1e12, 1e19, -1e30, 3e38] {
        let hits = check(20, |i, p| if i == 7 { Vec3::new(p.x, far, p.z) } else { p });
        assert!(hits > 5_000, "{hits} hits test little");
    }
}
