//! Packed trees give, to the bit, the answer of a loop over all primitives, with every instruction
//! set.

mod support;

use glam::{Vec2, Vec3};
use rotund_bvh::{
    Bvh, ConeTree, Isa, Method, PatchTree, PrimitiveHit, RefitError, SphereTree, TriangleTree,
};
use rotund_geometry::{BilinearPatch, Hit, Ray, RoundedCone, Sphere, Triangle, vanilla};
use support::{Random, cones, patches, spheres, triangles};

/// The closest hit, and whether there is any.
type Answer = (Option<PrimitiveHit>, bool);

/// The loop: lowest id among the smallest `t`.
fn loop_over(count: usize, closest: impl Fn(usize) -> Option<Hit>) -> Answer {
    let best = (0..count).fold(None, |best: Option<PrimitiveHit>, id| match closest(id) {
        Some(hit) if best.is_none_or(|best| hit.t < best.hit.t) => {
            Some(PrimitiveHit { id: id as u32, hit })
        }
        _ => best,
    });
    (best, best.is_some())
}

/// Compares a tree with the loop, over `rays`, with both methods and on every instruction set.
macro_rules! check {
    ($tree:ty, $primitives:expr, $rays:expr, $least_hits:expr, $vanilla:expr) => {{
        let (primitives, rays) = ($primitives, $rays);
        let trees: Vec<$tree> = Isa::available()
            .into_iter()
            .map(|isa| <$tree>::build(&primitives).with_isa(isa))
            .collect();
        for method in Method::ALL {
            let mut hits = 0;
            for ray in &rays {
                let expected = loop_over(primitives.len(), |id| match method {
                    Method::Enhanced => primitives[id].closest(ray),
                    Method::Vanilla => $vanilla(&primitives[id]).closest(ray),
                });
                hits += usize::from(expected.1);
                for tree in &trees {
                    let found = (tree.closest(ray, method), tree.any(ray, method));
                    assert_eq!(found, expected, "{method:?}, {:?}, {ray:?}", tree.isa());
                }
            }
            assert!(hits >= $least_hits, "{method:?}: {hits} hits test little");
        }
    }};
}

fn point(s: &Sphere) -> vanilla::Point {
    vanilla::Point { center: s.center, radius: s.radius }
}

fn line(c: &RoundedCone) -> vanilla::Line {
    vanilla::Line { p0: c.p0, r0: c.r0, p1: c.p1, r1: c.r1 }
}

fn quad(p: &BilinearPatch) -> vanilla::Quad {
    vanilla::Quad { p0: p.p00, p1: p.p10, p2: p.p11, p3: p.p01 }
}

/// Rays from near and far, some perpendicular to an axis, with directions of many lengths and with
/// various intervals.
fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = random.in_cube() * [1.0, 2.0, 100.0][i % 3];
            let mut direction = random.in_cube() - origin;
            if i % 5 == 0 {
                direction[i / 5 % 3] = 0.0;
            }
            let mut ray = Ray::new(origin, direction * 2f32.powi(i as i32 % 41 - 20));
            if i % 4 == 0 {
                ray.t_min = random.unit() / direction.length();
                ray.t_max = ray.t_min * 2.0;
            }
            if i % 11 == 0 {
                ray.t_min = -1.0;
            }
            ray
        })
        .collect()
}

/// These few rays, on trees small enough for one thread, are for Miri, which checks each memory
/// access of the vector code and is slower by a factor of a million.
#[test]
fn small_trees_agree_with_a_loop() {
    for count in [24, 30] {
        let mut random = Random(count as u64);
        let rays = rays(&mut random, 9);
        check!(SphereTree, spheres(&mut random, count, 0.5), rays.clone(), 1, point);
        check!(ConeTree, cones(&mut random, count, 1.0), rays.clone(), 1, line);
        check!(PatchTree, patches(&mut random, count, 1.0), rays.clone(), 1, quad);
        check!(TriangleTree, triangles(&mut random, count, 1.0), rays, 1, |t: &Triangle| *t);
    }
}

