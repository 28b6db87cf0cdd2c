//! The tree gives the same answer as a loop over all primitives.

mod support;

use glam::Vec3;
use rotund_bvh::{Bvh, Found, RefitError};
use rotund_geometry::{Aabb, Ray};
use support::{Ball, Random, ask, ask_any, boxes, loop_over};

fn cloud(random: &mut Random, count: usize, radius: f32) -> Vec<Ball> {
    (0..count)
        .map(|_| Ball { center: random.in_cube(), radius: radius * (0.1 + random.unit()) })
        .collect()
}

fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = 2.0 * random.in_cube();
            let direction = random.in_cube() * 2f32.powi(i as i32 % 9 - 4);
            let mut ray = Ray::new(origin, direction);
            if i % 3 == 0 {
                ray.t_min = random.unit();
                ray.t_max = ray.t_min + 2.0 * random.unit();
            }
            if i % 7 == 0 {
                ray.t_min = -1.0;
            }
            ray
        })
        .collect()
}

#[test]
fn closest_and_any_agree_with_a_loop() {
    for (count, radius) in
        [(1, 0.5), (2, 0.5), (7, 0.3), (8, 0.3), (9, 0.3), (100, 0.2), (5000, 0.03)]
    {
        let mut random = Random(count as u64);
        let balls = cloud(&mut random, count, radius);
        let bvh = Bvh::build(&boxes(&balls));
        let mut hits = 0;
        for ray in rays(&mut random, 2000) {
            let expected = loop_over(&balls, &ray);
            assert_eq!(ask(&bvh, &balls, &ray), expected, "{count} balls, {ray:?}");
            assert_eq!(ask_any(&bvh, &balls, &ray), expected.is_some(), "{count} balls, {ray:?}");
            hits += usize::from(expected.is_some());
        }
        assert!(hits >= 10, "{count} balls: only {hits} hits test little");
    }
}

#[test]
fn a_tree_built_in_parallel_agrees_with_a_loop() {
    let mut random = Random(9);
    let balls = cloud(&mut random, 100_000, 0.01);
    let bvh = Bvh::build(&boxes(&balls));
    for ray in rays(&mut random, 100) {
        assert_eq!(ask(&bvh, &balls, &ray), loop_over(&balls, &ray), "{ray:?}");
    }
}

#[test]
fn a_tie_goes_to_the_lower_id() {
    // Every ball ten times, shuffled.
    let mut random = Random(3);
    let mut balls = cloud(&mut random, 100, 0.2).repeat(10);
    for i in (1..balls.len()).rev() {
        balls.swap(i, random.below(i + 1));
    }
    let bvh = Bvh::build(&boxes(&balls));
    for ray in rays(&mut random, 2000) {
        assert_eq!(ask(&bvh, &balls, &ray), loop_over(&balls, &ray), "{ray:?}");
    }
}

#[test]
fn the_interval_shrinks_to_the_closest_hit_so_far() {
    let row: Vec<Ball> =
        (0..100).map(|i| Ball { center: Vec3::X * i as f32, radius: 0.25 }).collect();
    let bvh = Bvh::build(&boxes(&row));
    let ray = Ray::new(Vec3::new(-1.0, 0.0, 0.0), Vec3::X);
    let (mut visited, mut bound) = (0, f32::INFINITY);
    let hit = bvh.closest(&ray, |id, ray| {
        visited += 1;
        assert!(ray.t_max <= bound, "t_max grew from {bound} to {}", ray.t_max);
        let t = row[id as usize].closest(ray)?;
        bound = t;
        Some((t, id))
    });
    assert_eq!(hit, Some(Found { id: 0, t: 0.75, value: 0 }));
    assert!(visited <= 8, "visited {visited} balls of 100 behind the first");
}

#[test]
fn an_answer_outside_the_interval_is_a_miss() {
    let bvh = Bvh::build(&[Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) }]);
    let ray = Ray { t_min: 1.0, t_max: 5.0, ..Ray::new(Vec3::X * -3.0, Vec3::X) };
    for (answer, expected) in
        [(1.0, Some(1.0)), (5.0, Some(5.0)), (0.999, None), (5.001, None), (f32::NAN, None)]
    {
        let found = bvh.closest(&ray, |_, _| Some((answer, ())));
        assert_eq!(found.map(|found| found.t), expected, "{answer}");
    }
}

#[test]
fn each_id_is_visited_at_most_once() {
    let mut random = Random(5);
    let balls = cloud(&mut random, 1000, 0.3);
    let bvh = Bvh::build(&boxes(&balls));
    for ray in rays(&mut random, 100) {
        let mut visited = vec![0; balls.len()];
        assert!(
            !bvh.any(&ray, |id, _| {
                visited[id as usize] += 1;
                false
            }),
            "nothing answered true"
        );
        assert!(visited.iter().all(|&count| count <= 1), "{ray:?}");
    }
}

