//! The bilinear patch against its definition: planted crossings, and residuals measured in 106
//! bits.

mod support;

use rotund_geometry::glam::{Vec2, Vec3};
use rotund_geometry::{BilinearPatch, Ray};
use support::{Random, Wide, Wide3, at, degrees, local_unit, ray, wide};

const SADDLE: BilinearPatch = BilinearPatch {
    p00: Vec3::new(-1.0, -1.0, -0.5),
    p10: Vec3::new(1.0, -1.0, 0.5),
    p01: Vec3::new(-1.0, 1.0, 0.5),
    p11: Vec3::new(1.0, 1.0, -0.5),
};
const SQUARE: BilinearPatch = BilinearPatch {
    p00: Vec3::new(0.0, 0.0, 0.0),
    p10: Vec3::new(1.0, 0.0, 0.0),
    p01: Vec3::new(0.0, 1.0, 0.0),
    p11: Vec3::new(1.0, 1.0, 0.0),
};

fn lerp(a: Wide3, b: Wide3, s: Wide) -> Wide3 {
    a + (b - a) * s
}

/// Returns the exact point, and its derivatives by `u` and `v`.
fn surface(patch: &BilinearPatch, u: Wide, v: Wide) -> [Wide3; 3] {
    let [p00, p10, p01, p11] = [patch.p00, patch.p10, patch.p01, patch.p11].map(wide);
    let (low, high) = (lerp(p00, p10, u), lerp(p01, p11, u));
    let du = lerp(p10 - p00, p11 - p01, v);
    [lerp(low, high, v), du, high - low]
}

fn size(patch: &BilinearPatch) -> f32 {
    let Vec3 { x, y, z } = patch.bounds().max - patch.bounds().min;
    x.max(y).max(z)
}

/// Returns the root near the parameters of a hit, by Newton's method in three equations; `None` if
/// it does not converge.
fn exact_root(
    patch: &BilinearPatch,
    ray: &Ray,
    mut u: Wide,
    mut v: Wide,
    t: f32,
) -> Option<[Wide; 3]> {
    let mut t = Wide::from(t);
    for _ in 0..40 {
        let [p, du, dv] = surface(patch, u, v);
        let rest = (at(ray, t) - p).to_f64();
        let (du, dv, d) = (du.to_f64(), dv.to_f64(), ray.direction.as_dvec3());
        let n = du.cross(dv);
        let step_t = -rest.dot(n) / d.dot(n);
        let rest = rest + step_t * d;
        let (step_u, step_v) = (rest.cross(dv).dot(n) / n.dot(n), du.cross(rest).dot(n) / n.dot(n));
        (u, v, t) = (u + step_u.into(), v + step_v.into(), t + step_t.into());
        if step_u.abs() + step_v.abs() < 1e-24 {
            return Some([u, v, t]);
        }
    }
    None
}

/// Checks the documented accuracy of a hit, if there is one, and returns whether there is.
fn check(patch: &BilinearPatch, ray: &Ray) -> bool {
    let hit = patch.closest(ray);
    assert_eq!(patch.any(ray), hit.is_some(), "{patch:?} {ray:?}");
    assert_eq!(patch.closest_t(ray), hit.map(|hit| hit.t), "{patch:?} {ray:?}");
    let Some(hit) = hit else { return false };
    let uv = patch.uv(&hit);
    assert!(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all(), "{uv}");
    assert!((hit.normal.length() - 1.0).abs() < 3e-7, "{hit:?}");
    let bounds = patch.bounds();
    assert!(hit.position.cmpge(bounds.min).all() && hit.position.cmple(bounds.max).all());
    let rebuilt = patch.position(uv);
    let unit = local_unit(hit.position, size(patch));
    assert!(f64::from(rebuilt.distance(hit.position)) <= 3.0 * unit, "{patch:?} {ray:?}");

    let Some([u, v, t]) = exact_root(patch, ray, uv.x.into(), uv.y.into(), hit.t) else {
        return true;
    };
    // At a fold Newton's method may converge to the other root, which the position shows.
    let [p, du, dv] = surface(patch, u, v);
    let away = (p - wide(hit.position)).to_f64();
    if away.length() > 1e-3 * f64::from(size(patch)) {
        return true;
    }
    let error = (t.to_f64() - f64::from(hit.t)).abs() / (t.to_f64().abs() * 2.0_f64.powi(-24));
    assert!(error <= 1.001, "t is {error} u off: {patch:?} {ray:?} {hit:?}");
    let n = du.to_f64().cross(dv.to_f64());
    let off = away.dot(n).abs() / n.length();
    assert!(off <= 1.1 * unit, "{} u off: {patch:?} {ray:?}", off / unit);
    assert!(off <= f64::from(hit.error), "{off} beyond {}: {patch:?} {ray:?}", hit.error);
    let off = degrees(hit.normal, n);
    assert!(off <= 2e-5, "normal {off} degrees off: {patch:?} {ray:?} {hit:?}");
    true
}

