//! All crossings of a ray, and the union of solids, against loops over all primitives, on every
//! instruction set.

mod support;

use glam::Vec3;
use rotund_bvh::{ConeTree, Crossing, Isa, Method, PatchTree, SphereTree, Start};
use rotund_geometry::{BilinearPatch, End, ExactInterval, Hit, Ray, RoundedCone, Solid, Sphere};
use std::cmp::Ordering;
use std::ops::ControlFlow;
use support::Random;

/// The interval of a ray inside each solid that it meets.
fn intervals<S: Solid>(solids: &[S], ray: &Ray) -> Vec<(u32, ExactInterval)> {
    (0..).zip(solids).filter_map(|(id, solid)| Some((id, solid.interval_exactly(ray)?))).collect()
}

/// The boundaries of the union by merging intervals until none overlap.
fn boundaries<S: Solid>(solids: &[S], ray: &Ray) -> Vec<Crossing> {
    let all = intervals(solids, ray);
    let mut found = Vec::new();
    // An entry is a boundary if no other interval begins before it and ends there or later. Of
    // equal ones, that with the lowest id counts.
    let shadows = |end, id: u32, of: &ExactInterval| {
        all.iter().any(|(other, by)| {
            let begins = by.compare(End::Entry, of, end);
            let ends = by.compare(End::Exit, of, end);
            let (covers, equal) = match end {
                End::Entry => (begins == Ordering::Less && ends != Ordering::Less, begins),
                End::Exit => (begins != Ordering::Greater && ends == Ordering::Greater, ends),
            };
            covers || (equal == Ordering::Equal && *other < id)
        })
    };
    for (id, of) in &all {
        for end in [End::Entry, End::Exit] {
            let from = of.compare_with(end, ray.t_min) != Ordering::Less;
            if !from || shadows(end, *id, of) {
                continue;
            }
            let hit = solids[*id as usize].crossing(ray, end).expect("the line meets the solid");
            if hit.t <= ray.t_max {
                found.push((*of, end, Crossing { id: *id, hit, enters: end == End::Entry }));
            }
        }
    }
    found.sort_by(|(a, a_end, x), (b, b_end, y)| {
        a.compare(*a_end, b, *b_end).then(y.enters.cmp(&x.enters))
    });
    found.into_iter().map(|(.., crossing)| crossing).collect()
}

/// All crossings by a loop.
fn crossings<S: Solid>(solids: &[S], ray: &Ray) -> Vec<Crossing> {
    let mut found = Vec::new();
    for (id, solid) in (0..).zip(solids) {
        for end in [End::Entry, End::Exit] {
            if let Some(hit) = solid.crossing(ray, end)
                && ray.t_min <= hit.t
                && hit.t <= ray.t_max
            {
                found.push(Crossing { id, hit, enters: end == End::Entry });
            }
        }
    }
    sorted(found)
}

fn sorted(mut found: Vec<Crossing>) -> Vec<Crossing> {
    found.sort_by(|a, b| {
        let by_t = a.hit.t.partial_cmp(&b.hit.t).expect("no NaN");
        by_t.then_with(|| (a.id, !a.enters).cmp(&(b.id, !b.enters)))
    });
    found
}

fn collect(query: impl FnOnce(&mut dyn FnMut(&Crossing) -> ControlFlow<()>)) -> Vec<Crossing> {
    let mut found = Vec::new();
    query(&mut |crossing| {
        found.push(*crossing);
        ControlFlow::Continue(())
    });
    found
}

