//! Self-intersection: does a ray that leaves a hit meet the same surface again because of rounding,
//! and how far along the normal must it start to avoid that?

use glam::{DVec3, Vec3};
use rotund_geometry::{Hit, Ray};
use serde::Serialize;

use super::{
    case::Case,
    methods::{Measured, Method},
    tally::Worst,
};
use crate::random::Random;
use crate::truth::{Crossing, Truth};
use crate::wide::{Wide, Wide3};

/// The offsets that are tried, in units of 2⁻²⁴ max(|o|, |p|): none, then powers of two.
const OFFSETS: [u32; 20] = {
    let mut offsets = [0; 20];
    let mut i = 1;
    while i < offsets.len() {
        offsets[i] = 1 << (i - 1);
        i += 1;
    }
    offsets
};

/// A hit of the same patch within this many sizes may be the surface that the ray leaves.
const NEAR: f64 = 1e-3;

/// Self-intersections of the rays that leave the hits of one row.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Leaving {
    /// How many hits sent out three rays each.
    pub(crate) hits: usize,
    /// Share of hits with a self-intersection of any of the three rays if they start at the hit.
    pub(crate) share_without_offset: f64,
    /// The smallest power of two, in units of 2⁻²⁴ max(|o|, |p|), that is a safe offset along the
    /// normal for 99 % of the hits.
    pub(crate) offset_p99: u32,
    /// The same for all hits.
    pub(crate) offset_max: u32,
    /// Rays that start at `leave_surface`, outwards and inwards, and meet the surface they leave.
    pub(crate) left_badly: usize,
    pub(crate) worst: Option<Worst>,
}

/// Collects the offsets of a row.
#[derive(Default)]
pub(crate) struct LeavingCollector {
    offsets: Vec<u32>,
    left_badly: usize,
    worst: Option<Worst>,
}

impl LeavingCollector {
    pub(crate) fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Shoots rays from a correct hit.
    pub(crate) fn add<S: Measured>(
        &mut self,
        method: &Method<S>,
        shape: &S,
        ray: &Ray,
        hit: &Hit,
        truth: &Truth,
        random: &mut Random,
    ) {
        // From far away all crossings round to one t, so the position identifies the crossing.
        let apart = |c: &Crossing| c.point.to_f64().distance(hit.position.as_dvec3());
        let nearest = truth.crossings.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let Some(crossing) = nearest else { return };
        // Outwards is away from a solid, or back towards the origin of the ray.
        let inwards = !S::CONVEX && crossing.normal.dot(ray.direction.as_dvec3()) > 0.0;
        let out = if inwards { -crossing.normal } else { crossing.normal };
        let directions = outward(out, random);
        let normal = if hit.normal.as_dvec3().dot(out) < 0.0 { -hit.normal } else { hit.normal };

        let unit = 2f64.powi(-24) * f64::from(ray.origin.length().max(hit.position.length()));
        let safe = |offset: u32| {
            let by = normal.as_dvec3() * (f64::from(offset) * unit);
            let origin = (hit.position.as_dvec3() + by).as_vec3();
            !directions.iter().any(|&d| meets_itself(method, shape, crossing, out, origin, d))
        };
        let offset = OFFSETS.into_iter().find(|&offset| safe(offset)).unwrap_or(u32::MAX);
        self.offsets.push(offset);
        if self.worst.as_ref().is_none_or(|w| w.value < f64::from(offset)) {
            let case = Case::of(shape, ray).to_string();
            self.worst = Some(Worst { what: "offset", value: offset.into(), case });
        }

        // Only a hit with an error bound defines where to start.
        if hit.error > 0.0 {
            for direction in directions.into_iter().chain([-directions[0], -directions[1]]) {
                let origin = hit.spawn(direction).origin;
                let outwards = direction.as_dvec3().dot(out) > 0.0;
                let side = if outwards { out } else { -out };
                let bad = if S::CONVEX && !outwards {
                    // A ray into a convex solid meets it once, at its exit.
                    let crossings = shape.crossings(origin.into(), direction.into());
                    crossings.first().is_some_and(|c| c.t > Wide::ZERO)
                } else {
                    meets_itself(method, shape, crossing, side, origin, direction)
                };
                self.left_badly += usize::from(bad);
                if bad {
                    let case = Case::of(shape, ray).to_string();
                    let value = f64::INFINITY;
                    self.worst = Some(Worst { what: "left badly", value, case });
                }
            }
        }
    }

