//! Intervals of lines inside solids, and points inside solids, against their definition with 106
//! bits.

mod support;

use rotund_geometry::glam::Vec3;
use rotund_geometry::{End, Ray, RoundedCone, Solid, Sphere};
use std::cmp::Ordering;
use support::{Random, Wide, Wide3, at, wide};

/// Returns the distance of `x` from the nearest ball of the solid, minus its radius: positive
/// outside.
fn outside(cone: &RoundedCone, x: Wide3) -> Wide {
    let (r0, r1) = (Wide::from(cone.r0), Wide::from(cone.r1));
    let ball = |s: Wide| {
        let center = wide(cone.p0) + (wide(cone.p1) - wide(cone.p0)) * s;
        (x - center).length() - (r0 + (r1 - r0) * s)
    };
    // The sine of half the opening angle turns the perpendicular foot into the place of the ball.
    let e = wide(cone.p1) - wide(cone.p0);
    let (length, rho) = (e.length(), r0 - r1);
    let ends = ball(Wide::ZERO).min(ball(Wide::ONE));
    if rho.abs() >= length {
        return ends;
    }
    let along = (x - wide(cone.p0)).dot(e) / length;
    let across = (x - wide(cone.p0)).cross(e).length() / length;
    let slope = rho / (length * length - rho * rho).sqrt();
    let s = (along - across * slope) / length;
    if s > Wide::ZERO && s < Wide::ONE { ends.min(ball(s)) } else { ends }
}

/// Checks the interval of a line against the sign of the distance on either side of its ends.
fn check<S: Solid + std::fmt::Debug>(solid: &S, cone: &RoundedCone, ray: &Ray) -> bool {
    let exact = solid.interval_exactly(ray);
    let found = solid.interval(ray);
    assert_eq!(exact.is_some(), found.is_some(), "{solid:?} {ray:?}");
    let (Some(exact), Some(found)) = (exact, found) else {
        assert_eq!(solid.closest(&Ray { t_min: f32::NEG_INFINITY, ..*ray }), None);
        return false;
    };
    assert!(found.entry <= found.exit, "{found:?} {solid:?} {ray:?}");
    assert!(found.error.is_nan() || found.error >= 0.0);
    let step = found.error + 1e-13 * (found.exit - found.entry) + 1e-22 * found.exit.abs();
    if step < 0.1 * (found.exit - found.entry) {
        let is_outside = |t: f64| outside(cone, at(ray, Wide::from(t))) > Wide::ZERO;
        for (end, t) in [(-1.0, found.entry), (1.0, found.exit)] {
            assert!(is_outside(t + end * step), "{end} {found:?} {solid:?} {ray:?}");
            assert!(!is_outside(t - end * step), "{end} {found:?} {solid:?} {ray:?}");
        }
    }
    for end in [End::Entry, End::Exit] {
        let t = found.end(end);
        // Both numbers of an end are within the error of each other.
        for (side, beyond) in [(-1.0, Ordering::Greater), (1.0, Ordering::Less)] {
            let t = t + side * (found.error + f64::EPSILON * t.abs());
            let rounded = if side < 0.0 { (t as f32).next_down() } else { (t as f32).next_up() };
            assert_eq!(exact.compare_with(end, rounded), beyond, "{found:?} {exact:?}");
        }
        let hit = solid.crossing(ray, end).expect("the line meets the solid");
        let unit = 2f64.powi(-24) * t.abs() + f64::from(f32::MIN_POSITIVE);
        let off = (f64::from(hit.t) - t).abs();
        assert!(off <= 1.01 * unit + 2.0 * found.error, "{hit:?} {found:?} {solid:?} {ray:?}");
        let inwards = f64::from(hit.normal.dot(ray.direction.normalize()));
        let sign = if end == End::Entry { -1.0 } else { 1.0 };
        assert!(sign * inwards >= -1e-6, "{end:?} {hit:?} {solid:?} {ray:?}");
    }
    if found.entry >= 0.0 {
        assert_eq!(solid.crossing(ray, End::Entry), solid.closest(ray), "{solid:?} {ray:?}");
    }
    true
}

/// A line near a ball: through it, tangent to it, or past it, from near or far.
fn line(random: &mut Random, center: Vec3, radius: f32) -> Ray {
    let direction = random.direction();
    let side = random.across(direction).as_vec3();
    let direction = direction.as_vec3() * random.power(2.0);
    let offset = match random.below(3) {
        0 => random.signed(),
        1 => 1.0 + random.signed() * random.power(6.0).min(1.0) * 1e-3,
        _ => 2.0 * random.signed(),
    };
    let back = direction.normalize() * radius * random.power(3.0);
    Ray::new(center + side * (radius * offset) - back, direction)
}

