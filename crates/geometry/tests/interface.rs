//! What a caller relies on besides the intersections: the trait, spawned rays, defaults, methods.

#[path = "../src/test_random.rs"]
mod test_random;

use rotund_geometry::glam::{Vec2, Vec3};
use rotund_geometry::vanilla::{Line, Point, Quad};
use rotund_geometry::{
    Aabb, BilinearPatch, Hit, Method, Primitive, Ray, RoundedCone, Sphere, Triangle, UNIT_ROUNDOFF,
    leave_surface,
};
use test_random::Random;

const RAY: Ray = Ray::new(Vec3::new(0.3, 0.2, 5.0), Vec3::NEG_Z);

/// Compares the methods of the trait with the inherent ones, which have the same names.
macro_rules! assert_forwards {
    ($($shape:ident),+) => {
        $(
            let shape = $shape::default();
            let boxed: Box<dyn Primitive + Sync> = Box::new(&shape);
            let generic: &dyn Primitive = &boxed;
            let hit = shape.closest(&RAY).expect(stringify!($shape));
            let uv = shape.uv(&hit);
            assert_eq!(generic.closest(&RAY), Some(hit));
            assert_eq!(generic.closest_t(&RAY), Some(hit.t));
            assert!(generic.any(&RAY));
            assert_eq!(generic.bounds(), shape.bounds());
            assert_eq!(generic.uv(&hit), uv);
            assert_eq!(generic.position(uv), shape.position(uv));
            assert_eq!(generic.normal(uv), shape.normal(uv));
        )+
    };
}

#[test]
fn the_trait_gives_what_the_methods_of_each_shape_give() {
    assert_forwards!(Sphere, RoundedCone, BilinearPatch, Triangle, Point, Line, Quad);
}

/// The plane `z = 0`, by the required methods alone.
struct Ground;

impl Primitive for Ground {
    fn bounds(&self) -> Aabb {
        Aabb { min: Vec3::NEG_INFINITY.with_z(0.0), max: Vec3::INFINITY.with_z(0.0) }
    }

    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let t = ray.accept(f64::from(-ray.origin.z) / f64::from(ray.direction.z))?;
        let position = ray.at(t).with_z(0.0);
        let parameters = position.truncate();
        Some(Hit { t, position, error: 0.0, normal: Vec3::Z, parameters })
    }

    fn position(&self, uv: Vec2) -> Vec3 {
        uv.extend(0.0)
    }

    fn normal(&self, _uv: Vec2) -> Vec3 {
        Vec3::Z
    }
}

#[test]
fn a_shape_with_the_required_methods_alone_answers_all_queries() {
    let hit = Ground.closest(&RAY).expect("straight down");
    assert_eq!(Ground.closest_t(&RAY), Some(5.0));
    assert!(Ground.any(&RAY));
    assert!(!Ground.any(&Ray { t_max: 4.0, ..RAY }));
    assert_eq!(Ground.closest_t(&Ray::new(Vec3::Z, Vec3::X)), None, "parallel");
    assert_eq!(Ground.uv(&hit), Vec2::new(0.3, 0.2));
}

#[test]
fn a_spawned_ray_starts_where_leave_surface_says() {
    let hit = Sphere::default().closest(&RAY).expect("near the middle");
    for direction in [Vec3::X, Vec3::NEG_Z, 100.0 * Vec3::Z, hit.normal, -hit.normal] {
        let ray = hit.spawn(direction);
        let origin = leave_surface(hit.position, hit.error, hit.normal, direction);
        assert_eq!(ray, Ray::new(origin, direction));
    }
}

#[test]
fn a_ray_to_a_point_sees_what_is_between_and_not_the_ends() {
    let ball = Sphere::default();
    let hit = ball.closest(&RAY).expect("near the middle");
    let table = [
        ("up to a wall of which the point is part", Vec3::new(0.5, 0.5, 9.0), false),
        ("through the ball", Vec3::new(0.1, 0.1, -9.0), true),
        ("inside the ball", Vec3::new(0.0, 0.1, 0.0), false),
    ];
    for (why, point, blocked) in table {
        let ray = hit.spawn_to(point);
        assert!((ray.at(1.0) - point).length() < 1e-6, "{why}: {ray:?}");
        let wall = Quad {
            p0: point.with_x(-9.0).with_y(-9.0),
            p1: point.with_x(9.0).with_y(-9.0),
            p2: point.with_x(9.0).with_y(9.0),
            p3: point.with_x(-9.0).with_y(9.0),
        };
        assert_eq!(ball.any(&ray), blocked, "{why}: {ray:?}");
        assert!(!wall.any(&ray), "{why}: {ray:?}");
        assert!(wall.any(&Ray { t_max: 1.0 + 1e-6, ..ray }), "{why}: {ray:?}");
    }
}