/// Returns a square whose corners are at the heights `-h, h, -h, h`, jittered by a tenth, in a
/// random frame.
fn patch(random: &mut Random, h: f64, scale: f64) -> BilinearPatch {
    let z = random.direction();
    let x = random.across(z);
    let y = z.cross(x);
    let center = random.direction() * random.range(0.0, 2.0);
    let mut corner = |u: f64, v: f64, h: f64| {
        let (u, v) = (u + random.range(-0.1, 0.1), v + random.range(-0.1, 0.1));
        (scale * (center + u * x + v * y + h * z)).as_vec3()
    };
    BilinearPatch {
        p00: corner(-0.5, -0.5, -h),
        p10: corner(0.5, -0.5, h),
        p01: corner(-0.5, 0.5, h),
        p11: corner(0.5, 0.5, -h),
    }
}

#[test]
fn hard_cases() {
    let ray = |o: [f32; 3], d: [f32; 3]| Ray::new(o.into(), d.into());
    let down = ray([0.25, 0.75, 5.0], [0., 0., -1.]);
    let double = ray([-2.0, -1.0, 0.09375], [1.0, 1.0, 0.0]);
    let nan = Vec3::new(0.0, f32::NAN, 0.0);
    let folded = BilinearPatch { p11: SQUARE.p10, ..SQUARE };
    let flat = BilinearPatch { p01: SQUARE.p00, p11: SQUARE.p10, ..SQUARE };
    let table = [
        // why it is hard, shape, ray, t
        ("a flat square", SQUARE, down, Some(5.0)),
        ("from below", SQUARE, ray([0.25, 0.75, -5.0], [0., 0., 1.]), Some(5.0)),
        ("a direction of length 4", SQUARE, ray([0.25, 0.75, 5.0], [0., 0., -4.]), Some(1.25)),
        ("the interval starts on the hit", SQUARE, Ray { t_min: 5.0, ..down }, Some(5.0)),
        ("the interval ends on the hit", SQUARE, Ray { t_max: 5.0, ..down }, Some(5.0)),
        ("the interval starts after the hit", SQUARE, Ray { t_min: 5.000001, ..down }, None),
        ("the interval ends before the hit", SQUARE, Ray { t_max: 4.9999995, ..down }, None),
        ("passes the square", SQUARE, ray([1.25, 0.75, 5.0], [0., 0., -1.]), None),
        ("in the plane of a flat square", SQUARE, ray([-1.0, 0.5, 0.0], [1., 0., 0.]), None),
        (
            "a triangle: two corners coincide",
            folded,
            ray([0.25, 0.25, 5.0], [0., 0., -1.]),
            Some(5.0),
        ),
        ("passes the triangle", folded, ray([0.75, 0.75, 5.0], [0., 0., -1.]), None),
        ("no area", flat, ray([0.5, 0.0, 5.0], [0., 0., -1.]), None),
        ("a zero direction", SQUARE, ray([0.25, 0.75, 5.0], [0.; 3]), None),
        ("NaN in the origin", SQUARE, ray([f32::NAN, 0.75, 5.0], [0., 0., -1.]), None),
        ("NaN in the direction", SQUARE, ray([0.25, 0.75, 5.0], [0., f32::NAN, -1.]), None),
        ("NaN in a corner", BilinearPatch { p01: nan, ..SQUARE }, down, None),
        ("an infinite corner", BilinearPatch { p01: Vec3::INFINITY, ..SQUARE }, down, None),
        ("an infinite origin", SQUARE, ray([0.25, 0.75, f32::INFINITY], [0., 0., -1.]), None),
        (
            "an infinite direction",
            SQUARE,
            ray([0.25, 0.75, 5.0], [0., 0., f32::NEG_INFINITY]),
            None,
        ),
        ("through the saddle point", SADDLE, ray([0.0, 0.0, 5.0], [0., 0., -1.]), Some(5.0)),
    ];
    for (why, patch, ray, t) in table {
        assert_eq!(patch.closest(&ray).map(|hit| hit.t), t, "{why}");
        assert_eq!(patch.any(&ray), t.is_some(), "{why}");
    }
    // z = -x y / 2 is 3/32 where x y = -3/16; on y = x + 1 these are x = -3/4 and x = -1/4.
    let t = |ray: Ray| SADDLE.closest(&ray).map(|hit| hit.t);
    assert_eq!(t(double), Some(1.25));
    assert_eq!(t(Ray { t_min: 1.5, ..double }), Some(1.75));
    assert_eq!(t(Ray { t_min: 2.0, ..double }), None);
    // At z = 1/8 they touch in x = -1/2.
    assert_eq!(t(Ray { origin: Vec3::new(-2.0, -1.0, 0.125), ..double }), Some(1.5));
}