#[test]
fn the_interval_of_a_sphere_is_bounded_by_its_error() {
    let mut random = Random(0x51A7_0C3D);
    let mut hits = 0;
    for _ in 0..100_000 {
        let radius = random.power(4.0);
        let center = random.in_cube() * random.power(4.0) * radius;
        let ball = Sphere { center, radius };
        let cone = RoundedCone { p0: center, r0: radius, p1: center, r1: radius };
        let ray = line(&mut random, center, radius);
        hits += u32::from(check(&ball, &cone, &ray));
        check(&cone, &cone, &ray);
    }
    assert!(hits > 30_000, "{hits}");
}

#[test]
fn the_interval_of_a_cone_is_bounded_by_its_error() {
    let mut random = Random(0x7B1E_D001);
    let mut hits = 0;
    for _ in 0..200_000 {
        let size = random.power(3.0);
        let p0 = random.in_cube() * random.power(4.0) * size;
        let p1 = p0 + size * random.power(1.5) * random.in_cube();
        let (r0, r1) = (size * random.power(1.0), size * random.power(1.0));
        let r1 = if random.below(4) == 0 { r0 } else { r1 };
        let cone = RoundedCone { p0, r0, p1, r1 };
        let (center, radius) = if random.below(2) == 0 { (p0, r0) } else { (p1, r1) };
        hits += u32::from(check(&cone, &cone, &line(&mut random, center, radius)));
    }
    assert!(hits > 80_000, "{hits}");
}

#[test]
fn a_point_is_inside_by_its_distance_with_106_bits() {
    let mut random = Random(0x0DDB_A115);
    let mut inside = 0;
    for _ in 0..300_000 {
        let size = random.power(3.0);
        let p0 = random.in_cube() * random.power(4.0) * size;
        let p1 = p0 + size * random.power(1.5) * random.in_cube();
        let (r0, r1) = (size * random.power(1.0), size * random.power(1.0));
        let cone = RoundedCone { p0, r0, p1, r1 };
        let ball = Sphere { center: p0, radius: r0 };
        let as_cone = RoundedCone { p1: p0, r1: r0, ..cone };
        // On the surface as well as f32 can tell, or anywhere near.
        let point = match random.below(3) {
            0 => match cone.closest(&line(&mut random, p0, r0)) {
                Some(hit) => hit.position,
                None => continue,
            },
            1 => p0 + r0 * random.direction().as_vec3(),
            _ => p0 + 2.0 * size * random.in_cube(),
        };
        let expected = outside(&cone, wide(point)) <= Wide::ZERO;
        assert_eq!(cone.contains(point), expected, "{cone:?} {point:?}");
        inside += u32::from(expected);
        let expected = outside(&as_cone, wide(point)) <= Wide::ZERO;
        assert_eq!(ball.contains(point), expected, "{ball:?} {point:?}");
        assert_eq!(as_cone.contains(point), expected, "{ball:?} {point:?}");
    }
    assert!(inside > 50_000, "{inside}");
}

#[test]
fn degenerate_solids_and_lines() {
    let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
    let cone = RoundedCone::default();
    for ray in [
        Ray::new(Vec3::NAN, Vec3::X),
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::ZERO, Vec3::splat(f32::INFINITY)),
        Ray::new(Vec3::splat(f32::INFINITY), Vec3::X),
        Ray::new(Vec3::ZERO, Vec3::NAN),
    ] {
        assert_eq!(ball.interval(&ray), None, "{ray:?}");
        assert_eq!(cone.interval(&ray), None, "{ray:?}");
        for end in [End::Entry, End::Exit] {
            assert_eq!(ball.crossing(&ray, end), None, "{ray:?}");
            assert_eq!(cone.crossing(&ray, end), None, "{ray:?}");
        }
    }
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    for radius in [0.0, -1.0, f32::NAN] {
        let ball = Sphere { radius, ..ball };
        assert_eq!((ball.interval(&ray), ball.contains(Vec3::ZERO)), (None, false), "{radius}");
        let cone = RoundedCone { r0: radius, r1: radius, ..cone };
        assert_eq!((cone.interval(&ray), cone.contains(Vec3::ZERO)), (None, false), "{radius}");
    }
    for point in [Vec3::NAN, Vec3::splat(f32::INFINITY)] {
        assert!(!ball.contains(point) && !cone.contains(point));
    }
    // A tip, a ball inside of the other, and a segment without length.
    let tip = RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: 2.0 * Vec3::X, r1: 0.0 };
    assert!(tip.contains(2.0 * Vec3::X) && !tip.contains(2.001 * Vec3::X));
    let along = tip.interval(&ray).expect("along the axis");
    assert!((along.entry + 1.0).abs() < 1e-9 && (along.exit - 2.0).abs() < 1e-9, "{along:?}");
    for cone in [
        RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: 0.5 * Vec3::X, r1: 0.25 },
        RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::ZERO, r1: 1.0 },
    ] {
        let found = cone.interval(&ray).expect("through the center");
        assert_eq!((found.entry, found.exit), (-1.0, 1.0));
        assert!(cone.contains(Vec3::X) && !cone.contains(1.001 * Vec3::X));
    }
}