#[test]
fn spheres_agree_with_a_loop() {
    for (count, size) in [(1, 0.5), (2, 0.5), (9, 0.3), (300, 0.1), (3000, 0.02)] {
        let mut random = Random(count as u64);
        let (primitives, rays) = (spheres(&mut random, count, size), rays(&mut random, 1500));
        check!(SphereTree, primitives, rays, 3, point);
    }
}

#[test]
fn cones_agree_with_a_loop() {
    for (count, size) in [(1, 1.0), (7, 0.8), (100, 0.4), (2000, 0.1)] {
        let mut random = Random(count as u64);
        let (primitives, rays) = (cones(&mut random, count, size), rays(&mut random, 1500));
        check!(ConeTree, primitives, rays, 2, line);
    }
}

#[test]
fn patches_agree_with_a_loop() {
    for (count, size) in [(1, 1.0), (8, 0.8), (100, 0.4), (2000, 0.1)] {
        let mut random = Random(count as u64);
        let (primitives, rays) = (patches(&mut random, count, size), rays(&mut random, 1500));
        check!(PatchTree, primitives, rays, 2, quad);
    }
}

#[test]
fn triangles_agree_with_a_loop() {
    for (count, size) in [(2, 1.0), (8, 0.8), (100, 0.4), (2000, 0.1)] {
        let mut random = Random(count as u64);
        let (primitives, rays) = (triangles(&mut random, count, size), rays(&mut random, 1500));
        check!(TriangleTree, primitives, rays, 2, |triangle: &Triangle| *triangle);
    }
}

#[test]
fn rays_that_graze_agree_with_a_loop() {
    // Aimed at silhouettes and edges, from ever larger distances.
    let mut random = Random(77);
    let balls = spheres(&mut random, 500, 0.05);
    let tubes = cones(&mut random, 500, 0.2);
    let sheet = patches(&mut random, 500, 0.2);
    let mut aimed = |targets: &mut dyn FnMut(&mut Random) -> (Vec3, f32)| -> Vec<Ray> {
        (0..2000)
            .map(|i| {
                let (target, radius) = targets(&mut random);
                let direction = random.in_cube().normalize();
                let perpendicular = direction.cross(random.in_cube()).normalize();
                let distance = 4f32.powi(i % 10 - 2);
                Ray::new(target + radius * perpendicular - distance * direction, direction)
            })
            .collect()
    };
    let at_balls = aimed(&mut |random| {
        let ball = balls[random.below(balls.len())];
        (ball.center, ball.radius)
    });
    let at_tubes = aimed(&mut |random| {
        let tube = tubes[random.below(tubes.len())];
        let s = random.unit();
        (tube.p0.lerp(tube.p1, s), tube.r0 + s * (tube.r1 - tube.r0))
    });
    let at_edges = aimed(&mut |random| {
        let patch = sheet[random.below(sheet.len())];
        (patch.p00.lerp(patch.p10, random.unit()), 0.0)
    });
    check!(SphereTree, balls.clone(), at_balls, 300, point);
    check!(ConeTree, tubes.clone(), at_tubes, 300, line);
    check!(PatchTree, sheet.clone(), at_edges, 300, quad);
}