#[test]
fn a_planted_point_is_hit_or_something_nearer_is() {
    let mut random = Random(1);
    for h in [0.0, 1e-7, 1e-5, 1e-3, 0.1, 0.5, 2.0] {
        for distance in [1.0, 3.0, 1e3, 1e6] {
            for _ in 0..800 {
                let patch = patch(&mut random, h, 1.0);
                let uv = [random.range(0.01, 0.99), random.range(0.01, 0.99)].map(Wide::from);
                let [target, du, dv] = surface(&patch, uv[0], uv[1]).map(Wide3::to_f64);
                let d = random.direction();
                let n = du.cross(dv);
                let ray = ray(target - distance * d, d);
                // The rounding of the ray can move it past an edge only if it grazes.
                let steep = d.dot(n).abs() / n.length() > 2e-6 * distance + 0.05;
                let hit = check(&patch, &ray);
                assert!(hit || !steep || distance > 1e4, "{patch:?} {ray:?}");
                if let (true, Some(t)) = (steep, patch.closest_t(&ray)) {
                    assert!(f64::from(t) <= distance * (1.0 + 1e-5), "{patch:?} {ray:?}");
                }
            }
        }
    }
}

#[test]
fn a_ray_that_passes_the_hull_of_the_corners_misses() {
    let mut random = Random(2);
    for _ in 0..20_000 {
        let patch = patch(&mut random, 0.3, 1.0);
        let center = 0.25 * (patch.p00 + patch.p10 + patch.p01 + patch.p11).as_dvec3();
        let d = random.direction();
        let target = center + 1.2 * random.across(d);
        assert_eq!(patch.closest(&ray(target - 3.0 * d, d)), None);
    }
}

#[test]
fn both_roots_are_found_in_order() {
    let mut random = Random(3);
    let mut doubles = 0;
    for _ in 0..20_000 {
        let patch = patch(&mut random, 0.5, 1.0);
        let [a, b] = [(); 2].map(|()| {
            patch.position(Vec2::new(random.range(0.0, 1.0) as f32, random.range(0.0, 1.0) as f32))
        });
        // A line through two points of the surface crosses it at both.
        let d = (b - a).as_dvec3().normalize();
        let through = ray(a.as_dvec3() - 3.0 * d, d);
        let Some(first) = patch.closest(&through) else { continue };
        let next = Ray { t_min: first.t + 1e-3, ..through };
        if let Some(second) = patch.closest(&next) {
            doubles += 1;
            assert!(second.t > first.t);
            assert_eq!(patch.closest(&Ray { t_max: first.t, ..through }), Some(first));
            check(&patch, &next);
        }
    }
    assert!(doubles > 15_000, "{doubles}");
}

#[test]
fn scale_and_length_of_the_direction_do_not_reduce_the_accuracy() {
    let mut random = Random(4);
    for scale in [1e-6, 1e-3, 1e3, 1e6] {
        for _ in 0..2000 {
            let patch = patch(&mut random, 0.3, scale);
            let target =
                patch.position(Vec2::splat(0.5)).as_dvec3() + 0.3 * scale * random.direction();
            let d = random.direction();
            let length = 10_f64.powf(random.range(-3.0, 3.0));
            check(&patch, &ray(target - 3.0 * scale * d, length * d));
        }
    }
}

#[test]
fn the_parameters_0_and_1_are_the_corners() {
    for (uv, corner) in [
        ([0.0, 0.0], SADDLE.p00),
        ([1.0, 0.0], SADDLE.p10),
        ([0.0, 1.0], SADDLE.p01),
        ([1.0, 1.0], SADDLE.p11),
    ] {
        assert_eq!(SADDLE.position(uv.into()), corner);
    }
    assert_eq!(SADDLE.normal(Vec2::splat(0.5)), Vec3::Z);
    let (du, dv) = SADDLE.tangents(Vec2::splat(0.5));
    assert_eq!((du, dv), (2.0 * Vec3::X, 2.0 * Vec3::Y));
}

#[test]
fn the_normal_of_a_collapsed_edge_is_the_limit() {
    let triangle = BilinearPatch { p11: SQUARE.p01, ..SQUARE };
    for v in [0.0, 0.5, 0.999, 1.0] {
        assert!(triangle.normal(Vec2::new(0.3, v)).distance(Vec3::Z) < 1e-6, "{v}");
    }
}

#[test]
fn the_position_of_a_hit_lies_on_the_ray_within_rounding() {
    let mut random = Random(5);
    for _ in 0..20_000 {
        let patch = patch(&mut random, 0.3, 1.0);
        let d = random.direction();
        let ray = ray(patch.position(Vec2::splat(0.4)).as_dvec3() - 3.0 * d, d);
        let Some(hit) = patch.closest(&ray) else { continue };
        let off = at(&ray, Wide::from(hit.t)) - wide(hit.position);
        assert!(off.length().to_f64() < 1e-6, "{patch:?} {ray:?} {hit:?}");
    }
}