    pub(crate) fn finish(mut self) -> Leaving {
        self.offsets.sort_unstable();
        let n = self.offsets.len();
        let at = |i: usize| self.offsets.get(i).copied().unwrap_or(0);
        let unsafe_at_hit = self.offsets.iter().filter(|&&offset| offset > 0).count();
        Leaving {
            hits: n,
            share_without_offset: unsafe_at_hit as f64 / n.max(1) as f64,
            offset_p99: at((0.99 * n.saturating_sub(1) as f64) as usize),
            offset_max: at(n.saturating_sub(1)),
            left_badly: self.left_badly,
            worst: self.worst,
        }
    }
}

/// Returns two directions on the side of `out` and one almost in the tangent plane.
fn outward(out: DVec3, random: &mut Random) -> [Vec3; 3] {
    let mut any = || {
        let d = random.direction();
        if d.dot(out) < 0.0 { -d } else { d }
    };
    let (first, second) = (any(), any());
    let tangent = random.perpendicular(out) + out * 1e-3;
    [first, second, tangent].map(|d| d.as_vec3())
}

/// Returns whether the ray from `origin`, which should be on the side of `out`, reports the surface
/// around `left` that it starts from.
fn meets_itself<S: Measured>(
    method: &Method<S>,
    shape: &S,
    left: &Crossing,
    out: DVec3,
    origin: Vec3,
    direction: Vec3,
) -> bool {
    let ray = Ray::new(origin, direction);
    let Some(again) = (method.closest)(shape, &ray) else { return false };
    if S::CONVEX {
        return true;
    }
    if f64::from(again.t) > NEAR * shape.size() {
        return false;
    }
    // A curved patch can be met again nearby, correctly. It is a self-intersection only if the
    // origin is still behind the surface, or if the truth has no such hit.
    let gap = left.point - Wide3::from(origin);
    let aside = (gap.to_f64() - out * gap.to_f64().dot(out)).length();
    let through = shape.crossings(origin.into(), out.into());
    let near =
        |c: &&Crossing| c.t.to_f64().abs() < NEAR * shape.size() + aside && same_sheet(left, c);
    let behind = through.iter().filter(near).any(|c| c.t > Wide::ZERO);
    let truth = Truth::of(shape, &ray);
    if truth.first().is_some_and(|c| !same_sheet(left, c)) {
        return false;
    }
    behind || truth.first().is_none_or(|c| c.t.to_f64() > 2.0 * NEAR * shape.size())
}

/// Returns whether two points lie on the same part of a patch. Where a patch intersects itself, as
/// a bow tie does, another part lies within rounding of the first, and a hit of it is correct.
fn same_sheet(a: &Crossing, b: &Crossing) -> bool {
    const APART: f64 = 0.1;
    match (a.uv, b.uv) {
        (Some(a), Some(b)) => a.distance(b) < APART,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use rotund_geometry::Sphere;

    use super::*;

    const SPHERE: Sphere = Sphere { center: Vec3::new(0.3, 0.2, 0.1), radius: 1.0 };

    fn leave(closest: fn(&Sphere, &Ray) -> Option<Hit>) -> Leaving {
        let method = Method::published("planted", closest);
        let mut random = Random::new(1);
        let mut collector = LeavingCollector::default();
        for _ in 0..500 {
            let target = SPHERE.center + random.ball().as_vec3() * 0.7;
            let direction = random.direction().as_vec3();
            let ray = Ray::new(target - direction * 4.0, direction);
            let truth = Truth::of(&SPHERE, &ray);
            let hit = closest(&SPHERE, &ray).expect("aimed at the inside");
            collector.add(&method, &SPHERE, &ray, &hit, &truth, &mut random);
        }
        collector.finish()
    }

    #[test]
    fn a_position_inside_the_sphere_needs_the_offset_it_was_moved_by() {
        let exact = leave(Sphere::closest);
        assert!(exact.share_without_offset > 0.2, "rounding puts some points inside");
        assert!(exact.offset_max <= 2, "{exact:?}");

        // 20 units of at most max(|o|, |p|), here about four.
        let sunk = leave(|s, ray| {
            let hit = s.closest(ray)?;
            Some(Hit {
                position: hit.position - hit.normal * (20.0 * 4.0 * f32::EPSILON / 2.0),
                ..hit
            })
        });
        assert_eq!(sunk.share_without_offset, 1.0);
        assert!((16..=64).contains(&sunk.offset_max), "{sunk:?}");
        assert!(sunk.left_badly > 0, "its bound was not true");
    }
}
