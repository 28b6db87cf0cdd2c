//! The surface at the ends of its parameters, also where a radius is zero or one ball contains the
//! other.

#[path = "../src/test_random.rs"]
mod test_random;

use rotund_geometry::glam::{Vec2, Vec3};
use rotund_geometry::vanilla::{Line, Point, Quad};
use rotund_geometry::{BilinearPatch, Primitive, Ray, RoundedCone, Sphere, Triangle};
use test_random::Random;

const ENDS: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];

fn assert_finite(why: &str, shape: &dyn Primitive) {
    for uv in ENDS {
        assert!(shape.position(uv).is_finite(), "{why}: position({uv})");
        let length = shape.normal(uv).length();
        assert!((length - 1.0).abs() < 1e-6, "{why}: normal({uv}) has the length {length}");
    }
}

fn assert_finite_tangents(why: &str, tangents: impl Fn(Vec2) -> (Vec3, Vec3)) {
    for uv in ENDS {
        let (du, dv) = tangents(uv);
        assert!(du.is_finite() && dv.is_finite(), "{why}: tangents({uv}) are {du} and {dv}");
    }
}

/// Cones of all kinds of ends, along an axis of the world and in another direction.
fn cones() -> impl Iterator<Item = (&'static str, RoundedCone)> {
    let table = [
        ("capsule", 1.0, 1.0, 4.0),
        ("tip at p1", 1.0, 0.0, 4.0),
        ("tip at p0", 0.0, 1.0, 4.0),
        ("segment", 0.0, 0.0, 4.0),
        ("the first ball contains the second", 2.0, 0.5, 1.0),
        ("the second ball contains the first", 0.5, 2.0, 1.0),
        ("the first ball contains a tip", 2.0, 0.0, 1.0),
        ("the second ball contains a tip", 0.0, 2.0, 1.0),
        ("a tip on the first ball", 1.0, 0.0, 1.0),
        ("a tip on the second ball", 0.0, 1.0, 1.0),
        ("equal balls about one center", 1.0, 1.0, 0.0),
        ("balls about one center", 0.5, 1.0, 0.0),
        ("a point", 0.0, 0.0, 0.0),
    ];
    let axes = [Vec3::Z, Vec3::NEG_X, Vec3::new(-2.0, 0.3, -1.0).normalize()];
    let p0 = Vec3::new(3.0, 0.0, 1.0);
    table.into_iter().flat_map(move |(why, r0, r1, length)| {
        axes.map(|axis| (why, RoundedCone { p0, r0, p1: p0 + length * axis, r1 }))
    })
}

#[test]
fn shapes_are_finite_at_the_ends_of_their_parameters() {
    for (why, cone) in cones() {
        assert_finite(why, &cone);
        assert_finite_tangents(why, |uv| cone.tangents(uv));
        for uv in ENDS {
            assert!((0.0..=1.0).contains(&cone.along_axis(uv)), "{why}: along_axis({uv})");
        }
        let RoundedCone { p0, r0, p1, r1 } = cone;
        assert_finite(why, &Line { p0, r0, p1, r1 });
    }
    for radius in [0.0, 1.0] {
        let (center, why) = (Vec3::new(3.0, 0.0, 1.0), "sphere");
        assert_finite(why, &Sphere { center, radius });
        assert_finite_tangents(why, |uv| Sphere { center, radius }.tangents(uv));
        assert_finite("point", &Point { center, radius });
    }
    let [p00, p10, p01] = [Vec3::ZERO, Vec3::X, Vec3::Y];
    for p11 in [Vec3::ONE, p10, p00] {
        let patch = BilinearPatch { p00, p10, p01, p11 };
        assert_finite("patch", &patch);
        assert_finite_tangents("patch", |uv| patch.tangents(uv));
        assert_finite("quad", &Quad { p0: p00, p1: p10, p2: p11, p3: p01 });
        assert_finite("triangle", &Triangle { p0: p00, p1: p10, p2: p11 });
    }
}

#[test]
fn the_tip_of_a_cone_is_a_point_whichever_way_its_lengths_are_rounded() {
    let mut random = Random(1);
    for _ in 0..1000 {
        let [p0, p1] = [3.0 * random.in_cube(), 3.0 * random.in_cube()];
        let radius = 0.5 * p0.distance(p1) * random.unit();
        let tip_last = RoundedCone { p0, r0: radius, p1, r1: 0.0 };
        let tip_first = RoundedCone { p0: p1, r0: 0.0, p1: p0, r1: radius };
        for (cone, u) in [(tip_last, 1.0), (tip_first, 0.0)] {
            assert_finite("tip", &cone);
            assert_finite_tangents("tip", |uv| cone.tangents(uv));
            assert!(cone.position(Vec2::new(u, 0.3)).distance(p1) < 1e-6, "{cone:?}");
        }
    }
}

#[test]
fn the_profile_of_a_cone_runs_from_pole_to_pole() {
    for (why, cone) in cones() {
        let RoundedCone { p0, r0, p1, r1 } = cone;
        let Some(axis) = (p1 - p0).try_normalize() else { continue };
        // If one ball contains the other, both poles are those of the larger ball.
        let first = if r1 > r0 + p0.distance(p1) - 1e-6 { p1 - r1 * axis } else { p0 - r0 * axis };
        let last = if r0 > r1 + p0.distance(p1) - 1e-6 { p0 + r0 * axis } else { p1 + r1 * axis };
        for v in [0.0, 1.0] {
            let ends = [0.0, 1.0].map(|u| cone.position(Vec2::new(u, v)));
            assert!(ends[0].distance(first) < 1e-6, "{why}: {cone:?} starts at {}", ends[0]);
            assert!(ends[1].distance(last) < 1e-6, "{why}: {cone:?} ends at {}", ends[1]);
        }
    }
}

#[test]
fn a_hit_down_the_axis_of_a_cone_comes_back_from_its_parameters() {
    let mut hits = 0;
    for (why, cone) in cones() {
        let axis = (cone.p1 - cone.p0).normalize_or(Vec3::Z);
        for axis in [axis, -axis] {
            let ray = Ray::new(cone.p0 - 16.0 * axis, axis);
            // A tip is met only if no coordinate of the ray is rounded.
            let Some(hit) = cone.closest(&ray) else { continue };
            let uv = cone.uv(&hit);
            let back = cone.position(uv);
            assert!(back.distance(hit.position) < 1e-5, "{why}: {cone:?}, {uv} is at {back}");
            hits += 1;
        }
    }
    assert!(hits >= 60, "{hits} hits test little");
}
