//! The sphere against its definition, evaluated with 106 bits.

mod support;

use rotund_geometry::glam::{Vec2, Vec3};
use rotund_geometry::{Ray, Sphere};
use support::{Random, Wide, at, degrees, local_unit, ray, rounding_interval, wide};

const BALL: Sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };

/// Returns `|x - c|² - r²` at `t`, which is positive outside.
fn side(sphere: &Sphere, ray: &Ray, t: Wide) -> Wide {
    let x = at(ray, t) - wide(sphere.center);
    x.dot(x) - Wide::from(sphere.radius) * Wide::from(sphere.radius)
}

/// Returns the `t` of the point of the line that is closest to the center.
fn closest_approach(sphere: &Sphere, ray: &Ray) -> Wide {
    let d = wide(ray.direction);
    (wide(sphere.center) - wide(ray.origin)).dot(d) / d.dot(d)
}

/// Checks all that is documented for one ray with `t_min` 0, and returns whether it hits.
fn check(sphere: &Sphere, ray: &Ray) -> bool {
    let middle = closest_approach(sphere, ray);
    let passes = side(sphere, ray, middle) > Wide::ZERO;
    let starts_inside = side(sphere, ray, Wide::ZERO) < Wide::ZERO;
    let expected = !passes && (starts_inside || middle > Wide::ZERO);
    let hit = sphere.closest(ray);
    assert_eq!(hit.is_some(), expected, "{sphere:?} {ray:?}");
    assert_eq!(sphere.any(ray), expected, "{sphere:?} {ray:?}");
    assert_eq!(sphere.closest_t(ray), hit.map(|hit| hit.t), "{sphere:?} {ray:?}");
    let Some(hit) = hit else { return false };

    let d = wide(ray.direction);
    let half_chord = (-side(sphere, ray, middle) / d.dot(d)).sqrt();
    let t = if starts_inside { middle + half_chord } else { middle - half_chord };
    let [low, high] = rounding_interval(hit.t);
    assert!(low <= t && t <= high, "t is not the rounded root: {sphere:?} {ray:?} {hit:?}");

    let from_center = hit.position.as_dvec3() - sphere.center.as_dvec3();
    let off = (from_center.length() - f64::from(sphere.radius)).abs();
    assert!(off <= 1.0 * local_unit(hit.position, sphere.radius), "{off}: {sphere:?} {ray:?}");
    assert!(off <= f64::from(hit.error), "{off} beyond {}: {sphere:?} {ray:?}", hit.error);

    let from_center = (at(ray, t) - wide(sphere.center)).to_f64();
    let off = degrees(hit.normal, from_center);
    assert!(off <= 5e-6, "normal off by {off} degrees: {sphere:?} {ray:?}");
    assert!((hit.normal.length() - 1.0).abs() < 2e-7, "{hit:?}");

    let bounds = sphere.bounds();
    assert!(hit.position.cmpge(bounds.min).all() && hit.position.cmple(bounds.max).all());

    let uv = sphere.uv(&hit);
    assert!(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all(), "{uv}");
    let rebuilt = sphere.position(uv);
    assert!(rebuilt.distance(hit.position) <= 8.0 * local_unit(hit.position, sphere.radius) as f32);
    true
}

/// Returns a ray from `distance` away that passes the center at the distance `aside`.
fn aimed(random: &mut Random, sphere: &Sphere, distance: f64, aside: f64, length: f64) -> Ray {
    let d = random.direction();
    let target = sphere.center.as_dvec3() + aside * random.across(d);
    ray(target - distance * d, d * length)
}

fn somewhere(random: &mut Random, radius: f64, offset: f64) -> Sphere {
    let center = random.direction() * random.range(0.0, 2.0) * radius + offset * random.direction();
    Sphere { center: center.as_vec3(), radius: radius as f32 }
}

#[test]
fn hard_cases() {
    let ray = |o: [f32; 3], d: [f32; 3]| Ray::new(o.into(), d.into());
    let from = |t_min, ray: Ray| Ray { t_min, ..ray };
    let to = |t_max, ray: Ray| Ray { t_max, ..ray };
    let ahead = ray([0., 0., -5.], [0., 0., 1.]);
    let table = [
        // why it is hard, ray, t
        ("enters from outside", ahead, Some(4.0)),
        ("a direction of length 4", ray([0., 0., -5.], [0., 0., 4.]), Some(1.0)),
        ("tangent: the roots coincide", ray([1., 0., -5.], [0., 0., 1.]), Some(5.0)),
        ("starts at the center", ray([0.; 3], [0., 1., 0.]), Some(1.0)),
        ("starts on the surface, going in", ray([0., 0., -1.], [0., 0., 1.]), Some(0.0)),
        ("starts on the surface, going out", ray([0., 0., 1.], [0., 0., 1.]), Some(0.0)),
        ("the interval starts on the entry", from(4.0, ahead), Some(4.0)),
        ("the interval starts after the entry", from(4.000001, ahead), Some(6.0)),
        ("the interval starts on the exit", from(6.0, ahead), Some(6.0)),
        ("the interval starts after the exit", from(6.000001, ahead), None),
        ("the interval ends on the entry", to(4.0, ahead), Some(4.0)),
        ("the interval ends before the entry", to(3.9999998, ahead), None),
        ("the interval is empty", Ray { t_min: 5.0, t_max: 4.0, ..ahead }, None),
        (
            "the interval lies behind",
            Ray { t_min: -20.0, ..ray([0., 0., 5.], [0., 0., 1.]) },
            Some(-6.0),
        ),
        ("behind", ray([0., 0., 5.], [0., 0., 1.]), None),
        ("a zero direction", ray([0., 0., 5.], [0.; 3]), None),
        ("a zero direction, inside", ray([0.; 3], [0.; 3]), None),
        ("the smallest direction", ray([0., 0., -5.], [0., 0., 1e-38]), Some(4e38_f64 as f32)),
        ("t overflows", ray([0., 0., -5.], [0., 0., 1e-40]), None),
        ("NaN in the origin", ray([f32::NAN, 0., -5.], [0., 0., 1.]), None),
        ("NaN in the direction", ray([0., 0., -5.], [f32::NAN, 0., 1.]), None),
        ("NaN in t_min", from(f32::NAN, ahead), None),
        ("NaN in t_max", to(f32::NAN, ahead), None),
        ("an infinite origin", ray([0., 0., f32::NEG_INFINITY], [0., 0., 1.]), None),
        ("an infinite direction", ray([0., 0., -5.], [0., 0., f32::INFINITY]), None),
    ];
    for (why, ray, t) in table {
        let t = t.filter(|t: &f32| t.is_finite());
        assert_eq!(BALL.closest(&ray).map(|hit| hit.t), t, "{why}");
        assert_eq!(BALL.closest_t(&ray), t, "{why}");
        assert_eq!(BALL.any(&ray), t.is_some(), "{why}");
    }
}

