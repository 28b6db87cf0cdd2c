//! References for the answers of a tree: a simple tree whose correctness is evident, and a loop.
//!
//! The simple tree splits the primitives at the median of their centers along the longest axis,
//! tests boxes in `f64`, and calls the exact test of each primitive that it reaches. It shares no
//! code with the trees of `rotund_bvh`. A loop over a million primitives is too slow for millions
//! of rays, so only few rays are compared with it.

use super::recipe::{self, Target};
use super::shoot::{Primitive, Traced};
use anyhow::{Result, bail};
use rayon::prelude::*;
use rotund_bvh::{Isa, Method, PrimitiveHit};
use rotund_geometry::{Aabb, Ray};
use rotund_report::console::say;

/// How many rays of each scene are compared with a loop.
const LOOPED: usize = 40;

/// Compares the answers of trees for all instruction sets, to the bit.
pub(super) fn verify<P: Primitive>(
    scene: &str,
    primitives: &[P],
    target: &Target,
    count: usize,
    method: Method,
    sets: &[Isa],
) -> Result<()> {
    let plain = Plain::build(primitives);
    let closest = |ray: &Ray| plain.closest(primitives, ray, method);
    let mut rays = recipe::primary(target);
    let (diffuse, shadow) = recipe::secondary(target, &rays, |ray| Some(closest(ray)?.hit));
    rays.extend(diffuse);
    rays.extend(shadow);
    let enough = rays.len().min(count);
    // A smaller count is spread over all kinds.
    let step = rays.len() / enough.max(1);
    let mut rays: Vec<Ray> = rays.into_iter().step_by(step.max(1)).take(enough).collect();
    rays.extend(recipe::random(target, count - enough));

    let expected: Vec<Option<PrimitiveHit>> = rays.par_iter().map(closest).collect();
    let step = (rays.len() / LOOPED).max(1);
    let looped = (0..rays.len()).into_par_iter().step_by(step).find_map_any(|index| {
        let found = over_all(primitives, &rays[index], method);
        (found != expected[index])
            .then(|| format!("{:?}: {found:?}, {:?}", rays[index], expected[index]))
    });
    if let Some(difference) = looped {
        bail!("{scene}: the simple tree and the loop differ: {difference}");
    }
    for &isa in sets {
        let tree = P::build(primitives, isa);
        let difference = rays.par_iter().zip(&expected).find_map_any(|(ray, expected)| {
            let found = (tree.closest(ray, method), tree.any(ray, method));
            (found != (*expected, expected.is_some())).then(|| {
                format!("{ray:?}: the tree returns {found:?}, the primitives {expected:?}")
            })
        });
        if let Some(difference) = difference {
            bail!("{scene}, {}: {difference}", isa.name());
        }
        let hits = expected.iter().flatten().count();
        say(format!(
            "{scene}, {}: {} rays, {hits} hits: closest and any are\n  bit-equal to the scalar tests",
            isa.name(),
            rays.len(),
        ))?;
    }
    Ok(())
}

/// Returns the hit of the smallest `t`, and among equals of the lowest id.
fn over_all<P: Primitive>(primitives: &[P], ray: &Ray, method: Method) -> Option<PrimitiveHit> {
    let mut best: Option<PrimitiveHit> = None;
    for (id, primitive) in primitives.iter().enumerate() {
        if let Some(hit) = primitive.exact(ray, method)
            && best.is_none_or(|best| hit.t < best.hit.t)
        {
            best = Some(PrimitiveHit { id: id as u32, hit });
        }
    }
    best
}

/// A binary tree: the node `i` has the children `2 i + 1` and `2 i + 2`, and the range of ids is
/// halved.
struct Plain {
    ids: Vec<u32>,
    boxes: Vec<Aabb>,
}

/// Ids in a leaf, at most.
const LEAF: usize = 4;

