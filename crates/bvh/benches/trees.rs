//! Trees over spheres: building them, and closest-hit and any-hit queries with each method and
//! instruction set.

#[path = "../../geometry/src/test_random.rs"]
mod test_random;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rotund_bvh::{Isa, Method, SphereTree};
use rotund_geometry::{Ray, Sphere};
use std::hint::black_box;
use test_random::Random;

fn trees(c: &mut Criterion) {
    let count = 100_000;
    let mut random = Random(1);
    let spheres: Vec<Sphere> =
        (0..count).map(|_| Sphere { center: random.in_cube(), radius: 0.004 }).collect();
    let mut group = c.benchmark_group("spheres");
    group.sample_size(20);
    group.throughput(Throughput::Elements(count as u64));
    group.bench_function("build", |b| b.iter(|| SphereTree::build(black_box(&spheres))));

    let rays: Vec<Ray> = (0..2000)
        .map(|_| {
            let origin = 3.0 * random.in_cube();
            Ray::new(origin, random.in_cube() - origin)
        })
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
