//! Degenerate, huge and tiny boxes and rays.

mod support;

use glam::Vec3;
use rotund_bvh::{Bvh, Isa, Method, PatchTree, SphereTree, TriangleTree};
use rotund_geometry::{Aabb, BilinearPatch, Ray, Sphere, Triangle};
use support::{Ball, Random, ask, boxes, loop_over};

const NAN: f32 = f32::NAN;
const INF: f32 = f32::INFINITY;
const MAX: f32 = f32::MAX;

fn aabb(min: [f32; 3], max: [f32; 3]) -> Aabb {
    Aabb { min: min.into(), max: max.into() }
}

fn visits(bvh: &Bvh, ray: &Ray) -> Vec<u32> {
    let mut ids = Vec::new();
    let any = bvh.any(ray, |id, _| {
        ids.push(id);
        false
    });
    assert!(!any, "nothing answered true");
    ids.sort_unstable();
    ids
}

#[test]
fn an_empty_tree_meets_nothing() {
    let bvh = Bvh::build(&[]);
    assert_eq!(bvh.bounds(), Aabb::EMPTY);
    assert_eq!(visits(&bvh, &Ray::new(Vec3::ZERO, Vec3::X)), []);
}

#[test]
fn boxes_and_rays() {
    let unit = aabb([0.; 3], [1.; 3]);
    let table = [
        // why                                  box   origin               direction         visited
        ("plain", unit, [-1., 0.5, 0.5], [1., 0., 0.], true),
        ("misses", unit, [-1., 1.5, 0.5], [1., 0., 0.], false),
        ("behind", unit, [2., 0.5, 0.5], [1., 0., 0.], false),
        ("starts inside", unit, [0.5; 3], [1., 0., 0.], true),
        ("starts on a corner, leaves", unit, [1.; 3], [1., 1., 1.], true),
        ("in the plane of a face", unit, [-1., 1., 0.5], [1., 0., 0.], true),
        ("along an edge", unit, [-1., 1., 1.], [1., 0., 0.], true),
        ("along an edge, negative zero", unit, [-1., 0., 0.], [1., -0., -0.], true),
        ("beside the plane of a face", unit, [-1., 1.00001, 0.5], [1., 0., 0.], false),
        (
            "flat box, head on",
            aabb([0., 0., 0.], [0., 1., 1.]),
            [-1., 0.5, 0.5],
            [1., 0., 0.],
            true,
        ),
        (
            "flat box, in its plane",
            aabb([0., 0., 0.], [0., 1., 1.]),
            [0., -1., 0.5],
            [0., 1., 0.],
            true,
        ),
        ("a line, along it", aabb([0., 0., 0.], [1., 0., 0.]), [-1., 0., 0.], [1., 0., 0.], true),
        ("a point, head on", aabb([1.; 3], [1.; 3]), [0.; 3], [1.; 3], true),
        ("a point at the origin", aabb([1.; 3], [1.; 3]), [1.; 3], [1., 0., 0.], true),
        ("everything", aabb([-INF; 3], [INF; 3]), [5.; 3], [0., 1., 0.], true),
        ("half space", aabb([-INF; 3], [INF, INF, 0.]), [5.; 3], [0., 0., -1.], true),
        ("half space, leaving", aabb([-INF; 3], [INF, INF, 0.]), [5.; 3], [0., 0., 1.], false),
        ("largest numbers", aabb([-MAX; 3], [MAX; 3]), [MAX, 0., 0.], [1., 0., 0.], true),
        (
            "largest numbers, far side",
            aabb([MAX / 2., -1., -1.], [MAX, 1., 1.]),
            [-MAX, 0., 0.],
            [1e38, 0., 0.],
            true,
        ),
        ("tiny box", aabb([1e-30; 3], [2e-30; 3]), [0.; 3], [1.; 3], true),
        ("tiny box, missed", aabb([1e-30; 3], [2e-30; 3]), [0.; 3], [1., 1., 4.], false),
        ("denormal direction", unit, [-1e-2, 0.5, 0.5], [1e-40, 0., 0.], true),
        ("denormal direction, away", unit, [-1e-2, 0.5, 0.5], [-1e-40, 0., 0.], false),
        ("smallest direction", aabb([0.; 3], [1e-8; 3]), [-1e-8, 0., 0.], [1e-45, 0., 0.], true),
        ("huge direction", unit, [-1., 0.5, 0.5], [1e38, 0., 0.], true),
        ("huge and zero direction", unit, [-1., 1., 0.5], [1e38, -0., 0.], true),
        ("component that vanishes beside another", unit, [0.5, -1., 0.], [1e-40, 1., -1e-45], true),
        ("NaN corner", aabb([NAN, 0., 0.], [1.; 3]), [0.5; 3], [1., 0., 0.], false),
        ("NaN corners", aabb([0.; 3], [1., 1., NAN]), [0.5; 3], [0., 0., 1.], false),
        ("turned inside out", aabb([1.; 3], [0.; 3]), [0.5; 3], [0., 0., 1.], false),
        ("at infinity", aabb([INF; 3], [INF; 3]), [0.; 3], [1.; 3], false),
        ("NaN origin", unit, [NAN, 0.5, 0.5], [1., 0., 0.], false),
        ("NaN direction", unit, [0.5; 3], [NAN, 1., 0.], false),
        ("infinite origin", unit, [-INF, 0.5, 0.5], [1., 0., 0.], false),
        ("infinite direction", unit, [0.5; 3], [INF, 0., 0.], false),
        ("zero direction", unit, [0.5; 3], [0., -0., 0.], false),
    ];
    for (why, boxed, origin, direction, visited) in table {
        let ray = Ray::new(origin.into(), direction.into());
        let bvh = Bvh::build(&[boxed]);
        assert_eq!(!visits(&bvh, &ray).is_empty(), visited, "{why}, alone");
        // The same among others, where the box is a slot of a node and is tested.
        let far = |i: usize| aabb([-1e3 - i as f32; 3], [-1e3 - i as f32; 3]);
        let mut crowd: Vec<Aabb> = (0..20).map(far).collect();
        crowd[13] = boxed;
        let bvh = Bvh::build(&crowd);
        assert_eq!(visits(&bvh, &ray).contains(&13), visited, "{why}");
    }
}

