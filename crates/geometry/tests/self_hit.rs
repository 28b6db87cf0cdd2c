//! A ray of `Hit::spawn` does not hit the surface that it left, unless the exact ray does.

mod support;

use rotund_geometry::glam::{DVec3, Vec2, Vec3};
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Sphere, Triangle};
use support::{Random, ray};

/// Returns a direction on the outer side of `normal`; every third one is almost tangent.
fn outwards(random: &mut Random, normal: Vec3) -> Vec3 {
    let n = normal.as_dvec3();
    let d = match random.bits() % 3 {
        0 => random.across(n) + n * 10_f64.powf(random.range(-6.0, -2.0)),
        _ => {
            let d = random.direction();
            if d.dot(n) < 0.0 { -d } else { d }
        }
    };
    // Normal and direction are rounded: closer to the tangent plane, the exact ray may enter the
    // solid.
    let d = d.as_vec3();
    if d.as_dvec3().dot(n) > 5e-7 { d } else { normal }
}

/// Returns a place and a scale, for shapes of all sizes at all distances from the origin of the
/// world.
fn placed(random: &mut Random) -> (DVec3, f64) {
    let scale = 10_f64.powf(random.range(-6.0, 6.0));
    let offset = 10_f64.powf(random.range(-3.0, 5.0));
    (random.direction() * offset * scale, scale)
}

fn aimed(random: &mut Random, target: Vec3, scale: f64) -> Ray {
    let distance = scale * 10_f64.powf(random.range(0.5, 4.0));
    let d = random.direction() * 10_f64.powf(random.range(-2.0, 2.0));
    ray(target.as_dvec3() - d.normalize() * distance, d)
}

#[test]
fn a_ray_that_leaves_a_sphere_never_hits_it_again() {
    let mut random = Random(1);
    let mut bounces = 0;
    while bounces < 1_500_000 {
        let (center, scale) = placed(&mut random);
        let sphere = Sphere { center: center.as_vec3(), radius: scale as f32 };
        let target = sphere.center + (random.direction() * scale).as_vec3();
        let Some(hit) = sphere.closest(&aimed(&mut random, target, scale)) else { continue };
        for _ in 0..4 {
            bounces += 1;
            let out = hit.spawn(outwards(&mut random, hit.normal));
            assert_eq!(sphere.closest(&out), None, "{sphere:?} {hit:?} {out:?}");
            // Inwards, the next hit is the far side, not the surface that was just entered.
            let into = hit.spawn(-outwards(&mut random, hit.normal));
            let cosine = -hit.normal.as_dvec3().dot(into.direction.as_dvec3().normalize());
            let exit = sphere.closest(&into).expect("an exit");
            assert!(exit.normal.dot(into.direction) >= 0.0, "{sphere:?} {hit:?} {into:?}");
            let chord = f64::from(exit.position.distance(hit.position));
            assert!(cosine < 1e-2 || chord > scale * cosine, "{sphere:?} {hit:?} {into:?}");
        }
    }
}

#[test]
fn a_ray_that_leaves_a_cone_never_hits_it_again() {
    let mut random = Random(2);
    let mut bounces = 0;
    while bounces < 1_000_000 {
        let (p0, scale) = placed(&mut random);
        let axis = random.direction() * scale * 10_f64.powf(random.range(-2.0, 2.0));
        let cone = RoundedCone {
            p0: p0.as_vec3(),
            r0: (scale * random.range(0.1, 1.0)) as f32,
            p1: (p0 + axis).as_vec3(),
            r1: (scale * random.range(0.1, 1.0)) as f32,
        };
        let uv = Vec2::new(random.range(0.0, 1.0) as f32, random.range(0.0, 1.0) as f32);
        let target = cone.position(uv);
        let Some(hit) = cone.closest(&aimed(&mut random, target, scale)) else { continue };
        for _ in 0..4 {
            bounces += 1;
            let out = hit.spawn(outwards(&mut random, hit.normal));
            assert_eq!(cone.closest(&out), None, "{cone:?} {hit:?} {out:?}");
            let into = hit.spawn(-outwards(&mut random, hit.normal));
            let exit = cone.closest(&into).expect("an exit");
            assert!(exit.normal.dot(into.direction) >= 0.0, "{cone:?} {hit:?} {into:?}");
        }
    }
}

