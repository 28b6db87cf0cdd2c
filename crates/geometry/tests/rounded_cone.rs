//! The rounded cone against its definition as a union of balls, whose signed distance is convex.

mod support;

use rotund_geometry::glam::{Vec2, Vec3};
use rotund_geometry::{Ray, RoundedCone, Sphere, UNIT_ROUNDOFF};
use support::{Random, Wide, Wide3, at, local_unit, ray, rounding_interval, wide};

const FAT: RoundedCone =
    RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::new(0.0, 0.0, 3.0), r1: 0.5 };

/// Returns the signed distance of `x`: the minimum of `|x - c(s)| - r(s)` over the balls
/// `0 <= s <= 1`.
///
/// The minimizer is computed in `f64`. Near a minimum the value depends on the square of the error
/// of `s`, so it has the digits of [`Wide`].
fn distance(cone: &RoundedCone, x: Wide3) -> Wide {
    let (p0, e) = (wide(cone.p0), wide(cone.p1) - wide(cone.p0));
    let (r0, r1) = (Wide::from(cone.r0), Wide::from(cone.r1));
    let x = x - p0;
    let value = |s: f64| {
        let s = Wide::from(s);
        let from = x - e * s;
        from.length() - (r0 + s * (r1 - r0))
    };
    // The zero of the derivative: the foot of x on the axis, shifted along it by the slope of the
    // cone.
    let (length2, rho) = (e.dot(e), r0 - r1);
    let d2 = length2 - rho * rho;
    let ends = if value(0.0) < value(1.0) { value(0.0) } else { value(1.0) };
    if d2 <= Wide::ZERO {
        return ends;
    }
    let along = x.dot(e);
    let radial2 = x.dot(x) - along * along / length2;
    let radial = radial2.sqrt();
    let s = (along - radial * rho * length2.sqrt() / d2.sqrt()) / length2;
    // The minimum over this s and both ends is correct whatever the rounding of s.
    let s = s.to_f64().clamp(0.0, 1.0);
    let inner = value(s);
    if inner < ends { inner } else { ends }
}

fn at_t(cone: &RoundedCone, ray: &Ray, t: Wide) -> Wide {
    distance(cone, at(ray, t))
}

/// Returns the `t` of the smallest distance between `low` and `high`, by ternary search: it is
/// convex.
fn deepest(cone: &RoundedCone, ray: &Ray, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..110 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at_t(cone, ray, a.into()) < at_t(cone, ray, b.into()) { high = b } else { low = a }
    }
    0.5 * (low + high)
}

/// Checks all that is documented for one ray with `t_min` 0, and returns whether it hits.
fn check(cone: &RoundedCone, ray: &Ray) -> bool {
    let size = cone.p0.distance(cone.p1) + cone.r0 + cone.r1;
    let hit = cone.closest(ray);
    assert_eq!(cone.any(ray), hit.is_some(), "{cone:?} {ray:?}");
    assert_eq!(cone.closest_t(ray), hit.map(|hit| hit.t), "{cone:?} {ray:?}");
    let length = f64::from(ray.direction.length());
    let far = 4.0 * f64::from(size + ray.origin.distance(cone.p0)) / length;
    let Some(hit) = hit else {
        let t = deepest(cone, ray, 0.0, far);
        let depth = at_t(cone, ray, t.into()).to_f64();
        assert!(depth > -1e-13 * f64::from(size), "missed {depth} deep: {cone:?} {ray:?}");
        return false;
    };
    let starts_inside = at_t(cone, ray, Wide::ZERO) < Wide::ZERO;
    let [before, after] = rounding_interval(hit.t).map(|t| at_t(cone, ray, t).to_f64());
    // If the chord is shorter than the rounding of t, both ends of the interval are outside.
    let crosses = if starts_inside {
        before <= 0.0 && after >= 0.0
    } else {
        before >= 0.0
            && (after <= 0.0 || {
                let [low, high] = rounding_interval(hit.t);
                let t = deepest(cone, ray, low.to_f64(), high.to_f64());
                at_t(cone, ray, t.into()).to_f64() <= 1e-13 * f64::from(size)
            })
    };
    assert!(crosses, "{before} to {after} is no crossing: {cone:?} {ray:?} {hit:?}");

    let off = distance(cone, wide(hit.position)).to_f64().abs();
    let unit = local_unit(hit.position, size);
    assert!(off <= 1.1 * unit, "{} u off: {cone:?} {ray:?}", off / unit);
    assert!(off <= f64::from(hit.error), "{off} beyond {}: {cone:?} {ray:?}", hit.error);
    assert!((hit.normal.length() - 1.0).abs() < 3e-7, "{cone:?} {ray:?} {hit:?}");

    let bounds = cone.bounds();
    assert!(hit.position.cmpge(bounds.min).all() && hit.position.cmple(bounds.max).all());

    let uv = cone.uv(&hit);
    assert!(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all(), "{uv}");
    let rebuilt = cone.position(uv);
    let off = distance(cone, wide(rebuilt)).to_f64().abs() / local_unit(rebuilt, size);
    assert!(off <= 1.1, "rebuilt {off} u off: {cone:?} {uv}");
    let off = f64::from(rebuilt.distance(hit.position)) / unit;
    assert!(off <= 8.0, "rebuilt {off} u away: {cone:?} {ray:?} {uv}");
    true
}

