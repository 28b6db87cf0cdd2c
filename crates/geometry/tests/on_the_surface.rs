//! Rays that start exactly on a surface, and hits next to the origin of coordinates, where no
//! rounding of the position hides what `f64` has lost.

mod support;

use rotund_geometry::glam::{DVec3, Vec2, Vec3};
use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere, rounding_error};
use support::{Random, Wide, ray, wide};

/// Integer vectors of integer length.
const TRIPLES: [(Vec3, f32); 4] = [
    (Vec3::new(0.0, 3.0, 4.0), 5.0),
    (Vec3::new(2.0, 3.0, 6.0), 7.0),
    (Vec3::new(-6.0, 6.0, 7.0), 11.0),
    (Vec3::new(8.0, -9.0, 12.0), 17.0),
];

/// Calls `check` with rays that start at a point of a surface with this normal, on both sides.
fn rays_from(random: &mut Random, point: Vec3, normal: DVec3, mut check: impl FnMut(Ray)) {
    for _ in 0..50 {
        let direction = random.direction() * 10_f64.powf(random.range(-6.0, 6.0));
        if direction.normalize().dot(normal).abs() > 1e-3 {
            check(Ray::new(point, direction.as_vec3()));
        }
    }
}

/// Returns a power of two, and a vector of small integers, by which shapes are scaled and moved
/// without rounding.
fn placed(random: &mut Random) -> (f32, Vec3) {
    let scale = 2_f32.powi((random.bits() % 41) as i32 - 20);
    let by = (random.direction() * 1000.0).round().as_vec3();
    (scale, scale * by)
}

#[test]
fn a_ray_that_starts_exactly_on_a_surface_hits_it_there_whichever_way_it_goes() {
    let mut random = Random(3);
    for (out, radius) in TRIPLES.iter().cycle().take(400).copied() {
        let (scale, by) = placed(&mut random);
        let (point, normal) = (by + scale * out, out.as_dvec3() / f64::from(radius));
        let sphere = Sphere { center: by, radius: scale * radius };
        rays_from(&mut random, point, normal, |ray| {
            assert_eq!(sphere.closest_t(&ray), Some(0.0), "{sphere:?} {ray:?}");
        });

        // On the cap of a cone, and on the body of a cylinder along an axis.
        let narrow = scale * random.range(0.0, 1.0) as f32;
        let capped = RoundedCone { p0: by, r0: scale * radius, p1: by - scale * out, r1: narrow };
        let across = Vec3::new(out.x, 0.0, 0.0) * scale;
        let [below, above] = [-3.0, 41.0].map(|x| by + across + Vec3::X * (scale * x));
        // A circle about the axis x, through `3, 4` or `5, 12`.
        let (rim, wide) = [([3.0, 4.0], 5.0), ([5.0, -12.0], 13.0)][(random.bits() % 2) as usize];
        let rim = Vec3::new(0.0, rim[0], rim[1]);
        let tube = RoundedCone { p0: below, r0: scale * wide, p1: above, r1: scale * wide };
        rays_from(&mut random, point, normal, |ray| {
            assert_eq!(capped.closest_t(&ray), Some(0.0), "{capped:?} {ray:?}");
        });
        let on_body = by + across + scale * (rim + Vec3::X);
        rays_from(&mut random, on_body, rim.as_dvec3().normalize(), |ray| {
            assert_eq!(tube.closest_t(&ray), Some(0.0), "{tube:?} {ray:?}");
        });
        // A tangent touches it where it does, and not at its own origin.
        let along = Vec3::new(1.0, -rim.z, rim.y);
        let tangent = Ray::new(on_body - 8.0 * scale * along, scale * along);
        assert_eq!(tube.closest_t(&tangent), Some(8.0), "{tube:?} {tangent:?}");

        // A patch of small integers, at parameters that are multiples of a sixteenth.
        let mut corner = |x: f32, y: f32| {
            let p = (random.direction() * 20.0).round().as_vec3() + 64.0 * Vec3::new(x, y, 0.0);
            by + scale * p
        };
        let [p00, p10] = [corner(0.0, 0.0), corner(1.0, 0.0)];
        let [p01, p11] = [corner(0.0, 1.0), corner(1.0, 1.0)];
        let patch = BilinearPatch { p00, p10, p01, p11 };
        let sixteenths = |random: &mut Random| (1 + random.bits() % 15) as f32 / 16.0;
        let uv = Vec2::new(sixteenths(&mut random), sixteenths(&mut random));
        let normal = patch.normal(uv).as_dvec3();
        rays_from(&mut random, patch.position(uv), normal, |ray| {
            assert_eq!(patch.closest_t(&ray), Some(0.0), "{patch:?} {ray:?}");
        });
    }
}