#[test]
fn a_ray_that_leaves_a_triangle_never_hits_it_again() {
    let mut random = Random(3);
    let mut bounces = 0;
    while bounces < 600_000 {
        let (p00, scale) = placed(&mut random);
        let (e, f) = (random.direction() * scale, random.direction() * scale);
        let triangle =
            Triangle { p0: p00.as_vec3(), p1: (p00 + e).as_vec3(), p2: (p00 + f).as_vec3() };
        let uv = Vec2::new(random.range(0.1, 0.4) as f32, random.range(0.1, 0.4) as f32);
        let target = triangle.position(uv);
        let Some(hit) = triangle.closest(&aimed(&mut random, target, scale)) else { continue };
        for _ in 0..4 {
            bounces += 1;
            for side in [1.0, -1.0] {
                let out = hit.spawn(side * outwards(&mut random, hit.normal));
                assert_eq!(triangle.closest(&out), None, "{triangle:?} {hit:?} {out:?}");
            }
        }
    }
}

#[test]
fn a_ray_that_leaves_a_patch_hits_it_again_only_where_it_bends_back() {
    let mut random = Random(4);
    let mut bounces = 0;
    while bounces < 600_000 {
        let (center, scale) = placed(&mut random);
        let mut corner = |x: f64, y: f64| {
            let shake = random.direction() * 0.3;
            (center + scale * (DVec3::new(x, y, 0.0) + shake)).as_vec3()
        };
        let patch = BilinearPatch {
            p00: corner(-1.0, -1.0),
            p10: corner(1.0, -1.0),
            p01: corner(-1.0, 1.0),
            p11: corner(1.0, 1.0),
        };
        let uv = Vec2::new(random.range(0.0, 1.0) as f32, random.range(0.0, 1.0) as f32);
        let target = patch.position(uv);
        let Some(hit) = patch.closest(&aimed(&mut random, target, scale)) else { continue };
        for _ in 0..4 {
            for side in [1.0, -1.0] {
                bounces += 1;
                let out = hit.spawn(side * outwards(&mut random, hit.normal));
                let Some(again) = patch.closest(&out) else { continue };
                // The normals of these patches turn by at most about 2 radians per edge length, so
                // the length of the way back is at least proportional to the angle at which the ray
                // left.
                let sine = f64::from(out.direction.normalize().dot(hit.normal).abs());
                let way = f64::from(again.position.distance(hit.position)) / scale;
                assert!(way > 0.2 * sine - 1e-6, "{patch:?} {hit:?} {out:?} {again:?}");
            }
        }
    }
}

/// One family of rulings is level. A level ray intersects only one of them, but is parallel to
/// another one, which solves the same equation.
#[test]
fn a_level_ray_that_leaves_a_helicoid_does_not_hit_the_ruling_parallel_to_it() {
    let (p00, p10) = (Vec3::new(-0.1275, 0.0, 0.7391), Vec3::new(-0.1275, 1.6, -0.7391));
    let (p01, p11) = (Vec3::new(0.1275, 0.0, -0.7391), Vec3::new(0.1275, 1.6, 0.7391));
    let helicoid = BilinearPatch { p00, p10, p01, p11 };
    let mut random = Random(5);
    let mut bounces = 0;
    while bounces < 100_000 {
        let target = helicoid
            .position(Vec2::new(random.range(0.0, 1.0) as f32, random.range(0.0, 1.0) as f32));
        let Some(hit) = helicoid.closest(&aimed(&mut random, target, 1.0)) else { continue };
        let d = random.direction();
        let level = DVec3::new(d.x, 0.0, d.z).as_vec3();
        // The axis belongs to all rulings, so the ray must start away from it.
        if hit.position.x.hypot(hit.position.z) < 0.01 {
            continue;
        }
        bounces += 1;
        // An interval that begins before the origin makes the solver look for the root behind it
        // too.
        for t_min in [0.0, -f32::MIN_POSITIVE] {
            let out = Ray { t_min, ..hit.spawn(level) };
            assert_eq!(helicoid.closest(&out), None, "{hit:?} {out:?}");
        }
    }
}
