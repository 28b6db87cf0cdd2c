//! Builds of trees over triangles and closest-hit queries, in this library and in the crates `bvh`
//! and `obvhs`. Builds use all threads, queries one. The numbers of hits of the three must agree
//! within a thousandth of the rays.
//!
//! The interval of a ray does not shrink in `bvh`: all triangles whose boxes the ray meets are
//! tested. `obvhs` traverses an eight-wide tree with boxes quantised to eight bits, built with its
//! preset for medium quality.

use bvh::bounding_hierarchy::BoundingHierarchy;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris};
use rotund_bvh::{Method, TriangleTree};
use rotund_geometry::{Ray, Triangle, glam::Vec3};
use std::hint::black_box;
use std::time::Duration;

/// Quads along a side of the sheet.
const SIDE: usize = 300;

/// Points of the unit cube, by the additive recurrence of M. Roberts (2018).
fn points(count: usize) -> impl Iterator<Item = Vec3> {
    (1..=count).map(|i| {
        let at = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9]
            .map(|step| (i as f64 * step).fract());
        Vec3::from_array(at.map(|x| x as f32))
    })
}

/// A rough sheet of triangles.
fn sheet() -> Vec<Triangle> {
    let noise: Vec<Vec3> = points((SIDE + 1) * (SIDE + 1)).collect();
    let vertex = |i: usize, j: usize| {
        let height = noise[j * (SIDE + 1) + i].x / SIDE as f32;
        Vec3::new(i as f32 / SIDE as f32, j as f32 / SIDE as f32, height)
    };
    let quads = (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j)));
    quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] =
                [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            [Triangle { p0: a, p1: b, p2: d }, Triangle { p0: c, p1: d, p2: b }]
        })
        .collect()
}

/// A triangle with the traits that the crate `bvh` requires.
struct Shape {
    corners: [nalgebra::Point3<f32>; 3],
    node: usize,
}

impl bvh::aabb::Bounded<f32, 3> for Shape {
    fn aabb(&self) -> bvh::aabb::Aabb<f32, 3> {
        let [a, b, c] = &self.corners;
        bvh::aabb::Aabb::empty().grow(a).grow(b).grow(c)
    }
}

impl bvh::bounding_hierarchy::BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

fn peers(c: &mut Criterion) {
    let triangles = sheet();
    let rays: Vec<Ray> = points(1000)
        .zip(points(2000).skip(1000))
        .map(|(from, to)| {
            Ray::new(from + Vec3::Z, to * Vec3::new(1.0, 1.0, 0.0) - (from + Vec3::Z))
        })
        .collect();
    let mut group = c.benchmark_group("triangles");
    group.sample_size(10).measurement_time(Duration::from_secs(2));

    let point = |p: Vec3| nalgebra::Point3::new(p.x, p.y, p.z);
    let shapes = || -> Vec<Shape> {
        let corners = |t: &Triangle| [point(t.p0), point(t.p1), point(t.p2)];
        triangles.iter().map(|t| Shape { corners: corners(t), node: 0 }).collect()
    };
    let vec3a = |p: Vec3| glam::Vec3A::new(p.x, p.y, p.z);
    let theirs: Vec<obvhs::triangle::Triangle> = triangles
        .iter()
        .map(|t| obvhs::triangle::Triangle { v0: vec3a(t.p0), v1: vec3a(t.p1), v2: vec3a(t.p2) })
        .collect();
    let build_obvhs = |triangles: &[obvhs::triangle::Triangle]| {
        build_cwbvh_from_tris(triangles, BvhBuildParams::medium_build(), &mut Duration::default())
    };

    group.throughput(Throughput::Elements(triangles.len() as u64));
    group
        .bench_function("build, rotund", |b| b.iter(|| TriangleTree::build(black_box(&triangles))));
    group.bench_function("build, bvh", |b| {
        b.iter_batched_ref(
            shapes,
            |s| bvh::bvh::Bvh::build_par(s),
            criterion::BatchSize::LargeInput,
        );
    });
    group.bench_function("build, obvhs", |b| b.iter(|| build_obvhs(black_box(&theirs))));

    let ours = TriangleTree::build(&triangles);
    let ours = || rays.iter().filter(|ray| ours.closest(ray, Method::Enhanced).is_some()).count();
    let mut bvh_shapes = shapes();
    let bvh_tree = bvh::bvh::Bvh::build(&mut bvh_shapes);
    let by_bvh = || {
        let hits = |ray: &&Ray| {
            let direction =
                nalgebra::Vector3::new(ray.direction.x, ray.direction.y, ray.direction.z);
            let ray = bvh::ray::Ray::new(point(ray.origin), direction);
            let nearest =
                bvh_tree.traverse_iterator(&ray, &bvh_shapes).fold(f32::INFINITY, |t, shape| {
                    let [a, b, c] = &shape.corners;
                    t.min(ray.intersects_triangle(a, b, c).distance)
                });
            nearest < f32::INFINITY
        };
        rays.iter().filter(hits).count()
    };
    let obvhs_tree = build_obvhs(&theirs);
    let by_obvhs = || {
        let hits = |ray: &&Ray| {
            let ray = obvhs::ray::Ray::new_inf(vec3a(ray.origin), vec3a(ray.direction));
            let mut hit = obvhs::ray::RayHit::none();
            obvhs_tree.ray_traverse(ray, &mut hit, |ray, id| {
                theirs[obvhs_tree.primitive_indices[id] as usize].intersect(ray)
            })
        };
        rays.iter().filter(hits).count()
    };
    let counts = [ours(), by_bvh(), by_obvhs()];
    let slack = rays.len() / 1000;
    assert!(counts.iter().all(|count| count.abs_diff(counts[0]) <= slack), "hits: {counts:?}");
    assert!(counts[0] > rays.len() / 2, "hits: {counts:?}");

    group.throughput(Throughput::Elements(rays.len() as u64));
    group.bench_function("closest, rotund", |b| b.iter(ours));
    group.bench_function("closest, bvh", |b| b.iter(by_bvh));
    group.bench_function("closest, obvhs", |b| b.iter(by_obvhs));
    group.finish();
}

criterion_group!(benches, peers);
criterion_main!(benches);