#[test]
fn rays_that_leave_a_surface_agree_with_a_loop() {
    let mut random = Random(78);
    let sheet = patches(&mut random, 300, 0.3);
    let faces = triangles(&mut random, 300, 0.3);
    let mut leaving = |on: &mut dyn FnMut(&mut Random) -> Vec3| -> Vec<Ray> {
        (0..3000)
            .map(|i| {
                let away = random.in_cube().normalize();
                // On the surface up to rounding, or at ever larger distances from it.
                let offset = if i % 4 == 0 { 0.0 } else { 2f32.powi(-(i % 30)) };
                let ray = Ray::new(on(&mut random) + offset * away, away);
                // Away from the surface, back through it, or with the surface in the interval.
                match i % 3 {
                    0 => ray,
                    1 => Ray::new(ray.origin, -1024.0 * away),
                    _ => Ray { t_min: -2.0 * offset, ..ray },
                }
            })
            .collect()
    };
    let from_patches = leaving(&mut |random| {
        let patch = sheet[random.below(sheet.len())];
        patch.position(Vec2::new(random.unit(), random.unit()))
    });
    let from_faces = leaving(&mut |random| {
        let face = faces[random.below(faces.len())];
        face.p0.lerp(face.p1, random.unit()).lerp(face.p2, random.unit())
    });
    check!(PatchTree, sheet, from_patches, 1000, quad);
    check!(TriangleTree, faces, from_faces, 1000, |triangle: &Triangle| *triangle);
}

#[test]
fn huge_and_tiny_scenes_agree_with_a_loop() {
    for exponent in [-60, -40, -20, 20, 40, 53, 59] {
        let scale = 2f32.powi(exponent);
        let mut random = Random(5);
        let mut balls = spheres(&mut random, 200, 0.2);
        let mut tubes = cones(&mut random, 200, 0.5);
        let mut sheet = patches(&mut random, 200, 0.5);
        let mut rays = rays(&mut random, 300);
        for ball in &mut balls {
            *ball = Sphere { center: scale * ball.center, radius: scale * ball.radius };
        }
        for c in &mut tubes {
            *c = RoundedCone {
                p0: scale * c.p0,
                r0: scale * c.r0,
                p1: scale * c.p1,
                r1: scale * c.r1,
            };
        }
        for p in &mut sheet {
            *p = BilinearPatch {
                p00: scale * p.p00,
                p10: scale * p.p10,
                p01: scale * p.p01,
                p11: scale * p.p11,
            };
        }
        for ray in &mut rays {
            // Up to the documented limit of 1e18, which is about 2^59.8.
            ray.origin = (scale * ray.origin).clamp(Vec3::splat(-1e18), Vec3::splat(1e18));
        }
        check!(SphereTree, balls, rays.clone(), 3, point);
        check!(ConeTree, tubes, rays.clone(), 3, line);
        check!(PatchTree, sheet, rays, 3, quad);
    }
}

#[test]
fn equal_primitives_give_the_lowest_id() {
    let mut random = Random(6);
    let balls = spheres(&mut random, 40, 0.3).repeat(25);
    check!(SphereTree, balls, rays(&mut random, 500), 100, point);
}

#[test]
fn primitives_with_nan_or_infinity_are_left_out() {
    let mut random = Random(7);
    let mut balls = spheres(&mut random, 100, 0.3);
    balls[3].center.y = f32::NAN;
    balls[50].radius = f32::NAN;
    balls[51].radius = -1.0;
    balls[52].radius = 0.0;
    balls[99].center.x = f32::INFINITY;
    let mut sheet = patches(&mut random, 100, 0.5);
    sheet[9].p10.z = f32::NAN;
    sheet[10].p10.z = f32::NEG_INFINITY;
    sheet[11] = BilinearPatch { p00: Vec3::X, p10: Vec3::X, p01: Vec3::X, p11: Vec3::X };
    let rays = rays(&mut random, 1000);
    // A patch without area stays in the tree, though no ray hits it.
    let left_out = (SphereTree::build(&balls).left_out(), PatchTree::build(&sheet).left_out());
    assert_eq!(left_out, (5, 2));
    check!(SphereTree, balls, rays.clone(), 100, point);
    check!(PatchTree, sheet, rays, 100, quad);
}

#[test]
fn an_empty_tree_meets_nothing() {
    let tree = SphereTree::build(&[]);
    let ray = Ray::new(Vec3::ZERO, Vec3::X);
    assert_eq!(tree.closest(&ray, Method::Enhanced), None);
    assert!(!tree.any(&ray, Method::Enhanced));
}