/// Returns shapes of size 1 about `center`, of every kind that has a surface of its own.
fn shapes_about(center: Vec3, random: &mut Random) -> [Box<dyn Primitive>; 4] {
    let mut corner = || center + random.direction().as_vec3();
    let (p0, p1, p2, p3) = (corner(), corner(), corner(), corner());
    [
        Box::new(Sphere { center, radius: 1.0 }),
        Box::new(RoundedCone { p0, r0: 0.5, p1, r1: 0.25 }),
        Box::new(BilinearPatch { p00: p0, p10: p1, p01: p2, p11: p3 }),
        Box::new(Triangle { p0, p1, p2 }),
    ]
}

#[test]
fn a_ray_to_a_point_of_a_surface_ends_before_it_at_every_distance_from_the_origin() {
    for offset in [0.0, 100.0, 1e3, 1e4] {
        let (mut seen, mut random) = ([0; 4], Random(offset as u64));
        while seen.iter().any(|&count| count < 2000) {
            let center = (offset * random.direction()).as_vec3();
            let distance = random.range(4.0, 16.0);
            let eye = (center.as_dvec3() + distance * random.direction()).as_vec3();
            let lens = Sphere { center: eye, radius: 0.5 };
            for (kind, shape) in shapes_about(center, &mut random).iter().enumerate() {
                let towards = center - eye + 0.5 * random.in_cube();
                let Some(start) = lens.closest(&Ray::new(eye, towards)) else { continue };
                let Some(target) = shape.closest(&start.spawn(towards)) else { continue };
                let segment = start.spawn_to(target.position);
                if segment.direction.normalize().dot(target.normal).abs() < 0.1 {
                    continue;
                }
                seen[kind] += 1;
                assert!(!shape.any(&segment), "{offset}: {kind} {target:?} {segment:?}");
                let between = Sphere { center: eye.lerp(target.position, 0.75), radius: 0.25 };
                assert!(between.any(&segment), "{offset}: {segment:?}");
            }
        }
    }
}

#[test]
fn a_ray_to_a_near_point_of_usual_coordinates_ends_32_roundings_before_it() {
    let hit = Sphere::default().closest(&RAY).expect("near the middle");
    assert_eq!(hit.spawn_to(Vec3::new(0.5, 0.5, 9.0)).t_max, 1.0 - 32.0 * UNIT_ROUNDOFF);
}

#[test]
fn a_rounded_root_counts_if_it_lies_in_the_closed_interval() {
    let ray = Ray { t_min: 1.0, t_max: 2.0, ..RAY };
    let (above, below) = (1.0 + 1e-12, 1.0 - 1e-12);
    for t in [1.0, 2.0, above, below, 2.0 + 1e-12] {
        assert_eq!(ray.accept(t), Some(t as f32), "{t}");
    }
    for t in [0.999, 2.001, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(ray.accept(t), None, "{t}");
        assert_eq!(RAY.accept(-1.0 - t.abs()), None, "{t}");
    }
    assert_eq!(RAY.accept(1e300), None, "no finite f32");
    assert_eq!(Ray { t_max: f32::NAN, ..RAY }.accept(1.0), None);
    assert_eq!(Ray { t_min: f32::NAN, ..RAY }.accept(1.0), None);
}

#[test]
fn defaults_are_unit_shapes_the_same_for_both_methods() {
    let uv = Vec2::new(0.25, 0.5);
    let flat = Vec3::new(0.25, 0.5, 0.0);
    assert_eq!(BilinearPatch::default().position(uv), flat);
    assert_eq!(Quad::default().position(uv), flat);
    assert_eq!(Triangle::default().position(uv), flat);
    assert_eq!(Quad::default().bounds(), BilinearPatch::default().bounds());
    assert_eq!(Line::default().bounds(), RoundedCone::default().bounds());
    assert_eq!(Point::default().bounds(), Sphere::default().bounds());
    assert_eq!(Sphere::default().position(Vec2::ZERO), Vec3::Y);
    assert_eq!(RoundedCone::default().position(Vec2::ZERO), Vec3::NEG_Y);
    assert!(Aabb::default().is_empty());
    let origin = Vec3::new(0.0, 0.0, 5.0);
    assert_eq!(Ray { origin, ..Ray::default() }, Ray::new(origin, Vec3::NEG_Z));
    assert_eq!(Method::default(), Method::Enhanced);
}

