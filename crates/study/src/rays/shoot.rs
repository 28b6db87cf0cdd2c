//! Traces rays through trees, and times it.

use super::recipe::{self, Target};
use cpu_time::ThreadTime;
use rayon::prelude::*;
use rotund_bvh::{
    ConeTree, Isa, Method, PatchTree, PrimitiveHit, SphereTree, Statistics, TriangleTree, Visits,
};
use rotund_geometry::{Aabb, BilinearPatch, Hit, Ray, RoundedCone, Sphere, Triangle, vanilla};
use std::time::Instant;

/// A tree that is measured.
pub(super) trait Traced: Sync {
    fn closest(&self, ray: &Ray, method: Method) -> Option<PrimitiveHit>;
    fn any(&self, ray: &Ray, method: Method) -> bool;
    fn visits(&self, ray: &Ray, method: Method) -> Visits;
    fn statistics(&self) -> Statistics;
}

/// A primitive with a packed tree.
pub(super) trait Primitive: Sync + Sized {
    type Tree: Traced + Send;
    fn build(primitives: &[Self], isa: Isa) -> Self::Tree;
    fn exact(&self, ray: &Ray, method: Method) -> Option<Hit>;
    fn bounds(&self) -> Aabb;
}

macro_rules! traced {
    ($($tree:ty, $primitive:ty, |$p:ident| $vanilla:expr;)*) => {$(
        impl Traced for $tree {
            #[inline]
            fn closest(&self, ray: &Ray, method: Method) -> Option<PrimitiveHit> {
                self.closest(ray, method)
            }

            #[inline]
            fn any(&self, ray: &Ray, method: Method) -> bool {
                self.any(ray, method)
            }

            fn visits(&self, ray: &Ray, method: Method) -> Visits {
                self.visits(ray, method)
            }

            fn statistics(&self) -> Statistics {
                self.statistics()
            }
        }

        impl Primitive for $primitive {
            type Tree = $tree;

            fn build(primitives: &[Self], isa: Isa) -> $tree {
                <$tree>::build(primitives).with_isa(isa)
            }

            fn exact(&self, ray: &Ray, method: Method) -> Option<Hit> {
                let $p = self;
                match method {
                    Method::Enhanced => self.closest(ray),
                    Method::Vanilla => $vanilla.closest(ray),
                }
            }

            fn bounds(&self) -> Aabb {
                self.bounds()
            }
        }
    )*};
}

traced! {
    SphereTree, Sphere, |s| vanilla::Point { center: s.center, radius: s.radius };
    ConeTree, RoundedCone, |c| vanilla::Line { p0: c.p0, r0: c.r0, p1: c.p1, r1: c.r1 };
    PatchTree, BilinearPatch, |p| vanilla::Quad { p0: p.p00, p1: p.p10, p2: p.p11, p3: p.p01 };
    TriangleTree, Triangle, |t| *t;
}

/// The four kinds of rays.
pub(super) const KINDS: [&str; 4] = ["primary", "diffuse", "shadow", "random"];

/// The rays of a kind, and whether they are occlusion queries.
pub(super) struct Volley {
    pub(super) name: &'static str,
    pub(super) rays: Vec<Ray>,
    pub(super) any: bool,
}

/// Generates all rays for a tree.
pub(super) fn volleys(tree: &impl Traced, target: &Target, method: Method) -> [Volley; 4] {
    let primary = recipe::primary(target);
    let hit = |ray: &Ray| tree.closest(ray, method).map(|found| found.hit);
    let (diffuse, shadow) = recipe::secondary(target, &primary, hit);
    let random = recipe::random(target, 1_000_000);
    let [first, second, third, fourth] = KINDS;
    [
        Volley { name: first, rays: primary, any: false },
        Volley { name: second, rays: diffuse, any: false },
        Volley { name: third, rays: shadow, any: true },
        Volley { name: fourth, rays: random, any: false },
    ]
}

/// One pass over all rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass {
    pub(super) mrays_per_second: f64,
    pub(super) hit_share: f64,
}

/// Traces on one thread, and measures its CPU time, which excludes that of other programs.
pub(super) fn on_one_thread(tree: &impl Traced, volley: &Volley, method: Method) -> Pass {
    let start = ThreadTime::now();
    let hits = shoot(tree, &volley.rays, volley.any, method);
    pass(volley, hits, start.elapsed().as_secs_f64())
}

/// Traces on all threads of the pool, and measures elapsed time.
pub(super) fn on_all_threads(tree: &impl Traced, volley: &Volley, method: Method) -> Pass {
    let start = Instant::now();
    let hits = volley.rays.par_chunks(4096).map(|rays| shoot(tree, rays, volley.any, method)).sum();
    pass(volley, hits, start.elapsed().as_secs_f64())
}

fn pass(volley: &Volley, hits: usize, seconds: f64) -> Pass {
    let count = volley.rays.len().max(1) as f64;
    Pass { mrays_per_second: 1e-6 * count / seconds, hit_share: hits as f64 / count }
}

#[inline(never)]
fn shoot(tree: &impl Traced, rays: &[Ray], any: bool, method: Method) -> usize {
    if any {
        return rays.iter().filter(|ray| tree.any(ray, method)).count();
    }
    let (mut hits, mut sum) = (0, 0.0);
    for ray in rays {
        if let Some(found) = tree.closest(ray, method) {
            hits += 1;
            sum += found.hit.t;
        }
    }
    // This keeps the compiler from removing the computation of hits.
    std::hint::black_box(sum);
    hits
}