impl Plain {
    fn build<P: Primitive>(primitives: &[P]) -> Self {
        let bounds: Vec<Aabb> = primitives.iter().map(P::bounds).collect();
        let mut ids: Vec<u32> = (0..primitives.len() as u32).collect();
        let depth = primitives.len().div_ceil(LEAF).next_power_of_two().ilog2();
        let mut boxes = vec![Aabb::EMPTY; (2 << depth) - 1];
        halve(&mut ids, &bounds, &mut boxes, 0);
        Self { ids, boxes }
    }

    fn closest<P: Primitive>(
        &self,
        primitives: &[P],
        ray: &Ray,
        method: Method,
    ) -> Option<PrimitiveHit> {
        let mut best: Option<PrimitiveHit> = None;
        let mut waiting = vec![(0, 0..self.ids.len())];
        while let Some((node, range)) = waiting.pop() {
            let t_max = best.map_or(ray.t_max, |best| best.hit.t);
            if entry(&self.boxes[node], ray, t_max).is_none() {
                continue;
            }
            if range.len() > LEAF {
                let middle = range.start + range.len() / 2;
                let (low, high) = (2 * node + 1, 2 * node + 2);
                let [to_low, to_high] =
                    [low, high].map(|child| entry(&self.boxes[child], ray, t_max));
                let [low, high] = [(low, range.start..middle), (high, middle..range.end)];
                // Visit the nearer child first: a hit there prunes much of the other. None sorts
                // first, and a child that the ray misses is popped at once.
                waiting.extend(if to_low < to_high { [high, low] } else { [low, high] });
                continue;
            }
            for &id in &self.ids[range] {
                if let Some(hit) = primitives[id as usize].exact(ray, method)
                    && best.is_none_or(|best| (hit.t, id) < (best.hit.t, best.id))
                {
                    best = Some(PrimitiveHit { id, hit });
                }
            }
        }
        best
    }
}

/// Orders the ids below a node, and computes the boxes of all its descendants.
fn halve(ids: &mut [u32], bounds: &[Aabb], boxes: &mut [Aabb], node: usize) {
    let whole = ids.iter().fold(Aabb::EMPTY, |sum, &id| {
        let bounds = bounds[id as usize];
        // A box with a NaN or without volume cannot be hit.
        if bounds.is_empty() { sum } else { sum.union(bounds) }
    });
    boxes[node] = whole;
    if ids.len() <= LEAF {
        return;
    }
    let axis = (whole.max - whole.min).max_position();
    let middle = ids.len() / 2;
    let key = |&id: &u32| bounds[id as usize].center()[axis];
    ids.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
    let (low, high) = ids.split_at_mut(middle);
    halve(low, bounds, boxes, 2 * node + 1);
    halve(high, bounds, boxes, 2 * node + 2);
}

/// Returns where the ray enters the box within its interval up to `t_max`. The box is widened by a
/// rounding of `f32`.
fn entry(bounds: &Aabb, ray: &Ray, t_max: f32) -> Option<f64> {
    let slack = 1e-6;
    let mut near = f64::from(ray.t_min);
    let mut far = f64::from(t_max);
    near -= slack * near.abs();
    far += slack * far.abs();
    for axis in 0..3 {
        let (o, d) = (f64::from(ray.origin[axis]), f64::from(ray.direction[axis]));
        let (low, high) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
        if d == 0.0 {
            if !(low <= o && o <= high) {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - o) / d, (high - o) / d);
        let (a, b) = (a.min(b), a.max(b));
        near = near.max(a - slack * a.abs());
        far = far.min(b + slack * b.abs());
    }
    (near <= far).then_some(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plain_tree_answers_as_the_loop() {
        let (cones, _) = recipe::cones(50);
        let plain = Plain::build(&cones);
        let mut hits = 0;
        for ray in recipe::random(&Target::UNIT, 5000) {
            for method in [Method::Enhanced, Method::Vanilla] {
                let expected = over_all(&cones, &ray, method);
                assert_eq!(plain.closest(&cones, &ray, method), expected, "{ray:?}");
                hits += usize::from(expected.is_some());
            }
        }
        assert!(hits > 100, "{hits} hits");
    }
}
