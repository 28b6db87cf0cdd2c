//! Defects measured in an earlier intersector of these shapes, with the numbers that showed them.
//!
//! That library assumed unit directions, kept one root where two exist, and rebuilt cone points from a
//! parametrisation that did not identify them. The exact values come from quadruple precision.

use rotund_geometry::glam::Vec3;
use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere};

const CONE: RoundedCone =
    RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::new(0.0, 0.0, 3.0), r1: 0.5 };
const BALL: Sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };
const SADDLE: BilinearPatch = BilinearPatch {
    p00: Vec3::new(-1.0, -1.0, -0.5),
    p10: Vec3::new(1.0, -1.0, 0.5),
    p01: Vec3::new(-1.0, 1.0, 0.5),
    p11: Vec3::new(1.0, 1.0, -0.5),
};

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray::new(origin.into(), direction.into())
}

fn from(t_min: f32, ray: Ray) -> Ray {
    Ray { t_min, ..ray }
}

#[track_caller]
fn assert_t(hit: Option<Hit>, t: f32) -> Hit {
    let hit = hit.expect("a hit");
    assert!((hit.t - t).abs() <= 1e-4 * t, "t = {}, expected {t}", hit.t);
    hit
}

#[track_caller]
fn assert_near(got: Vec3, expected: [f32; 3], tolerance: f32) {
    assert!((got - Vec3::from(expected)).length() <= tolerance, "{got}, expected {expected:?}");
}

#[test]
fn a_hit_on_the_cap_about_p0_has_its_own_position_and_normal() {
    let hit = assert_t(CONE.closest(&ray([0.2, 0.0, -5.0], [0.0, 0.0, 1.0])), 4.02020);
    assert_near(hit.position, [0.2, 0.0, -0.979796], 1e-6);
    assert_near(hit.normal, [0.2, 0.0, -0.979796], 1e-6);

    let hit = assert_t(CONE.closest(&ray([0.0, 5.0, -0.6], [0.0, -1.0, 0.0])), 4.2);
    assert_near(hit.position, [0.0, 0.8, -0.6], 1e-6);
}

#[test]
fn an_origin_inside_the_infinite_cone_but_outside_the_hull_sees_the_cap() {
    assert_t(CONE.closest(&ray([0.0, 0.0, -1.3], [0.0, 0.3011, 0.9536])), 0.31947);
    let cylinder = RoundedCone { r1: 1.0, ..CONE };
    assert_t(cylinder.closest(&ray([0.0, 0.3, -1.5], [0.0, 0.04994, 0.99875])), 0.55593);
}

#[test]
fn a_ray_from_inside_a_cone_finds_the_exit() {
    assert_t(CONE.closest(&ray([0.0, 0.0, 1.0], [1.0, 0.0, 0.0])), 0.84515);
}

#[test]
fn a_ray_whose_interval_starts_between_entry_and_exit_finds_the_exit_of_a_cone() {
    assert_t(CONE.closest(&from(5.0, ray([0.0, -5.0, 1.5], [0.0, 1.0, 0.0]))), 5.76064);
}

#[test]
fn a_ball_that_holds_the_other_is_the_shape() {
    let nested = RoundedCone { p1: Vec3::new(0.0, 0.0, 0.3), ..CONE };
    assert_t(nested.closest(&ray([0.0, -5.0, 0.0], [0.0, 1.0, 0.0])), 4.0);
}

#[test]
fn coincident_ends_are_a_ball_whatever_their_radii() {
    for r1 in [1.0, 0.5, 0.0] {
        let ball = RoundedCone { p1: CONE.p0, r1, ..CONE };
        let hit = assert_t(ball.closest(&ray([0.0, -5.0, 0.0], [0.0, 1.0, 0.0])), 4.0);
        assert_eq!(hit.normal, Vec3::NEG_Y);
        assert!(ball.uv(&hit).is_finite());
        assert_near(ball.position(ball.uv(&hit)), [0.0, -1.0, 0.0], 1e-6);
    }
}

#[test]
fn directions_need_not_have_unit_length() {
    let o = [0.0, 0.0, -5.0];
    assert_t(BALL.closest(&ray(o, [0.0, 0.0, 2.0])), 2.0);
    assert_t(BALL.closest(&ray(o, [0.0, 0.0, 0.5])), 8.0);
    let o = [0.0, -5.0, 1.5];
    assert_t(CONE.closest(&ray(o, [0.0, 2.0, 0.0])), 2.1197);
    assert_t(CONE.closest(&ray(o, [0.0, 0.5, 0.0])), 8.479);
}

#[test]
fn a_root_before_t_min_does_not_hide_the_far_root_of_a_sphere() {
    assert_t(BALL.closest(&from(5.0, ray([0.0, 0.0, -5.0], [0.0, 0.0, 1.0]))), 6.0);
}