/// Compares trees over `solids` with the loops, on every instruction set. Returns the number of
/// boundaries and of crossings.
macro_rules! check {
    ($tree:ty, $solids:expr, $rays:expr) => {{
        let (solids, rays) = ($solids, $rays);
        let trees: Vec<$tree> =
            Isa::available().into_iter().map(|isa| <$tree>::build(&solids).with_isa(isa)).collect();
        let (mut boundary_count, mut crossing_count) = (0, 0);
        for ray in &rays {
            let expected = boundaries(&solids, ray);
            let all = crossings(&solids, ray);
            boundary_count += expected.len();
            crossing_count += all.len();
            let inside = intervals(&solids, ray).iter().any(|(_, of)| {
                of.compare_with(End::Entry, ray.t_min) == Ordering::Less
                    && of.compare_with(End::Exit, ray.t_min) != Ordering::Less
            });
            let point = solids.iter().any(|solid| solid.contains(ray.origin));
            for tree in &trees {
                let isa = tree.isa();
                let found = collect(|visit| _ = tree.boundaries(ray, visit));
                assert_eq!(found, expected, "{isa:?} {ray:?}");
                let next = tree.boundary(ray, Start::ByPosition);
                assert_eq!(next, expected.first().copied(), "{isa:?} {ray:?}");
                assert_eq!(next.is_some_and(|next| !next.enters), inside && next.is_some());
                let outside = tree.boundary(ray, Start::Outside);
                match outside {
                    Some(entry) if inside => {
                        assert!(entry.enters && entry.hit.t == ray.t_min, "{entry:?} {ray:?}");
                    }
                    outside => assert_eq!(outside, next, "{isa:?} {ray:?}"),
                }
                let found = collect(|visit| _ = tree.crossings(ray, Method::Enhanced, visit));
                assert_eq!(found, all, "{isa:?} {ray:?}");
                assert_eq!(tree.contains(ray.origin), point, "{isa:?} {ray:?}");
            }
        }
        (boundary_count, crossing_count)
    }};
}

/// Rays from outside, from inside, from surfaces, and segments.
fn rays(random: &mut Random, count: usize, surface: impl Fn(&Ray) -> Option<Hit>) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let through = |random: &mut Random, origin: Vec3| {
                Ray::new(origin, (0.6 * random.in_cube() - origin) * random.power(1.0))
            };
            let ray = match i % 4 {
                0 => {
                    let origin = 3.0 * random.direction().as_vec3();
                    through(random, origin)
                }
                1 => {
                    let origin = random.in_cube();
                    through(random, origin)
                }
                _ => {
                    let origin = 3.0 * random.direction().as_vec3();
                    let first = through(random, origin);
                    let direction = random.direction().as_vec3();
                    surface(&first).map_or(first, |hit| hit.spawn(direction))
                }
            };
            match random.below(3) {
                0 => Ray { t_max: random.unit(), ..ray },
                1 => Ray { t_min: 0.5 * random.unit(), ..ray },
                _ => ray,
            }
        })
        .collect()
}

#[test]
fn spheres_that_overlap_nest_touch_and_repeat() {
    let mut random = Random(0x00B0_D1E5);
    let mut solids: Vec<Sphere> = (0..300)
        .map(|_| Sphere { center: random.in_cube(), radius: 0.05 + 0.3 * random.unit() })
        .collect();
    // Copies, balls inside others, and balls that touch.
    for i in 0..60 {
        let ball = solids[i];
        solids.push(ball);
        solids.push(Sphere { radius: 0.5 * ball.radius, ..ball });
        let center = ball.center + 2.0 * ball.radius * Vec3::X;
        solids.push(Sphere { center, ..ball });
    }
    let tree = SphereTree::build(&solids);
    let surface = |ray: &Ray| tree.closest(ray, Method::Enhanced).map(|found| found.hit);
    let rays = rays(&mut random, 3000, surface);
    let (boundaries, crossings) = check!(SphereTree, solids, rays);
    assert!(boundaries > 5_000 && crossings > 6 * boundaries, "{boundaries} {crossings}");
}

#[test]
fn chains_of_cones_with_shared_balls() {
    let mut random = Random(0x7EE5);
    let mut solids = Vec::new();
    for _ in 0..30 {
        let (mut p0, mut r0) = (random.in_cube(), 0.02 + 0.1 * random.unit());
        for _ in 0..12 {
            let p1 = p0 + 0.2 * random.in_cube();
            let r1 = if random.below(2) == 0 { r0 } else { 0.02 + 0.1 * random.unit() };
            solids.push(RoundedCone { p0, r0, p1, r1 });
            (p0, r0) = (p1, r1);
        }
    }
    // A segment without length is a ball.
    solids.push(RoundedCone { p0: Vec3::ZERO, r0: 0.3, p1: Vec3::ZERO, r1: 0.3 });
    let tree = ConeTree::build(&solids);
    let surface = |ray: &Ray| tree.closest(ray, Method::Enhanced).map(|found| found.hit);
    let rays = rays(&mut random, 3000, surface);
    let (boundaries, crossings) = check!(ConeTree, solids, rays);
    assert!(boundaries > 5_000 && crossings > 2 * boundaries, "{boundaries} {crossings}");
}