#[test]
fn a_method_is_read_back_from_its_name() {
    for method in Method::ALL {
        assert_eq!(method.name().parse(), Ok(method));
        assert_eq!(method.to_string(), method.name());
    }
    for wrong in ["", "Vanilla", " enhanced", "yocto"] {
        assert!(wrong.parse::<Method>().is_err(), "{wrong:?}");
    }
    assert_eq!(format!("[{:>9}]", Method::Vanilla), "[  vanilla]");
}

#[test]
fn an_unknown_method_is_named_in_the_error() {
    let expected = "expected \"vanilla\" or \"enhanced\"";
    let long = "a".repeat(40);
    // The limit of 32 bytes lies within the last character.
    let across_the_limit = format!("{}é", "a".repeat(31));
    for (name, shown) in [
        ("embree", "\"embree\""),
        ("", "\"\""),
        ("a\nb", "\"a\\nb\""),
        (&long[..32], &format!("{:?}", &long[..32])),
        (&long, &format!("{:?}...", &long[..32])),
        (&across_the_limit, &format!("{:?}...", &long[..31])),
    ] {
        let error = name.parse::<Method>().expect_err("no such method");
        assert_eq!(error.to_string(), format!("unknown method {shown}: {expected}"));
    }
}

/// Asserts that a shape with a NaN or an infinity in any one of its numbers is a miss.
macro_rules! assert_misses {
    ($shape:ident { $($field:ident),+ }, $set:ident) => {
        let shape = $shape::default();
        assert!(shape.any(&RAY), "{shape:?}");
        $(
            for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut shape = shape;
                $set(&mut shape.$field, wrong);
                assert_eq!(shape.closest(&RAY), None, "{shape:?}");
                assert_eq!(shape.closest_t(&RAY), None, "{shape:?}");
                assert!(!shape.any(&RAY), "{shape:?}");
            }
        )+
    };
}

#[test]
fn a_shape_with_a_number_that_is_not_finite_misses() {
    for axis in 0..3 {
        let set = |point: &mut Vec3, wrong| point[axis] = wrong;
        assert_misses!(Sphere { center }, set);
        assert_misses!(RoundedCone { p0, p1 }, set);
        assert_misses!(BilinearPatch { p00, p10, p01, p11 }, set);
        assert_misses!(Triangle { p0, p1, p2 }, set);
        assert_misses!(Point { center }, set);
        assert_misses!(Line { p0, p1 }, set);
        assert_misses!(Quad { p0, p1, p2, p3 }, set);
    }
    let set = |radius: &mut f32, wrong| *radius = wrong;
    assert_misses!(Sphere { radius }, set);
    assert_misses!(RoundedCone { r0, r1 }, set);
    for radius in [f32::NAN, f32::NEG_INFINITY] {
        assert!(!Point { radius, ..Point::default() }.any(&RAY), "{radius}");
        assert!(!Line { r0: radius, ..Line::default() }.any(&RAY), "{radius}");
    }
}

#[test]
fn a_negative_radius_misses_except_on_the_part_of_a_ribbon_where_the_radius_is_positive() {
    assert_eq!(Sphere { radius: -1.0, ..Sphere::default() }.closest(&RAY), None);
    assert_eq!(Point { radius: -1.0, ..Point::default() }.closest(&RAY), None);
    assert_eq!(RoundedCone { r1: -1.0, ..RoundedCone::default() }.closest(&RAY), None);
    let line = Line { r1: -1.0, ..Line::default() };
    assert!(line.any(&RAY), "the radius is 0.6 where the ray passes");
    assert!(!line.any(&Ray { origin: RAY.origin.with_y(0.6), ..RAY }), "here it is -0.2");
}

#[test]
fn a_ray_with_a_number_that_is_not_finite_misses() {
    let shapes: [&dyn Primitive; 7] = [
        &Sphere::default(),
        &RoundedCone::default(),
        &BilinearPatch::default(),
        &Triangle::default(),
        &Point::default(),
        &Line::default(),
        &Quad::default(),
    ];
    for axis in 0..3 {
        for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let (mut origin, mut direction) = (RAY, RAY);
            origin.origin[axis] = wrong;
            direction.direction[axis] = wrong;
            for (index, shape) in shapes.into_iter().enumerate() {
                assert_eq!(shape.closest(&origin), None, "{index}: {origin:?}");
                assert_eq!(shape.closest(&direction), None, "{index}: {direction:?}");
            }
        }
    }
    for (index, shape) in shapes.into_iter().enumerate() {
        assert_eq!(shape.closest(&Ray { direction: Vec3::ZERO, ..RAY }), None, "{index}");
        assert_eq!(shape.closest(&Ray { t_min: f32::NAN, ..RAY }), None, "{index}");
        assert_eq!(shape.closest(&Ray { t_max: f32::NAN, ..RAY }), None, "{index}");
    }
}