#[test]
fn the_near_root_of_a_sphere_comes_first_and_the_far_one_from_inside() {
    assert_t(BALL.closest(&ray([0.2, 0.1, -5.0], [0.0, 0.0, 1.0])), 4.02532);
    assert_t(BALL.closest(&ray([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])), 1.0);
}

#[test]
fn distance_does_not_move_a_sphere() {
    let hit = BALL.closest(&ray([0.5, 0.0, -1e4], [0.0, 0.0, 1.0])).expect("a hit");
    assert_near(hit.normal, [0.5, 0.0, -0.866_025_4], 2e-7);
    assert_near(hit.position, [0.5, 0.0, -0.866_025_4], 2e-7);
}

#[test]
fn distance_does_not_move_a_cone() {
    let hit = CONE.closest(&ray([0.0, -1000.0, 1.5], [0.0, 1.0, 0.0])).expect("a hit");
    assert_eq!(hit.t, 999.2394);
}

#[test]
fn a_long_thin_cone_is_not_missed() {
    let thin = RoundedCone { r0: 0.01, p1: Vec3::new(0.0, 0.0, 1000.0), r1: 0.005, ..CONE };
    for i in 0..1000 {
        let z = i as f32;
        let hit = thin.closest(&ray([0.0, -1000.0, z], [0.0, 1.0, 0.0])).expect("a hit");
        assert!((hit.position.y + 0.01 - 5e-6 * z).abs() < 1e-6, "{hit:?}");
    }
}

#[test]
fn a_cone_position_is_rebuilt_from_its_uv() {
    let hit = CONE.closest(&ray([0.1, -5.0, 1.5], [0.0, 1.0, 0.0])).expect("a hit");
    assert_near(hit.position, [0.1, -0.754, 1.5], 1e-3);
    assert_near(CONE.position(CONE.uv(&hit)), hit.position.into(), 1e-6);
    assert_near(CONE.normal(CONE.uv(&hit)), [0.13, -0.98, 0.17], 1e-2);

    let cylinder = RoundedCone { p1: Vec3::new(3.0, 0.0, 0.0), r0: 0.5, r1: 0.5, ..CONE };
    let hit = cylinder.closest(&ray([1.5, -5.0, 0.2], [0.0, 1.0, 0.0])).expect("a hit");
    assert_near(hit.position, [1.5, -0.458, 0.2], 1e-3);
    assert_near(cylinder.position(cylinder.uv(&hit)), hit.position.into(), 1e-6);
}

#[test]
fn a_sphere_needs_no_vertex_normals() {
    let hit = BALL.closest(&ray([0.2, 0.1, -5.0], [0.0, 0.0, 1.0])).expect("a hit");
    assert_near(hit.normal, hit.position.into(), 1e-7);
    assert_near(BALL.normal(BALL.uv(&hit)), hit.normal.into(), 1e-6);
}

#[test]
fn a_root_before_t_min_does_not_hide_the_far_root_of_a_patch() {
    let double =
        ray([-2.362_628_2, -1.628_351_6, 0.144_072_4], [0.740_573_35, 0.663_313, -0.107_549_526]);
    let hit = assert_t(SADDLE.closest(&double), 2.129_098);
    assert!(hit.position.is_finite());
    assert_t(SADDLE.closest(&from(3.0415, double)), 3.953_924);
}

#[test]
fn a_miss_computes_nothing_from_roots_that_do_not_exist() {
    assert_eq!(SADDLE.closest(&ray([0.0, 0.0, -5.0], [1.0, 0.0, 0.0])), None);
}

#[test]
fn a_ray_along_a_ruling_is_a_hit_or_a_miss_but_never_a_nan() {
    // The ruling u = 0.5 is the y axis: the surface and the ray share a segment.
    let along = ray([0.0, -3.0, 0.0], [0.0, 1.0, 0.0]);
    if let Some(hit) = SADDLE.closest(&along) {
        assert!((2.0..=4.0).contains(&hit.t) && hit.position.is_finite() && hit.normal.is_finite());
    }
}

#[test]
fn a_patch_is_not_two_triangles() {
    let down = ray([-0.4, -0.3, 3.0], [0.0, 0.0, -1.0]);
    // z = -x y / 2 on this saddle.
    assert_t(SADDLE.closest(&down), 3.06);
}

#[test]
fn a_small_sphere_can_be_left_from_inside() {
    // A constant offset of 1e-4 used to step over it.
    let small = Sphere { center: Vec3::ZERO, radius: 1e-5 };
    assert_t(small.closest(&ray([0.0; 3], [0.0, 1.0, 0.0])), 1e-5);
}