#[test]
fn a_straight_tube_of_many_pieces_has_one_entry_and_one_exit() {
    for pieces in [1, 2, 8, 64, 500] {
        let x = |i: usize| i as f32 / pieces as f32 * 4.0 - 2.0;
        let tube: Vec<RoundedCone> = (0..pieces)
            .map(|i| RoundedCone { p0: x(i) * Vec3::X, r0: 0.25, p1: x(i + 1) * Vec3::X, r1: 0.25 })
            .collect();
        let tree = ConeTree::build(&tube);
        for ray in [
            Ray::new(Vec3::new(-5.0, 0.1, 0.0), Vec3::new(1.0, 0.0, 0.0)),
            Ray::new(Vec3::new(-5.0, 0.3, 0.0), Vec3::new(1.0, -0.06, 0.01)),
            Ray::new(Vec3::new(0.0, 3.0, 0.0), Vec3::new(0.1, -1.0, 0.0)),
        ] {
            let found = collect(|visit| _ = tree.boundaries(&ray, visit));
            let sides: Vec<bool> = found.iter().map(|crossing| crossing.enters).collect();
            assert_eq!(sides, [true, false], "{pieces} pieces, {ray:?}");
            let inside = Ray { t_min: 0.5 * (found[0].hit.t + found[1].hit.t), ..ray };
            let exit = tree.boundary(&inside, Start::ByPosition).expect("the exit");
            assert_eq!((exit.hit.t, exit.enters), (found[1].hit.t, false));
        }
    }
}

#[test]
fn ten_thousand_copies_are_one_solid() {
    let ball = Sphere { center: Vec3::new(0.1, 0.2, 0.3), radius: 0.7 };
    let tree = SphereTree::build(&vec![ball; 10_000]);
    for origin in [Vec3::new(-4.0, 0.0, 0.0), Vec3::ZERO] {
        let ray = Ray::new(origin, Vec3::X);
        let found = collect(|visit| _ = tree.boundaries(&ray, visit));
        assert_eq!(found.last().map(|c| (c.id, c.enters)), Some((0, false)));
        assert_eq!(tree.boundary(&ray, Start::ByPosition), found.first().copied());
        let all = collect(|visit| _ = tree.crossings(&ray, Method::Enhanced, visit));
        assert_eq!(all.len(), 10_000 * found.len());
    }
}

#[test]
fn patches_are_crossed_twice_and_visits_may_stop() {
    let saddle = BilinearPatch {
        p00: Vec3::new(-1.0, -1.0, 1.0),
        p10: Vec3::new(1.0, -1.0, -1.0),
        p01: Vec3::new(-1.0, 1.0, -1.0),
        p11: Vec3::new(1.0, 1.0, 1.0),
    };
    let tree = PatchTree::build(&[saddle]);
    // Along the curve z = x y at y = x, which is a parabola.
    let ray = Ray::new(Vec3::new(-2.0, -2.0, 0.25), Vec3::new(1.0, 1.0, 0.0));
    let found = collect(|visit| _ = tree.crossings(&ray, Method::Enhanced, visit));
    let ts: Vec<f32> = found.iter().map(|crossing| crossing.hit.t).collect();
    assert_eq!(ts, [1.5, 2.5]);
    assert_ne!(found[0].enters, found[1].enters);
    let mut visits = 0;
    let result = tree.crossings(&ray, Method::Enhanced, |_| {
        visits += 1;
        ControlFlow::Break(())
    });
    assert_eq!((visits, result), (1, ControlFlow::Break(())));
}

#[test]
fn invalid_rays_and_empty_trees_have_no_boundaries() {
    let tree = SphereTree::build(&[Sphere::default()]);
    let empty = SphereTree::build(&[]);
    let good = Ray::new(Vec3::ZERO, Vec3::X);
    for ray in [
        Ray { origin: Vec3::NAN, ..good },
        Ray { direction: Vec3::ZERO, ..good },
        Ray { t_min: f32::NAN, ..good },
        Ray { t_max: f32::NAN, ..good },
        Ray { t_min: 2.0, t_max: 1.0, ..good },
    ] {
        assert_eq!(tree.boundary(&ray, Start::ByPosition), None, "{ray:?}");
        assert_eq!(tree.boundary(&ray, Start::Outside), None, "{ray:?}");
        assert!(collect(|visit| _ = tree.boundaries(&ray, visit)).is_empty(), "{ray:?}");
    }
    assert_eq!(empty.boundary(&good, Start::ByPosition), None);
    assert!(!empty.contains(Vec3::ZERO));
    assert!(!tree.contains(Vec3::NAN));
    assert!(tree.contains(Vec3::X));
}
