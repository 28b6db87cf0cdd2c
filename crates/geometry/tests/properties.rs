//! Properties of every shape and every ray, random and degenerate.

use proptest::prelude::*;
use rotund_geometry::glam::{Vec2, Vec3};
use rotund_geometry::vanilla::{Line, Point, Quad};
use rotund_geometry::{BilinearPatch, Primitive, Ray, RoundedCone, Sphere, Triangle};

/// Numbers as scenes have them, and extreme and invalid ones.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => -2.0_f32..2.0,
        2 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, 0.5]),
        1 => prop::sample::select(vec![
            f32::MIN_POSITIVE, 1e-40, f32::MAX, f32::MIN, 1e30, -1e20, 1e-20,
            f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::EPSILON,
        ]),
    ]
}

fn any_point() -> impl Strategy<Value = Vec3> {
    [any_number(), any_number(), any_number()].prop_map(Vec3::from)
}

fn any_ray() -> impl Strategy<Value = Ray> {
    (any_point(), any_point(), any_number(), any_number())
        .prop_map(|(origin, direction, t_min, t_max)| Ray { origin, direction, t_min, t_max })
}

fn point() -> impl Strategy<Value = Vec3> {
    [-2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0].prop_map(Vec3::from)
}

fn sane_ray() -> impl Strategy<Value = Ray> {
    (point(), point())
        .prop_map(|(origin, direction)| Ray::new(5.0 * origin, direction - 2.0 * origin))
}

/// A shape that can be scaled about the origin.
trait Shape: Primitive + Copy + std::fmt::Debug {
    fn scaled(&self, by: f32) -> Self;
}

macro_rules! shape {
    ($type:ident, $self:ident, $by:ident => $scaled:expr) => {
        impl Shape for $type {
            fn scaled(&$self, $by: f32) -> Self {
                $scaled
            }
        }
    };
}

shape!(Sphere, self, by => Self { center: self.center * by, radius: self.radius * by });
shape!(Point, self, by => Self { center: self.center * by, radius: self.radius * by });
shape!(RoundedCone, self, by => {
    Self { p0: self.p0 * by, r0: self.r0 * by, p1: self.p1 * by, r1: self.r1 * by }
});
shape!(Line, self, by => {
    Self { p0: self.p0 * by, r0: self.r0 * by, p1: self.p1 * by, r1: self.r1 * by }
});
shape!(BilinearPatch, self, by => {
    Self { p00: self.p00 * by, p10: self.p10 * by, p01: self.p01 * by, p11: self.p11 * by }
});
shape!(Triangle, self, by => Self { p0: self.p0 * by, p1: self.p1 * by, p2: self.p2 * by });
shape!(Quad, self, by => {
    Self { p0: self.p0 * by, p1: self.p1 * by, p2: self.p2 * by, p3: self.p3 * by }
});

/// Checks for any numbers that nothing panics, that no result is NaN, and that the queries agree.
fn agrees(shape: impl Shape, ray: &Ray) -> Result<(), TestCaseError> {
    let hit = shape.closest(ray);
    prop_assert_eq!(shape.closest_t(ray).map(f32::to_bits), hit.map(|hit| hit.t.to_bits()));
    prop_assert_eq!(shape.any(ray), hit.is_some());
    let bounds = shape.bounds();
    let Some(hit) = hit else { return Ok(()) };
    prop_assert!(hit.t.is_finite() && hit.t >= ray.t_min && hit.t <= ray.t_max, "{:?}", hit);
    prop_assert!(!hit.position.is_nan() && hit.error >= 0.0, "{:?}", hit);
    prop_assert!((hit.normal.length() - 1.0).abs() < 1e-5, "{:?} {:?} {:?}", shape, ray, hit);
    prop_assert!(hit.parameters.is_finite(), "{:?}", hit);
    prop_assert!(hit.position.cmpge(bounds.min).all() && hit.position.cmple(bounds.max).all());
    let uv = shape.uv(&hit);
    prop_assert!(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all(), "{:?}", uv);
    prop_assert!(!shape.position(uv).is_nan() && !shape.normal(uv).is_nan());
    Ok(())
}