#[test]
fn a_packed_tree_agrees_with_a_tree_of_boxes() {
    let mut random = Random(11);
    let balls = spheres(&mut random, 50_000, 0.01);
    let boxes: Vec<_> = balls.iter().map(Sphere::bounds).collect();
    let (packed, plain) = (SphereTree::build(&balls), Bvh::build(&boxes));
    for isa in Isa::available() {
        let (packed, plain) = (packed.clone().with_isa(isa), plain.clone().with_isa(isa));
        for ray in rays(&mut random, 5000) {
            let expected = plain
                .closest(&ray, |id, ray| balls[id as usize].closest(ray).map(|hit| (hit.t, hit)))
                .map(|found| PrimitiveHit { id: found.id, hit: found.value });
            assert_eq!(packed.closest(&ray, Method::Enhanced), expected, "{isa:?}, {ray:?}");
        }
    }
}

#[test]
fn closest_of_and_any_of_agree_with_a_loop_over_every_kind_of_primitive() {
    let mut random = Random(17);
    macro_rules! check_of {
        ($primitives:expr) => {{
            let primitives = $primitives;
            let plain = Bvh::build_of(&primitives);
            let mut hits = 0;
            for ray in rays(&mut random, 1000) {
                let expected = loop_over(primitives.len(), |id| primitives[id].closest(&ray));
                for isa in Isa::available() {
                    let plain = plain.clone().with_isa(isa);
                    let found =
                        (plain.closest_of(&primitives, &ray), plain.any_of(&primitives, &ray));
                    assert_eq!(found, expected, "{isa:?}, {ray:?}");
                }
                hits += usize::from(expected.1);
            }
            assert!(hits > 30, "{hits} hits test little");
        }};
    }
    let balls = spheres(&mut random, 300, 0.2);
    let tubes = cones(&mut random, 300, 0.5);
    let sheet = patches(&mut random, 300, 0.5);
    check_of!(balls.repeat(2));
    check_of!(balls.iter().map(point).collect::<Vec<_>>());
    check_of!(tubes.clone());
    check_of!(tubes.iter().map(line).collect::<Vec<_>>());
    check_of!(sheet.clone());
    check_of!(sheet.iter().map(quad).collect::<Vec<_>>());
    check_of!(triangles(&mut random, 300, 0.5));
}

#[test]
#[should_panic(expected = "built over 3 primitives and is queried with 2")]
fn a_query_with_another_number_of_primitives_panics() {
    let balls = [Sphere { center: Vec3::ZERO, radius: 1.0 }; 3];
    let _ = Bvh::build_of(&balls).any_of(&balls[..2], &Ray::new(Vec3::ZERO, Vec3::X));
}

#[test]
fn a_tree_of_boxes_is_refitted_to_primitives_that_moved() {
    let mut random = Random(18);
    let mut tubes = cones(&mut random, 300, 0.5);
    (tubes[7].p0.x, tubes[7].p1.x) = (f32::NAN, f32::NAN);
    let mut tree = Bvh::build_of(&tubes);
    assert_eq!(tree.left_out(), 1);
    for tube in &mut tubes {
        (tube.p0, tube.p1) = (tube.p1 + Vec3::X, tube.p0 + Vec3::X);
    }
    assert_eq!(tree.refit_of(&tubes), Ok(()));
    assert_eq!(tree.bounds(), Bvh::build_of(&tubes).bounds());
    for ray in rays(&mut random, 1000) {
        let expected = loop_over(tubes.len(), |id| tubes[id].closest(&ray));
        assert_eq!((tree.closest_of(&tubes, &ray), tree.any_of(&tubes, &ray)), expected, "{ray:?}");
    }
    let error = RefitError::Count { built: 300, given: 299 };
    assert_eq!(tree.refit_of(&tubes[1..]), Err(error));
    tubes[7] = tubes[8];
    assert_eq!(tree.refit_of(&tubes), Err(RefitError::NoLongerEmpty { index: 7 }));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mut random = Random(12);
    let balls = spheres(&mut random, 200_000, 0.01);
    let trees = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        format!("{:?}", pool.install(|| SphereTree::build(&balls)))
    });
    assert!(trees[0] == trees[1] && trees[1] == trees[2], "the trees differ");
}