#[test]
fn an_interval_that_is_empty_or_nan_meets_nothing() {
    let bvh = Bvh::build(&[aabb([-1.; 3], [1.; 3]), aabb([0.; 3], [2.; 3])]);
    for (t_min, t_max) in [(1.0, 0.5), (NAN, 1.0), (0.0, NAN), (INF, 0.0)] {
        let ray = Ray { t_min, t_max, ..Ray::new(Vec3::ZERO, Vec3::X) };
        assert_eq!(visits(&bvh, &ray), [], "{t_min}..={t_max}");
    }
    let instant = Ray { t_min: 0.0, t_max: 0.0, ..Ray::new(Vec3::ZERO, Vec3::X) };
    assert_eq!(visits(&bvh, &instant), [0, 1]);
    let backwards = Ray { t_min: -3.0, t_max: -1.0, ..Ray::new(Vec3::X * 3.0, Vec3::X) };
    assert_eq!(visits(&bvh, &backwards), [0, 1]);
}

#[test]
fn an_infinite_t_is_a_miss() {
    let bvh = Bvh::build(&[aabb([-1.; 3], [1.; 3]), aabb([0.; 3], [2.; 3])]);
    let ray = Ray { t_min: -INF, ..Ray::new(Vec3::ZERO, Vec3::X) };
    for infinite in [INF, -INF, NAN] {
        assert_eq!(bvh.closest(&ray, |_, _| Some((infinite, ()))), None, "{infinite}");
        // Nor does it replace a hit.
        let found = bvh.closest(&ray, |id, _| Some(([infinite, 0.5][id as usize], ())));
        assert_eq!(found.map(|found| (found.id, found.t)), Some((1, 0.5)), "{infinite}");
    }
    let found = bvh.closest(&ray, |_, _| Some((MAX, ())));
    assert_eq!(found.map(|found| found.t), Some(MAX), "the largest number is finite");
}

#[test]
fn both_zeros_are_equal_and_the_tie_goes_to_the_lowest_id() {
    let bvh = Bvh::build(&vec![aabb([-1.; 3], [1.; 3]); 9]);
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    for zeros in [[0.0, -0.0], [-0.0, 0.0]] {
        let found = bvh.closest(&ray, |id, _| Some((zeros[id as usize % 2], ())));
        assert_eq!(found.map(|found| found.id), Some(0), "{zeros:?}");
    }
}

#[test]
fn bounds_are_those_of_the_boxes_that_are_not_empty() {
    let boxes = [
        aabb([0.; 3], [1.; 3]),
        aabb([NAN; 3], [9.; 3]),
        aabb([2.; 3], [1.; 3]),
        aabb([-1., 0., 5.], [0., 0., 5.]),
    ];
    let bvh = Bvh::build(&boxes);
    assert_eq!(bvh.bounds(), aabb([-1., 0., 0.], [1., 1., 5.]));
    assert_eq!(bvh.left_out(), 2);
}

#[test]
fn bounds_are_clamped_to_the_largest_finite_numbers() {
    let bvh = Bvh::build(&[aabb([-INF, 0., 0.], [INF, 1., 1.])]);
    assert_eq!(bvh.bounds(), aabb([-MAX, 0., 0.], [MAX, 1., 1.]));
}

