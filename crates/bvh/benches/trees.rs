//! Building trees over spheres, and asking them for the closest and for any hit.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use rotund_bvh::{Isa, Method, SphereTree};
use rotund_geometry::{Ray, Sphere};
use std::hint::black_box;

/// Points of the unit cube, by the additive recurrence of M. Roberts (2018).
fn points(count: usize) -> impl Iterator<Item = Vec3> {
    (1..=count).map(|i| {
        let at = i as f64 * glam::DVec3::new(0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9);
        at.fract().as_vec3()
    })
}

fn trees(c: &mut Criterion) {
    let count = 100_000;
    let radius = 0.002;
    let spheres: Vec<Sphere> = points(count).map(|center| Sphere { center, radius }).collect();
    let mut group = c.benchmark_group("spheres");
    group.sample_size(20);
    group.throughput(Throughput::Elements(count as u64));
    group.bench_function("build", |b| b.iter(|| SphereTree::build(black_box(&spheres))));

    let rays: Vec<Ray> = points(2000)
        .zip(points(count + 2000).skip(count)) // none of them the middle of a sphere
        .map(|(from, to)| Ray::new(3.0 * from - Vec3::ONE, to - (3.0 * from - Vec3::ONE)))
        .collect();
    group.throughput(Throughput::Elements(rays.len() as u64));
    for isa in Isa::available() {
        let tree = SphereTree::build(&spheres).with_isa(isa);
        let hits = rays.iter().filter(|ray| tree.any(ray, Method::Enhanced)).count();
        assert!((rays.len() / 4..rays.len() * 3 / 4).contains(&hits), "{hits} hits");
        for method in Method::ALL {
            group.bench_function(format!("closest, {method}, {}", isa.name()), |b| {
                b.iter(|| rays.iter().filter(|ray| tree.closest(ray, method).is_some()).count());
            });
            group.bench_function(format!("any, {method}, {}", isa.name()), |b| {
                b.iter(|| rays.iter().filter(|ray| tree.any(ray, method)).count());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, trees);
criterion_main!(benches);
