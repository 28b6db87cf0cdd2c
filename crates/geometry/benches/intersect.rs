//! Time of one ray against one primitive, for the exact shapes and their approximations.
//!
//! Hits and misses are timed apart, over 1024 rays that the branch predictor learns. So are rays
//! spawned from hits on the exact shapes, outwards and, if there is an inside, inwards.

#[path = "../src/test_random.rs"]
mod test_random;

use std::hint::black_box;

use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use rotund_geometry::glam::Vec3;
use rotund_geometry::vanilla::{Line, Point, Quad};
use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere};
use test_random::Random;

const RAYS: usize = 1024;

/// Returns rays at the cube from -1 to 1 for which `hits` returns `wanted`.
fn rays(wanted: bool, hits: impl Fn(&Ray) -> bool) -> Vec<Ray> {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut rays = Vec::new();
    while rays.len() < RAYS {
        let origin = random.in_cube().normalize_or(Vec3::X) * 10.0;
        let ray = Ray::new(origin, random.in_cube() - origin);
        if hits(&ray) == wanted {
            rays.push(ray);
        }
    }
    rays
}

fn time<S: Copy>(
    group: &mut BenchmarkGroup<'_, criterion::measurement::WallTime>,
    name: &str,
    shape: S,
    closest: impl Fn(&S, &Ray) -> Option<Hit>,
    any: impl Fn(&S, &Ray) -> bool,
) {
    for (wanted, kind) in [(true, "hits"), (false, "misses")] {
        let rays = rays(wanted, |ray| any(&shape, ray));
        assert!(
            rays.iter().all(|ray| closest(&shape, ray).is_some() == wanted),
            "both queries agree on every ray"
        );
        group.throughput(Throughput::Elements(RAYS as u64));
        group.bench_function(format!("{name}/closest/{kind}"), |bencher| {
            bencher.iter(|| {
                for ray in &rays {
                    black_box(closest(black_box(&shape), ray));
                }
            });
        });
        group.bench_function(format!("{name}/any/{kind}"), |bencher| {
            bencher.iter(|| rays.iter().filter(|ray| any(black_box(&shape), ray)).count());
        });
    }
}

/// Returns rays spawned from hits, to the side that the first ray came from, or through the
/// surface.
fn leaving(
    through: bool,
    closest: impl Fn(&Ray) -> Option<Hit>,
    any: impl Fn(&Ray) -> bool,
) -> Vec<Ray> {
    let mut random = Random(0xD1B5_4A32_D192_ED03);
    let spawn = |ray: &Ray| {
        let hit = closest(ray).expect("the rays were chosen because they hit");
        let side = if (hit.normal.dot(ray.direction) < 0.0) != through { 1.0 } else { -1.0 };
        let direction = random.in_cube().normalize_or(Vec3::X) + 1.001 * side * hit.normal;
        hit.spawn(direction)
    };
    rays(true, any).iter().map(spawn).collect()
}

fn time_leaving<S: Copy>(
    group: &mut BenchmarkGroup<'_, criterion::measurement::WallTime>,
    shape: S,
    closest: impl Fn(&S, &Ray) -> Option<Hit>,
    any: impl Fn(&S, &Ray) -> bool,
    is_solid: bool,
) {
    for (through, kind) in [(false, "leaving"), (true, "entering")] {
        let rays = leaving(through, |ray| closest(&shape, ray), |ray| any(&shape, ray));
        let hits = rays.iter().filter(|ray| any(&shape, ray)).count();
        let expected = if through && is_solid { RAYS } else { 0 };
        // A patch may bend back so that a ray hits it again.
        let bent = if is_solid { 0 } else { RAYS / 50 };
        assert!(hits.abs_diff(expected) <= bent, "{hits} of {RAYS} rays hit the shape again");
        group.throughput(Throughput::Elements(RAYS as u64));
        group.bench_function(format!("enhanced/closest/{kind}"), |bencher| {
            bencher.iter(|| {
                for ray in &rays {
                    black_box(closest(black_box(&shape), ray));
                }
            });
        });
    }
}

macro_rules! side_by_side {
    ($group:expr, $($name:literal => $type:ident $shape:expr),+) => {
        $(time(&mut $group, $name, $shape, $type::closest, $type::any);)+
    };
}

fn intersect(criterion: &mut Criterion) {
    let (p0, p1) = (Vec3::new(-0.5, -0.4, -0.3), Vec3::new(0.5, 0.4, 0.3));
    let mut group = criterion.benchmark_group("points");
    let sphere = Sphere { center: Vec3::ZERO, radius: 0.5 };
    side_by_side!(group,
        "vanilla" => Point Point { center: Vec3::ZERO, radius: 0.5 },
        "enhanced" => Sphere sphere);
    time_leaving(&mut group, sphere, Sphere::closest, Sphere::any, true);
    group.finish();

    let mut group = criterion.benchmark_group("lines");
    let cone = RoundedCone { p0, r0: 0.3, p1, r1: 0.2 };
    side_by_side!(group,
        "vanilla" => Line Line { p0, r0: 0.3, p1, r1: 0.2 },
        "enhanced" => RoundedCone cone);
    time_leaving(&mut group, cone, RoundedCone::closest, RoundedCone::any, true);
    group.finish();

    let corners = [[-0.5, -0.5, -0.2], [0.5, -0.5, 0.2], [0.5, 0.5, -0.2], [-0.5, 0.5, 0.2]];
    let [p0, p1, p2, p3] = corners.map(Vec3::from);
    let mut group = criterion.benchmark_group("quads");
    let patch = BilinearPatch { p00: p0, p10: p1, p01: p3, p11: p2 };
    side_by_side!(group,
        "vanilla" => Quad Quad { p0, p1, p2, p3 },
        "enhanced" => BilinearPatch patch);
    time_leaving(&mut group, patch, BilinearPatch::closest, BilinearPatch::any, false);
    group.finish();
}

criterion_group!(benches, intersect);
criterion_main!(benches);