#[test]
fn a_million_equal_boxes_are_all_found() {
    let bvh = Bvh::build(&vec![aabb([0.; 3], [1.; 3]); 1_000_000]);
    assert_eq!(visits(&bvh, &Ray::new(Vec3::splat(-1.0), Vec3::ONE)).len(), 1_000_000);
    let found = bvh
        .closest(&Ray::new(Vec3::splat(-1.0), Vec3::ONE), |_, _| Some((1.0, ())))
        .expect("all answer");
    assert_eq!((found.id, found.t), (0, 1.0));
}

#[test]
fn boxes_in_geometric_progression_do_not_make_the_tree_deep() {
    // Each cut by equal bins separates a few boxes only.
    let balls: Vec<Ball> = (0..2000)
        .map(|i| {
            let x = 2f32.powf(i as f32 * 0.1 - 100.0);
            Ball { center: Vec3::new(x, 0.0, 0.0), radius: 0.01 * x }
        })
        .collect();
    let bvh = Bvh::build(&boxes(&balls));
    for ball in balls.iter().step_by(17) {
        let ray = Ray::new(ball.center + 3.0 * ball.radius * Vec3::Y, Vec3::NEG_Y);
        assert_eq!(ask(&bvh, &balls, &ray), loop_over(&balls, &ray), "{ball:?}");
        assert!(ask(&bvh, &balls, &ray).is_some(), "{ball:?}");
    }
}

#[test]
fn a_flat_scene_works() {
    let mut random = Random(4);
    for axis in 0..3 {
        let flat: Vec<Aabb> = (0..1000)
            .map(|_| {
                let mut corner = random.in_cube();
                corner[axis] = 0.5;
                let mut size = Vec3::splat(0.1);
                size[axis] = 0.0;
                Aabb { min: corner, max: corner + size }
            })
            .collect();
        let bvh = Bvh::build(&flat);
        for (id, boxed) in flat.iter().enumerate() {
            let mut across = Vec3::ZERO;
            across[axis] = 1.0;
            let ray = Ray::new(boxed.center() - across, across);
            assert!(visits(&bvh, &ray).contains(&(id as u32)), "axis {axis}, box {id}");
            let mut along = Vec3::ZERO;
            along[(axis + 1) % 3] = 1.0;
            let ray = Ray::new(boxed.center() - 5.0 * along, along);
            assert!(visits(&bvh, &ray).contains(&(id as u32)), "axis {axis}, box {id}, along");
        }
    }
}

#[test]
fn a_hit_whose_t_overflows_is_missed() {
    // A row of shapes along the ray, so that several are candidates; each is 1 m and more away.
    let centers = || (0..64).map(|i| Vec3::new(0.0, 0.0, 2.0 + 0.25 * i as f32));
    let spheres: Vec<_> = centers().map(|center| Sphere { center, radius: 0.5 }).collect();
    let triangles: Vec<_> = centers()
        .map(|c| Triangle { p0: c - Vec3::X - Vec3::Y, p1: c + Vec3::X - Vec3::Y, p2: c + Vec3::Y })
        .collect();
    let patches: Vec<_> = centers()
        .map(|c| BilinearPatch {
            p00: c - Vec3::X - Vec3::Y,
            p10: c + Vec3::X - Vec3::Y,
            p01: c - Vec3::X + Vec3::Y,
            p11: c + Vec3::X + Vec3::Y,
        })
        .collect();
    for isa in Isa::available() {
        let spheres = SphereTree::build(&spheres).with_isa(isa);
        let triangles = TriangleTree::build(&triangles).with_isa(isa);
        let patches = PatchTree::build(&patches).with_isa(isa);
        for method in Method::ALL {
            for length in [1e-38, 1e-39] {
                let ray = Ray::new(Vec3::new(0.01, 0.02, -9.0), length * Vec3::Z);
                assert_eq!(spheres.closest(&ray, method), None, "{isa:?}, {method:?}, {length:e}");
                assert_eq!(triangles.closest(&ray, method), None, "{isa:?}, {length:e}");
                assert_eq!(patches.closest(&ray, method), None, "{isa:?}, {length:e}");
            }
            for length in [1e-30, 1.0, 1e30] {
                let ray = Ray::new(Vec3::new(0.01, 0.02, -9.0), length * Vec3::Z);
                assert!(spheres.closest(&ray, method).is_some(), "{isa:?}, {method:?}, {length:e}");
                assert!(triangles.closest(&ray, method).is_some(), "{isa:?}, {length:e}");
                assert!(patches.closest(&ray, method).is_some(), "{isa:?}, {length:e}");
            }
        }
    }
}