/// Checks that a smaller interval that contains the hit finds it, and that a later start finds a
/// later hit or none.
fn is_monotone(shape: impl Shape, ray: &Ray) -> Result<(), TestCaseError> {
    let Some(hit) = shape.closest(ray) else {
        // A part of the interval; it also replaces an end that is NaN.
        let t_min = if ray.t_min <= 0.5 { 0.5 } else { ray.t_min };
        let t_max = if ray.t_max >= 1.5 { 1.5 } else { ray.t_max };
        let part = Ray { t_min, t_max, ..*ray };
        prop_assert_eq!(shape.closest(&part), None);
        return Ok(());
    };
    prop_assert_eq!(shape.closest(&Ray { t_max: hit.t, ..*ray }), Some(hit));
    prop_assert_eq!(shape.closest(&Ray { t_min: hit.t, ..*ray }).map(|hit| hit.t), Some(hit.t));
    prop_assert_eq!(shape.closest(&Ray { t_max: hit.t.next_down(), ..*ray }), None);
    let next = shape.closest(&Ray { t_min: hit.t.next_up(), ..*ray });
    prop_assert!(next.is_none_or(|next| next.t > hit.t));
    Ok(())
}

/// Checks that scaling by a power of two, which is exact, gives the same bits.
fn scales(shape: impl Shape, ray: &Ray) -> Result<(), TestCaseError> {
    let hit = shape.closest(ray);
    for power in [-20, -10, 10, 20] {
        let by = 2.0_f32.powi(power);
        let scaled = Ray { origin: ray.origin * by, direction: ray.direction * by, ..*ray };
        let other = shape.scaled(by).closest(&scaled);
        prop_assert_eq!(other.map(|hit| (hit.t, hit.normal)), hit.map(|hit| (hit.t, hit.normal)));
        prop_assert_eq!(other.map(|hit| hit.position), hit.map(|hit| hit.position * by));
    }
    Ok(())
}

fn all(shape: impl Shape, wild: &Ray, sane: &Ray) -> Result<(), TestCaseError> {
    agrees(shape, wild)?;
    agrees(shape, sane)?;
    is_monotone(shape, wild)?;
    is_monotone(shape, sane)
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 20000,
        failure_persistence: None,
        rng_seed: prop::test_runner::RngSeed::Fixed(1),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn the_queries_of_spheres_and_points_agree(
        center in any_point(),
        radius in any_number(),
        wild in any_ray(),
        sane in sane_ray(),
    ) {
        all(Sphere { center, radius }, &wild, &sane)?;
        all(Point { center, radius }, &wild, &sane)?;
    }

    #[test]
    fn the_queries_of_rounded_cones_and_lines_agree(
        p0 in any_point(),
        r0 in any_number(),
        p1 in any_point(),
        r1 in any_number(),
        wild in any_ray(),
        sane in sane_ray(),
    ) {
        all(RoundedCone { p0, r0, p1, r1 }, &wild, &sane)?;
        all(Line { p0, r0, p1, r1 }, &wild, &sane)?;
    }

    #[test]
    fn the_queries_of_patches_quads_and_triangles_agree(
        p in [any_point(), any_point(), any_point(), any_point()],
        wild in any_ray(),
        sane in sane_ray(),
    ) {
        let [p0, p1, p2, p3] = p;
        all(BilinearPatch { p00: p0, p10: p1, p01: p3, p11: p2 }, &wild, &sane)?;
        all(Quad { p0, p1, p2, p3 }, &wild, &sane)?;
        all(Triangle { p0, p1, p2 }, &wild, &sane)?;
    }

    #[test]
    fn scaling_by_a_power_of_two_or_shortening_the_ray_changes_no_bit(
        p in [point(), point(), point(), point()],
        r in [0.01_f32..1.0, 0.01_f32..1.0],
        ray in sane_ray(),
    ) {
        let ([p0, p1, p2, p3], [r0, r1]) = (p, r);
        scales(Sphere { center: p0, radius: r0 }, &ray)?;
        scales(RoundedCone { p0, r0, p1, r1 }, &ray)?;
        scales(BilinearPatch { p00: p0, p10: p1, p01: p3, p11: p2 }, &ray)?;
        scales(Triangle { p0, p1, p2 }, &ray)?;
        scales(Point { center: p0, radius: r0 }, &ray)?;
        scales(Line { p0, r0, p1, r1 }, &ray)?;
        scales(Quad { p0, p1, p2, p3 }, &ray)?;
        is_monotone(Sphere { center: p0, radius: r0 }, &ray)?;
        is_monotone(RoundedCone { p0, r0, p1, r1 }, &ray)?;
        is_monotone(BilinearPatch { p00: p0, p10: p1, p01: p3, p11: p2 }, &ray)?;
        is_monotone(Triangle { p0, p1, p2 }, &ray)?;
        is_monotone(Point { center: p0, radius: r0 }, &ray)?;
        is_monotone(Line { p0, r0, p1, r1 }, &ray)?;
        is_monotone(Quad { p0, p1, p2, p3 }, &ray)?;
    }
}