#[test]
fn a_ray_exactly_along_a_ruling_misses() {
    let mut random = Random(6);
    let mut count = 0;
    while count < 20_000 {
        let (scale, by) = placed(&mut random);
        let mut vector = |size: f64| (random.direction() * size).round().as_vec3();
        let (start, end) = (vector(40.0), vector(40.0));
        let (a, b) = (vector(20.0), vector(20.0));
        if start.distance(end) < 8.0 {
            continue;
        }
        count += 1;
        // The ruling from `start` to `end` is that of u = 1/2 or 1/4.
        let (share, at) = ([1.0, 3.0][count % 2], |p: Vec3| by + scale * p);
        let [p00, p10, p01, p11] = [start - a, start + share * a, end - b, end + share * b].map(at);
        let patch = BilinearPatch { p00, p10, p01, p11 };
        let exchanged = BilinearPatch { p10: p01, p01: p10, ..patch };
        let along = end - start;
        let ray = Ray::new(at(start - 2.0 * along), scale * along);
        for patch in [patch, exchanged] {
            assert_eq!(patch.closest(&ray), None, "{patch:?} {ray:?}");
            assert!(!patch.any(&ray), "{patch:?} {ray:?}");
        }
    }
}

/// The distance of a point from the cylinder of this radius about an axis parallel to x.
fn off_cylinder(p: Vec3, axis: Vec3, radius: f32) -> f64 {
    let p = wide(p) - wide(axis);
    let apart = p.y * p.y + p.z * p.z;
    let radius: Wide = radius.into();
    ((apart - radius * radius) / (apart.sqrt() + radius)).abs().to_f64()
}

/// A fibre of a length of 2·10⁵ radii was off by 10⁻⁵ radii in the middle, on one side of it.
#[test]
fn the_error_of_a_hit_next_to_the_origin_covers_what_f64_has_lost() {
    let mut random = Random(4);
    let mut hits = 0;
    while hits < 200_000 {
        let radius = 10_f64.powf(random.range(-7.0, 0.0)) as f32;
        let axis = Vec3::new(0.0, 0.0, -radius);
        let fibre = RoundedCone {
            p0: axis - 5.0 * Vec3::X,
            r0: radius,
            p1: axis + 5.0 * Vec3::X,
            r1: radius,
        };
        let aside = f64::from(radius) * 10_f64.powf(random.range(-12.0, 0.0));
        let target = DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), 0.0) * aside;
        let direction = random.direction();
        let direction = if direction.z > 0.0 { -direction } else { direction };
        let far = 10_f64.powf(random.range(-1.0, 3.0));
        let ray = ray(target - far * direction, direction);
        let Some(hit) = fibre.closest(&ray) else { continue };
        if hit.position.x.abs() > 4.0 {
            continue;
        }
        hits += 1;
        let off = off_cylinder(hit.position, axis, radius);
        assert!(off <= f64::from(hit.error), "{off:e}: {fibre:?} {ray:?} {hit:?}");
        // A few roundings of `f64`, of what its coordinates and the distance are.
        let lost = 2_f64.powi(-50) * (5.0 + far);
        let tight = f64::from(rounding_error(hit.position)) + lost;
        assert!(f64::from(hit.error) <= 1.01 * tight, "{tight:e}: {fibre:?} {ray:?} {hit:?}");
        let out = hit.spawn(hit.normal);
        assert_eq!(fibre.closest(&out), None, "{fibre:?} {hit:?}");
    }
}

#[test]
fn a_ray_into_a_solid_starts_inside_if_the_radius_is_sixteen_bounds_of_its_rounding() {
    let mut random = Random(5);
    let mut count = 0;
    while count < 200_000 {
        let place = random.direction() * 10_f64.powf(random.range(-2.0, 6.0));
        let bound = rounding_error(place.as_vec3());
        let radius = bound * random.range(16.5, 1e4) as f32;
        let sphere = Sphere { center: place.as_vec3(), radius };
        let d = random.direction();
        let aside = random.across(d) * (f64::from(radius) * random.range(0.0, 1.0));
        let origin = place + aside - d * (100.0 * f64::from(radius) + 1.0);
        let Some(hit) = sphere.closest(&ray(origin, d)) else { continue };
        count += 1;
        let out = random.direction();
        let n = hit.normal.as_dvec3();
        let into = if out.dot(n) > 0.0 { -out } else { out };
        let into = hit.spawn(into.as_vec3());
        let from_center = (wide(into.origin) - wide(sphere.center)).length();
        assert!(from_center < radius.into(), "{sphere:?} {hit:?} {into:?}");
        let again: Option<Hit> = sphere.closest(&into);
        assert!(again.is_some_and(|exit| exit.normal.dot(into.direction) >= 0.0), "{sphere:?}");
    }
}