fn cone(random: &mut Random, length: f64, r0: f64, r1: f64) -> RoundedCone {
    let p0 = random.direction() * random.range(0.0, 2.0) * r0.max(r1);
    let p1 = p0 + length * random.direction();
    RoundedCone { p0: p0.as_vec3(), r0: r0 as f32, p1: p1.as_vec3(), r1: r1 as f32 }
}

/// Returns a ray from `distance` away towards a point in or near the shape.
fn aimed(random: &mut Random, cone: &RoundedCone, distance: f64) -> Ray {
    let s = random.range(-0.15, 1.15);
    let (p0, p1) = (cone.p0.as_dvec3(), cone.p1.as_dvec3());
    let radius = f64::from(cone.r0) + s.clamp(0.0, 1.0) * f64::from(cone.r1 - cone.r0);
    let d = random.direction();
    let aside = 1.25 * radius * random.range(0.0, 1.0).sqrt();
    let target = p0 + s * (p1 - p0) + aside * random.across(d);
    ray(target - distance * d, d)
}

fn check_family(seed: u64, count: u32, mut make: impl FnMut(&mut Random) -> (RoundedCone, Ray)) {
    let mut random = Random(seed);
    let hits: u32 = (0..count)
        .map(|_| {
            let (cone, ray) = make(&mut random);
            u32::from(check(&cone, &ray))
        })
        .sum();
    assert!(hits * 10 > count, "only {hits} of {count} rays hit");
}

#[test]
fn hard_cases() {
    let ray = |o: [f32; 3], d: [f32; 3]| Ray::new(o.into(), d.into());
    let nested = RoundedCone { p1: Vec3::new(0.0, 0.0, 0.25), ..FAT };
    let cylinder = RoundedCone { r1: 1.0, ..FAT };
    let tip = RoundedCone { r1: 0.0, ..FAT };
    let touching = RoundedCone { p1: Vec3::new(0.0, 0.0, 0.5), ..FAT };
    let table = [
        // why it is hard, shape, ray, t
        ("enters through the cap of p0", FAT, ray([0., 0., -5.], [0., 0., 1.]), Some(4.0)),
        ("enters through the cap of p1", FAT, ray([0., 0., 8.], [0., 0., -1.]), Some(4.5)),
        ("starts inside: leaves through p1", FAT, ray([0., 0., 0.], [0., 0., 1.]), Some(3.5)),
        ("starts inside: leaves through p0", FAT, ray([0., 0., 1.], [0., 0., -1.]), Some(2.0)),
        ("a direction of length 4", FAT, ray([0., 0., -5.], [0., 0., 4.]), Some(1.0)),
        ("along the axis of a cylinder", cylinder, ray([0., 0., -5.], [0., 0., 1.]), Some(4.0)),
        ("along a cylinder, inside", cylinder, ray([0., 0., 1.], [0., 0., 1.]), Some(3.0)),
        ("along a cylinder, on its side", cylinder, ray([1., 0., -5.], [0., 0., 1.]), Some(5.0)),
        ("along a cylinder, outside", cylinder, ray([1.5, 0., -5.], [0., 0., 1.]), None),
        ("across a cylinder", cylinder, ray([-5., 0., 1.5], [1., 0., 0.]), Some(4.0)),
        ("tangent to a cylinder", cylinder, ray([-5., 1., 1.5], [1., 0., 0.]), Some(5.0)),
        ("one ball contains the other", nested, ray([5., 0., 0.], [-1., 0., 0.]), Some(4.0)),
        (
            "one ball touches the other from inside",
            touching,
            ray([5., 0., 0.], [-1., 0., 0.]),
            Some(4.0),
        ),
        ("straight at a tip", tip, ray([0., 0., 8.], [0., 0., -1.]), Some(5.0)),
        (
            "beyond a tip, inside the other half of the cone",
            tip,
            ray([0., 0., 4.], [0., 0., 1.]),
            None,
        ),
        ("behind", FAT, ray([0., 0., 9.], [0., 0., 1.]), None),
        ("a zero direction", FAT, ray([0., 3., 0.], [0.; 3]), None),
        ("NaN in the origin", FAT, ray([f32::NAN, 0., -5.], [0., 0., 1.]), None),
        ("NaN in the direction", FAT, ray([0., 0., -5.], [0., f32::NAN, 1.]), None),
        ("an infinite direction", FAT, ray([0., 0., -5.], [0., 0., f32::INFINITY]), None),
        (
            "an infinite end",
            RoundedCone { p1: Vec3::INFINITY, ..FAT },
            ray([0., 0., -5.], [0., 0., 1.]),
            None,
        ),
        (
            "NaN in a radius that does not matter",
            RoundedCone { r1: f32::NAN, ..nested },
            ray([5., 0., 0.], [-1., 0., 0.]),
            None,
        ),
        (
            "a negative radius",
            RoundedCone { r1: -0.5, ..FAT },
            ray([0., 0., -5.], [0., 0., 1.]),
            None,
        ),
        (
            "both radii are zero",
            RoundedCone { r0: 0.0, r1: 0.0, ..FAT },
            ray([0., -5., 1.], [0., 1., 0.]),
            None,
        ),
    ];
    for (why, cone, ray, t) in table {
        let hit = cone.closest(&ray);
        assert_eq!(hit.map(|hit| hit.t), t, "{why}");
        assert_eq!(cone.any(&ray), t.is_some(), "{why}");
        assert!(hit.is_none_or(|hit| (hit.normal.length() - 1.0).abs() < 1e-6), "{why}: {hit:?}");
    }
}

