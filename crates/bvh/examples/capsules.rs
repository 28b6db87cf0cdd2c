//! A hundred thousand moving capsules, picked by ray: the tree is refitted in each step.

use rotund_bvh::geometry::glam::{Quat, Vec3};
use rotund_bvh::geometry::{Ray, RoundedCone};
use rotund_bvh::{ConeTree, Method, PrimitiveHit};

const COUNT: usize = 100_000;

/// The tapered capsules at a time: they orbit the y axis, the inner ones faster.
fn swarm(time: f32) -> Vec<RoundedCone> {
    let capsule = |i: usize| {
        // Even in the volume of a ring: the additive recurrence of M. Roberts (2018).
        let [a, b, c] = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|x| (i as f64 * x).fract());
        let (distance, height) = (1.0 + 3.0 * a as f32, b as f32 - 0.5);
        let angle = std::f32::consts::TAU * c as f32 + time / distance.powi(2);
        let turn = Quat::from_rotation_y(angle);
        let tail = turn * Vec3::new(distance, height, 0.0);
        let head = tail + turn * Vec3::new(0.002, 0.004, -0.02);
        RoundedCone { p0: tail, r0: 0.001, p1: head, r1: 0.004 }
    };
    (0..COUNT).map(capsule).collect()
}

/// The answer without a tree.
fn brute_force(capsules: &[RoundedCone], ray: &Ray) -> Option<PrimitiveHit> {
    let hits = capsules.iter().enumerate();
    let hits =
        hits.filter_map(|(id, c)| Some(PrimitiveHit { id: id as u32, hit: c.closest(ray)? }));
    // The first of equal ones, as in a tree.
    hits.min_by(|a, b| a.hit.t.partial_cmp(&b.hit.t).expect("no t is NaN"))
}

/// Moves the swarm, and picks capsules on the way.
pub(crate) fn main() {
    let mut tree = ConeTree::build(&swarm(0.0));
    let mut built_cost = tree.statistics().sah;
    let (mut picked, mut rebuilt) = (0, 0);
    for step in 1..=8 {
        let capsules = swarm(0.5 * step as f32);
        tree.refit(&capsules).expect("as many capsules as before, all of them finite");
        // Queries slow down as neighbors in the tree move apart. The surface area heuristic tells
        // when a new tree is worth its build.
        if tree.statistics().sah > 1.5 * built_cost {
            tree = ConeTree::build(&capsules);
            built_cost = tree.statistics().sah;
            rebuilt += 1;
        }

        let eye = Vec3::new(0.0, 3.0, 6.0);
        for pixel in 0..25 {
            let target = Vec3::new((pixel % 5) as f32 - 2.0, 0.0, (pixel / 5) as f32 - 2.0);
            let ray = Ray::new(eye, target - eye);
            let found = tree.closest(&ray, Method::Enhanced);
            assert_eq!(found, brute_force(&capsules, &ray), "step {step}, {ray:?}");
            picked += usize::from(found.is_some());
        }
    }
    assert!(picked > 50, "{picked} of 200 rays hit a capsule");
    assert!((1..8).contains(&rebuilt), "{rebuilt} new trees in 8 steps");
}
