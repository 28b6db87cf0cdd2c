//! A ray through a shared edge or corner of a sheet hits it once: there are no leaks and no double
//! hits.

mod support;

use rotund_geometry::glam::{DVec3, Vec2, Vec3};
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Triangle, vanilla};
use support::{Random, ray};

/// Two by two skew patches over the square -1..1. Each lists its corners from a random one on, and
/// half of them in reverse.
struct Sheet {
    grid: [[Vec3; 3]; 3],
    patches: [BilinearPatch; 4],
}

fn sheet(random: &mut Random) -> Sheet {
    let mut grid = [[Vec3::ZERO; 3]; 3];
    for (i, row) in grid.iter_mut().enumerate() {
        for (j, p) in row.iter_mut().enumerate() {
            let (x, y) = (i as f64 - 1.0, j as f64 - 1.0);
            let mut shake = |by: f64| random.range(-by, by);
            *p = DVec3::new(x + shake(0.2), y + shake(0.2), shake(0.15)).as_vec3();
        }
    }
    let patches = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
        let mut loop_ = [grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]];
        loop_.rotate_left((random.bits() % 4) as usize);
        if random.bits().is_multiple_of(2) {
            loop_.reverse();
        }
        let [p00, p10, p11, p01] = loop_;
        BilinearPatch { p00, p10, p01, p11 }
    });
    Sheet { grid, patches }
}

/// Returns a ray from `distance` away at a point of an inner edge, or at the corner that all
/// patches share.
fn aimed(random: &mut Random, sheet: &Sheet, corner: bool, distance: f64) -> Ray {
    let center = sheet.grid[1][1].as_dvec3();
    let ends = [sheet.grid[0][1], sheet.grid[2][1], sheet.grid[1][0], sheet.grid[1][2]];
    let end = ends[(random.bits() % 4) as usize].as_dvec3();
    let target = if corner { center } else { center.lerp(end, random.range(0.0, 0.97)) };
    let d = loop {
        // The ray must be steep, or it may leave the sheet at its rim and come back, or hit a patch
        // twice. The area of the image is linear in u and in v, so the corners decide whether a
        // patch folds.
        let d = random.direction();
        let unfolded = |patch: &BilinearPatch| {
            [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].into_iter().all(|uv| {
                let n = patch.normal(uv).as_dvec3();
                n.dot(d) * n.z * d.z > 0.0
            })
        };
        if d.z.abs() > 0.6 && sheet.patches.iter().all(unfolded) {
            break d;
        }
    };
    ray(target - distance * d, d)
}

#[test]
fn a_ray_at_a_shared_edge_or_corner_hits_one_of_the_patches() {
    let mut random = Random(1);
    for distance in [0.5, 3.0, 1000.0] {
        for corner in [false, true] {
            for _ in 0..20_000 {
                let sheet = sheet(&mut random);
                for _ in 0..10 {
                    let ray = aimed(&mut random, &sheet, corner, distance);
                    let hits = sheet.patches.iter().filter(|patch| patch.any(&ray)).count();
                    assert_eq!(hits, 1, "{:?} {ray:?}", sheet.patches);
                }
            }
        }
    }
}

#[test]
fn a_ray_exactly_through_a_corner_or_an_edge_hits_one_of_the_patches() {
    // All numbers are representable, so the ray passes exactly through the corner.
    for dx in -8..=8_i8 {
        for dy in -8..=8_i8 {
            let height = |i: usize, j: usize| if (i + j).is_multiple_of(2) { 0.25 } else { -0.25 };
            let p = |i: usize, j: usize| Vec3::new(i as f32 - 1.0, j as f32 - 1.0, height(i, j));
            let patches = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| BilinearPatch {
                p00: p(i, j),
                p10: p(i + 1, j),
                p01: p(i, j + 1),
                p11: p(i + 1, j + 1),
            });
            let d = Vec3::new(f32::from(dx) / 16.0, f32::from(dy) / 16.0, -1.0);
            for target in [p(1, 1), 0.5 * (p(1, 1) + p(1, 2)), 0.25 * p(0, 1) + 0.75 * p(1, 1)] {
                let ray = Ray::new(target - 4.0 * d, d);
                let hits = patches.iter().filter(|patch| patch.any(&ray)).count();
                assert_eq!(hits, 1, "{ray:?}");
            }
        }
    }
}

#[test]
fn a_ray_at_a_shared_edge_or_corner_hits_one_of_the_triangles_or_quads() {
    let mut random = Random(2);
    for _ in 0..20_000 {
        let sheet = sheet(&mut random);
        let rim = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
            .map(|(i, j): (usize, usize)| sheet.grid[i][j]);
        for corner in [false, true] {
            let ray = aimed(&mut random, &sheet, corner, 3.0);
            let fan = (0..8).filter(|&i| {
                let (p1, p2) = (rim[i], rim[(i + 1) % 8]);
                Triangle { p0: sheet.grid[1][1], p1, p2 }.any(&ray)
            });
            assert_eq!(fan.count(), 1, "{rim:?} {ray:?}");
            let patches = sheet.patches.iter().filter(|patch| {
                let BilinearPatch { p00: p0, p10: p1, p01: p3, p11: p2 } = **patch;
                vanilla::Quad { p0, p1, p2, p3 }.any(&ray)
            });
            assert_eq!(patches.count(), 1, "{:?} {ray:?}", sheet.patches);
        }
    }
}

#[test]
fn a_ray_at_the_joint_of_a_chain_of_cones_hits_one_of_them() {
    let mut random = Random(3);
    for _ in 0..200_000 {
        let p = [(); 3].map(|()| (random.direction() * random.range(0.5, 2.0)).as_vec3());
        let r = [(); 3].map(|()| random.range(0.05, 0.3) as f32);
        let first = RoundedCone { p0: p[0], r0: r[0], p1: p[1], r1: r[1] };
        let second = RoundedCone { p0: p[1], r0: r[1], p1: p[2], r1: r[2] };
        // The target is anywhere in the shared ball.
        let d = random.direction();
        let target =
            p[1].as_dvec3() + random.direction() * (f64::from(r[1]) * random.range(0.0, 0.999_999));
        let ray = ray(target - 5.0 * d, d);
        let hits = [first.closest_t(&ray), second.closest_t(&ray)];
        assert!(hits.iter().all(Option::is_some), "{first:?} {second:?} {ray:?}");
    }
}