#[test]
fn the_distance_of_the_ray_does_not_reduce_the_accuracy() {
    for power in 0..7 {
        check_family(10 + power as u64, 400, |random| {
            let cone = cone(random, 3.0, 1.0, 0.5);
            let ray = aimed(random, &cone, 4.0 * 10_f64.powi(power));
            (cone, ray)
        });
    }
}

#[test]
fn radii_may_be_equal_nearly_equal_or_zero() {
    for (i, r1) in [0.7, 0.7 - 7e-3, 0.7 - 7e-5, 0.7 - 7e-7, 0.0].into_iter().enumerate() {
        check_family(20 + i as u64, 600, |random| {
            let cone = cone(random, 3.0, 0.7, r1);
            let ray = aimed(random, &cone, 4.0);
            (cone, ray)
        });
    }
}

#[test]
fn one_ball_may_contain_or_nearly_contain_the_other() {
    for (i, length) in [0.0, 0.4, 0.5 + 5e-7, 0.5 + 5e-4, 0.55].into_iter().enumerate() {
        check_family(30 + i as u64, 600, |random| {
            let cone = cone(random, length, 1.0, 0.5);
            let ray = aimed(random, &cone, 4.0);
            (cone, ray)
        });
    }
}

#[test]
fn length_over_radius_goes_from_1e_5_to_1e5() {
    for (i, length) in [1e-5, 1e-3, 1.0, 1e3, 1e5].into_iter().enumerate() {
        check_family(40 + i as u64, 400, |random| {
            let cone = cone(random, length, 1.0, 0.999);
            let ray = aimed(random, &cone, length.max(4.0));
            (cone, ray)
        });
    }
}

#[test]
fn rays_may_run_along_the_axis() {
    for (i, tilt) in [0.0, 1e-7, 1e-5, 1e-3].into_iter().enumerate() {
        for (j, r1) in [0.5, 1.0].into_iter().enumerate() {
            check_family(50 + 2 * i as u64 + j as u64, 300, |random| {
                let cone = cone(random, 3.0, 1.0, r1);
                let axis = (cone.p1 - cone.p0).as_dvec3();
                let axis = if random.bits().is_multiple_of(2) { axis } else { -axis };
                let aside = random.across(axis) * random.range(0.0, 1.2);
                let d = (axis + tilt * random.across(axis)).as_vec3();
                let target = 0.5 * (cone.p0 + cone.p1).as_dvec3() + aside;
                (cone, ray(target - 2.0 * d.as_dvec3(), d.as_dvec3()))
            });
        }
    }
}

#[test]
fn rays_from_inside_exit_and_rays_from_the_surface_are_decided_by_their_exact_side() {
    for scale in [0.0, 0.5, 0.999, 1.0] {
        check_family(60, 500, |random| {
            let cone = cone(random, 3.0, 1.0, 0.5);
            let uv = Vec2::new(random.range(0.0, 1.0) as f32, random.range(0.0, 1.0) as f32);
            let axis_point = cone.p0.as_dvec3().lerp(cone.p1.as_dvec3(), random.range(0.0, 1.0));
            let surface = cone.position(uv).as_dvec3();
            (cone, ray(axis_point.lerp(surface, scale), random.direction()))
        });
    }
}