#[test]
fn a_tree_that_is_refitted_agrees_with_a_loop() {
    let mut random = Random(13);
    let mut balls = spheres(&mut random, 20_000, 0.02);
    let mut tree = SphereTree::build(&balls);
    for ball in &mut balls {
        ball.center = 0.5 * ball.center + 0.3 * random.in_cube();
    }
    tree.refit(&balls).expect("as many balls as before, none without radius");
    assert_eq!(tree.bounds(), SphereTree::build(&balls).bounds());
    for ray in rays(&mut random, 200) {
        let expected = loop_over(balls.len(), |id| balls[id].closest(&ray));
        assert_eq!(
            (tree.closest(&ray, Method::Enhanced), tree.any(&ray, Method::Enhanced)),
            expected
        );
    }
}

/// Moves primitives of every kind, refits, and compares with the loop and with a tree built anew.
#[test]
fn refitted_trees_of_every_kind_agree_with_a_loop() {
    let mut random = Random(15);
    macro_rules! check_refit {
        ($tree:ty, $make:ident, $size:expr) => {{
            let mut tree = <$tree>::build(&$make(&mut random, 2000, $size));
            let moved = $make(&mut random, 2000, $size);
            assert_eq!(tree.refit(&moved), Ok(()));
            assert_eq!(tree.bounds(), <$tree>::build(&moved).bounds());
            let mut hits = 0;
            for ray in rays(&mut random, 300) {
                let expected = loop_over(moved.len(), |id| moved[id].closest(&ray));
                let found =
                    (tree.closest(&ray, Method::Enhanced), tree.any(&ray, Method::Enhanced));
                assert_eq!(found, expected, "{ray:?}");
                hits += usize::from(expected.1);
            }
            assert!(hits > 30, "{hits} hits test little");
        }};
    }
    check_refit!(SphereTree, spheres, 0.1);
    check_refit!(ConeTree, cones, 0.2);
    check_refit!(PatchTree, patches, 0.2);
    check_refit!(TriangleTree, triangles, 0.2);
}

#[test]
fn a_refit_that_fails_names_the_reason_and_leaves_the_tree_as_it_was() {
    let mut random = Random(16);
    let mut balls = spheres(&mut random, 100, 0.2);
    balls[40].radius = 0.0;
    balls[70].center.y = f32::NAN;
    let mut tree = SphereTree::build(&balls);
    let before = format!("{tree:?}");
    for ball in &mut balls {
        ball.center += 1.0;
    }
    let with = |index: usize, ball: Sphere| {
        let mut balls = balls.clone();
        balls[index] = ball;
        balls
    };
    let unit = Sphere { center: Vec3::ZERO, radius: 1.0 };
    for (balls, error) in [
        (vec![], RefitError::Count { built: 100, given: 0 }),
        (balls[1..].to_vec(), RefitError::Count { built: 100, given: 99 }),
        (with(7, Sphere { radius: f32::NAN, ..unit }), RefitError::BecameEmpty { index: 7 }),
        (with(8, Sphere { radius: 0.0, ..unit }), RefitError::BecameEmpty { index: 8 }),
        (with(40, unit), RefitError::NoLongerEmpty { index: 40 }),
        (with(70, unit), RefitError::NoLongerEmpty { index: 70 }),
    ] {
        assert_eq!(tree.refit(&balls), Err(error));
        assert_eq!(format!("{tree:?}"), before, "{error}");
    }
    assert_eq!(tree.refit(&balls), Ok(()));
    assert_eq!(tree.bounds(), SphereTree::build(&balls).bounds());
}