#[test]
fn trees_nest() {
    // Two levels: copies of one tree, each moved.
    let mut random = Random(8);
    let balls = cloud(&mut random, 50, 0.3);
    let inner = Bvh::build(&boxes(&balls));
    let moves: Vec<Vec3> = (0..40).map(|_| 8.0 * random.in_cube()).collect();
    let outer: Vec<Aabb> = moves
        .iter()
        .map(|&by| Aabb { min: inner.bounds().min + by, max: inner.bounds().max + by })
        .collect();
    let outer = Bvh::build(&outer);
    for _ in 0..1000 {
        let ray = Ray::new(10.0 * random.in_cube(), random.in_cube());
        let moved = |by: Vec3, ray: &Ray| Ray { origin: ray.origin - by, ..*ray };
        let found = outer.closest(&ray, |instance, ray| {
            let (ball, t) = ask(&inner, &balls, &moved(moves[instance as usize], ray))?;
            Some((t, ball))
        });
        let expected =
            moves.iter().enumerate().fold(
                None,
                |best: Option<Found<u32>>, (i, &by)| match loop_over(&balls, &moved(by, &ray)) {
                    Some((ball, t)) if best.is_none_or(|best| t < best.t) => {
                        Some(Found { id: i as u32, t, value: ball })
                    }
                    _ => best,
                },
            );
        assert_eq!(found, expected, "{ray:?}");
    }
}

#[test]
fn a_refitted_tree_answers_as_one_that_is_built_anew() {
    let mut random = Random(21);
    let mut balls = cloud(&mut random, 3000, 0.05);
    let mut bvh = Bvh::build(&boxes(&balls));
    for step in 0..4 {
        for ball in &mut balls {
            ball.center += 0.3 * random.in_cube();
        }
        bvh.refit(&boxes(&balls)).expect("as many balls as before");
        let fresh = Bvh::build(&boxes(&balls));
        assert_eq!(bvh.bounds(), fresh.bounds(), "step {step}");
        for ray in rays(&mut random, 500) {
            let expected = loop_over(&balls, &ray);
            assert_eq!(ask(&fresh, &balls, &ray), expected, "fresh, step {step}, {ray:?}");
            assert_eq!(ask(&bvh, &balls, &ray), expected, "step {step}, {ray:?}");
            assert_eq!(ask_any(&bvh, &balls, &ray), expected.is_some(), "step {step}, {ray:?}");
        }
    }
}

#[test]
fn a_refit_that_fails_names_the_reason_and_leaves_the_tree_as_it_was() {
    let mut random = Random(22);
    let balls = cloud(&mut random, 100, 0.2);
    let mut built = boxes(&balls);
    built[40] = Aabb::EMPTY;
    built[70].min.y = f32::NAN;
    let mut bvh = Bvh::build(&built);
    let before = format!("{bvh:?}");

    let moved: Vec<Aabb> =
        built.iter().map(|b| Aabb { min: b.min + 1.0, max: b.max + 1.0 }).collect();
    let with = |index: usize, bounds: Aabb| {
        let mut boxes = moved.clone();
        boxes[index] = bounds;
        boxes
    };
    let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
    let nan = Aabb { max: Vec3::NAN, ..unit };
    for (boxes, error, text) in [
        (vec![], RefitError::Count { built: 100, given: 0 }, "100 elements"),
        (moved[1..].to_vec(), RefitError::Count { built: 100, given: 99 }, "refitted to 99"),
        (with(7, nan), RefitError::BecameEmpty { index: 7 }, "element 7"),
        (with(8, Aabb::EMPTY), RefitError::BecameEmpty { index: 8 }, "element 8"),
        (with(40, unit), RefitError::NoLongerEmpty { index: 40 }, "element 40"),
        (with(70, unit), RefitError::NoLongerEmpty { index: 70 }, "element 70"),
    ] {
        assert_eq!(bvh.refit(&boxes), Err(error));
        assert!(error.to_string().contains(text), "{error}");
        assert_eq!(format!("{bvh:?}"), before, "{error}");
    }
    assert_eq!(bvh.refit(&moved), Ok(()));
    assert_ne!(format!("{bvh:?}"), before);
    assert_eq!(bvh.bounds(), Bvh::build(&moved).bounds());
}

#[test]
fn empty_and_small_trees_can_be_refitted() {
    let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
    let everything = Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
    let mut empty = Bvh::build(&[]);
    assert_eq!(empty.refit(&[]), Ok(()));
    assert_eq!(empty.refit(&[unit]), Err(RefitError::Count { built: 0, given: 1 }));
    let mut single = Bvh::build(&[unit]);
    assert_eq!(single.refit(&[everything]), Ok(()));
    assert_eq!(single.bounds(), Bvh::build(&[everything]).bounds());
    assert!(single.any(&Ray::new(Vec3::splat(9.0), Vec3::X), |id, _| id == 0));
}