#[test]
fn a_radius_that_is_not_positive_or_not_finite_misses() {
    let through = Ray::new(Vec3::new(0.0, 0.0, -5.0), Vec3::Z);
    for radius in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(Sphere { radius, ..BALL }.closest(&through), None, "{radius}");
    }
}

#[test]
fn the_distance_of_the_ray_does_not_reduce_the_accuracy() {
    let mut random = Random(1);
    for power in 0..7 {
        let mut hits = 0;
        for _ in 0..5000 {
            let sphere = somewhere(&mut random, 1.0, 0.0);
            let aside = 1.2 * random.range(0.0, 1.0).sqrt();
            hits += u32::from(check(
                &sphere,
                &aimed(&mut random, &sphere, 1.5 * 10_f64.powi(power), aside, 1.0),
            ));
        }
        assert!((2500..4500).contains(&hits), "{hits} hits at 10^{power}");
    }
}

#[test]
fn grazing_rays_are_decided_exactly() {
    let mut random = Random(2);
    for power in 1..12 {
        for sign in [-1.0, 1.0] {
            for _ in 0..1000 {
                let sphere = somewhere(&mut random, 1.0, 0.0);
                let aside = 1.0 + sign * 10_f64.powi(-power);
                check(&sphere, &aimed(&mut random, &sphere, 10.0, aside, 1.0));
            }
        }
    }
}

#[test]
fn radius_offset_and_length_of_the_direction_do_not_reduce_the_accuracy() {
    let mut random = Random(3);
    for radius in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        for offset in [0.0, 1e3, 1e6] {
            for _ in 0..1000 {
                let sphere = somewhere(&mut random, radius, offset * radius);
                let length = 10_f64.powf(random.range(-3.0, 3.0));
                let aside = 1.2 * radius * random.range(0.0, 1.0).sqrt();
                check(&sphere, &aimed(&mut random, &sphere, 10.0 * radius, aside, length));
            }
        }
    }
}

#[test]
fn a_ray_from_inside_hits_the_exit() {
    let mut random = Random(4);
    for _ in 0..20_000 {
        let sphere = somewhere(&mut random, 1.0, 0.0);
        let inside = sphere.center.as_dvec3() + random.direction() * random.range(0.0, 0.999);
        let from_inside = ray(inside, random.direction());
        assert!(check(&sphere, &from_inside));
        let hit = sphere.closest(&from_inside).expect("an exit");
        assert!(hit.normal.dot(from_inside.direction) > 0.0, "leaving");
    }
}

#[test]
fn a_ray_from_the_surface_is_decided_by_its_exact_side() {
    let mut random = Random(5);
    for _ in 0..20_000 {
        let sphere = somewhere(&mut random, 1.0, 0.0);
        let surface = sphere.center.as_dvec3() + random.direction();
        check(&sphere, &ray(surface, random.direction()));
    }
}

#[test]
fn longitude_runs_from_x_towards_z_and_the_polar_angle_from_y() {
    let table = [
        ([0.0, 0.5], Vec3::X),
        ([0.25, 0.5], Vec3::Z),
        ([0.5, 0.5], Vec3::NEG_X),
        ([0.75, 0.5], Vec3::NEG_Z),
        ([0.0, 0.0], Vec3::Y),
        ([0.0, 1.0], Vec3::NEG_Y),
    ];
    for (uv, point) in table {
        assert!(BALL.position(uv.into()).distance(point) < 1e-7, "{uv:?}");
        assert!(BALL.normal(uv.into()).distance(point) < 1e-7, "{uv:?}");
    }
}

#[test]
fn tangents_are_the_derivatives_of_the_position() {
    let sphere = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 2.5 };
    let mut random = Random(6);
    for _ in 0..1000 {
        let uv = Vec2::new(random.range(0.01, 0.99) as f32, random.range(0.01, 0.99) as f32);
        let (du, dv) = sphere.tangents(uv);
        let h = 1e-2;
        let by = |step: Vec2| (sphere.position(uv + step) - sphere.position(uv - step)) / (2.0 * h);
        assert!(by(Vec2::new(h, 0.0)).distance(du) < 2e-3 * (1.0 + du.length()), "{uv}");
        assert!(by(Vec2::new(0.0, h)).distance(dv) < 2e-3 * (1.0 + dv.length()), "{uv}");
        let n = sphere.normal(uv);
        assert!(n.dot(du).abs() < 1e-5 * du.length() && n.dot(dv).abs() < 1e-5 * dv.length());
    }
}