#[test]
fn scale_and_offset_do_not_reduce_the_accuracy() {
    for (i, scale) in [1e-6, 1e-3, 1e3, 1e6].into_iter().enumerate() {
        for (j, offset) in [0.0, 1e3, 1e5].into_iter().enumerate() {
            check_family(70 + 3 * i as u64 + j as u64, 200, |random| {
                let mut cone = cone(random, 3.0 * scale, scale, 0.5 * scale);
                let shift = (random.direction() * offset * scale).as_vec3();
                (cone.p0, cone.p1) = (cone.p0 + shift, cone.p1 + shift);
                let ray = aimed(random, &cone, 10.0 * scale);
                (cone, ray)
            });
        }
    }
}

#[test]
fn normals_point_away_from_the_ball_of_the_hit() {
    let mut random = Random(90);
    for _ in 0..20_000 {
        let cone = cone(&mut random, 3.0, 1.0, 0.5);
        let ray = aimed(&mut random, &cone, 10.0);
        let Some(hit) = cone.closest(&ray) else { continue };
        let s = f64::from(hit.parameters.x);
        let center = cone.p0.as_dvec3().lerp(cone.p1.as_dvec3(), s);
        let off = support::degrees(hit.normal, hit.position.as_dvec3() - center);
        // The center and the position are rounded here, to 2⁻²⁴ of their coordinates.
        assert!(off < 1e-4, "{off} degrees: {cone:?} {ray:?} {hit:?}");
        assert!(cone.normal(cone.uv(&hit)).distance(hit.normal) < 1e-6);
    }
}

#[test]
fn a_cone_that_is_a_ball_has_the_hits_of_the_sphere() {
    let mut random = Random(91);
    for _ in 0..20_000 {
        let ball = cone(&mut random, 0.0, 1.0, 0.5);
        let sphere = Sphere { center: ball.p0, radius: 1.0 };
        let ray = aimed(&mut random, &ball, 4.0);
        let [a, b] = [ball.closest(&ray), sphere.closest(&ray)];
        assert_eq!(
            a.map(|hit| (hit.t, hit.position, hit.normal)),
            b.map(|hit| (hit.t, hit.position, hit.normal))
        );
    }
}

#[test]
fn u_runs_from_pole_to_pole_without_a_jump_and_at_constant_speed() {
    let step = 1e-3;
    let mut last = FAT.position(Vec2::new(0.0, 0.25));
    assert!(last.distance(Vec3::new(0.0, 0.0, -1.0)) < 1e-6);
    let first_step = FAT.position(Vec2::new(step, 0.25)).distance(last);
    for i in 1..=1000_u16 {
        let next = FAT.position(Vec2::new(f32::from(i) * step, 0.25));
        assert!((next.distance(last) / first_step - 1.0).abs() < 2e-3, "at {i}");
        last = next;
    }
    assert!(last.distance(Vec3::new(0.0, 0.0, 3.5)) < 1e-6);
}

#[test]
fn tangents_are_the_derivatives_of_the_position() {
    let mut random = Random(92);
    for _ in 0..1000 {
        let uv = Vec2::new(random.range(0.01, 0.98) as f32, random.range(0.01, 0.98) as f32);
        let (du, dv) = FAT.tangents(uv);
        let h = 1e-3;
        let by = |step: Vec2| (FAT.position(uv + step) - FAT.position(uv - step)) / (2.0 * h);
        assert!(by(Vec2::new(h, 0.0)).distance(du) < 2e-2 * (1.0 + du.length()), "{uv}");
        assert!(by(Vec2::new(0.0, h)).distance(dv) < 2e-2 * (1.0 + dv.length()), "{uv}");
        let n = FAT.normal(uv).as_dvec3();
        assert!(n.dot(du.as_dvec3()).abs() < 1e-5 && n.dot(dv.as_dvec3()).abs() < 1e-5);
    }
}

#[test]
fn a_ray_that_starts_on_the_body_next_to_p0_has_an_accurate_tiny_t() {
    let bits = |x: u32| f32::from_bits(x);
    let at = |x: u32, y: u32, z: u32| Vec3::new(bits(x), bits(y), bits(z));
    let cone = RoundedCone {
        p0: at(0xbea8_a6c0, 0x3fb5_8da5, 0x3f41_b313),
        r0: 1.0,
        p1: at(0x3f15_714b, 0xbe5b_1030, 0xbfcb_6213),
        r1: 0.5,
    };
    let origin = at(0x3f3d_0130, 0xbe6c_d458, 0xbf3f_54e9);
    let direction = at(0xbf25_ebb0, 0x3e75_5d34, 0xbf39_0ce1);
    // The terms of f·d are of size one and cancel to 3e-4; t is 8e-9 of them. Expected with 106
    // bits:
    let expected = 1.057_704_035_985_401_7e-8;
    let hit = cone.closest(&Ray::new(origin, direction)).expect("it enters");
    let units = (f64::from(hit.t) - expected).abs() / (expected * f64::from(UNIT_ROUNDOFF));
    assert!(units <= 1.0, "{units} units");
}
