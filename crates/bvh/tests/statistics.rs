//! The size and the expected cost of packed trees.

mod support;

use glam::Vec3;
use rotund_bvh::{Method, PatchTree, SphereTree, TriangleTree};
use rotund_geometry::{BilinearPatch, Ray, Triangle};
use support::{Random, spheres, triangles};

#[test]
fn statistics_and_visits_add_up() {
    let mut random = Random(14);
    let balls = spheres(&mut random, 10_000, 0.02);
    let tree = SphereTree::build(&balls);
    let statistics = tree.statistics();
    assert_eq!((statistics.primitives, tree.left_out()), (balls.len(), 0));
    assert_eq!(statistics.children, statistics.nodes - 1 + statistics.leaves);
    assert!(statistics.bytes < 56 * balls.len(), "{statistics:?}");
    let through_the_middle = tree.visits(&Ray::new(Vec3::splat(-2.0), Vec3::ONE), Method::Enhanced);
    assert!(through_the_middle.nodes > 0 && through_the_middle.primitives > 0);
    assert_eq!(tree.visits(&Ray::new(Vec3::splat(2.0), Vec3::ONE), Method::Enhanced).primitives, 0);
}

#[test]
fn the_expected_cost_of_a_tree_does_not_depend_on_its_scale() {
    let mut random = Random(19);
    let faces = triangles(&mut random, 1000, 0.2);
    let sah = |exponent: i32| {
        let scale = 2f32.powi(exponent);
        let scaled = |t: &Triangle| {
            let [p0, p1, p2] = [t.p0, t.p1, t.p2].map(|p| scale * p);
            Triangle { p0, p1, p2 }
        };
        let tree = TriangleTree::build(&faces.iter().map(scaled).collect::<Vec<_>>());
        tree.statistics().sah
    };
    let usual = sah(0);
    assert!(usual > 1.0 && usual < 100.0, "{usual}");
    // The builder compares areas in `f32`, where these overflow or underflow, so the trees differ.
    for exponent in [-100, -70, 70, 100, 126] {
        let sah = sah(exponent);
        assert!(sah > 1.0 && sah < 1000.0, "2^{exponent}: {sah}");
    }
}

/// Eight tiles fit into a leaf. With four at either end of a long diagonal, most rays would meet
/// the box of that leaf and miss every tile. Where the box is small beside the tree, few rays do.
#[test]
fn what_lies_far_apart_has_leaves_of_its_own() {
    let tile = |corner: Vec3| {
        let [u, v] = [0.01 * Vec3::X, 0.01 * Vec3::Y];
        BilinearPatch { p00: corner, p10: corner + u, p01: corner + v, p11: corner + u + v }
    };
    let at = |place: f32| (0..4).map(move |i| tile(Vec3::splat(place) + 0.01 * i as f32 * Vec3::X));
    let apart = PatchTree::build(&at(0.0).chain(at(1.0)).collect::<Vec<_>>());
    assert_eq!(apart.statistics().leaves, 2);
    let between = Ray::new(Vec3::new(0.5, 0.5, -1.0), Vec3::Z);
    assert_eq!(apart.visits(&between, Method::Enhanced).primitives, 0);
    let aimed = Ray::new(Vec3::new(0.005, 0.005, -1.0), Vec3::Z);
    assert_eq!(apart.visits(&aimed, Method::Enhanced).primitives, 4);

    let row = (0..8).map(|i| tile(0.01 * i as f32 * Vec3::X));
    let together = PatchTree::build(&row.collect::<Vec<_>>());
    assert_eq!(together.statistics().leaves, 1);

    let far = tile(Vec3::splat(100.0));
    let small = PatchTree::build(&at(0.0).chain(at(1.0)).chain([far]).collect::<Vec<_>>());
    assert_eq!(small.statistics().leaves, 2);
}
