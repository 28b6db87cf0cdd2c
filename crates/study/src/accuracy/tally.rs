//! The results of one method on one row: counts, and percentiles of errors.

use glam::Vec3;
use rotund_geometry::{Hit, Ray};
use serde::Serialize;

use super::{
    case::Case,
    methods::{Measured, Method, Others},
};
use crate::truth::{Crossing, Truth, unit_of};

/// The unit roundoff of `f32`.
const UNIT: f64 = 1.0 / 16_777_216.0; // 2⁻²⁴

/// A wrong root lies nearer to another crossing, and more than this far from the expected one.
const WRONG_ROOT_UNITS: f64 = 8.0;

/// Percentiles of an error.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Spread {
    pub(crate) count: usize,
    pub(crate) p50: f64,
    pub(crate) p99: f64,
    pub(crate) max: f64,
}

impl Spread {
    pub(crate) fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let last = values.len().saturating_sub(1);
            values.get((share * last as f64).round() as usize).copied().unwrap_or(0.0)
        };
        Self { count: values.len(), p50: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}

/// An input with a large error, in the format of `--replay`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Worst {
    pub(crate) what: &'static str,
    pub(crate) value: f64,
    pub(crate) case: String,
}

/// The results of one method on one row.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Tally {
    pub(crate) true_hits: usize,
    pub(crate) true_misses: usize,
    pub(crate) false_misses: usize,
    pub(crate) false_hits: usize,
    pub(crate) wrong_roots: usize,
    /// Answers with a number that is not finite.
    pub(crate) invalid: usize,
    /// Hits farther from the surface than their error bound.
    pub(crate) bounds_broken: usize,
    /// Rays on which `any` or `closest_t` contradicts `closest`.
    pub(crate) queries_differ: usize,
    /// Error of `t` in units of 2⁻²⁴ t.
    pub(crate) t: Spread,
    /// Distance of the hit's position from the surface, in units of 2⁻²⁴ max(|p|, size).
    pub(crate) position: Spread,
    /// The same for o + t d in `f32`.
    pub(crate) on_ray: Spread,
    /// The same for the position rebuilt from the parameters.
    pub(crate) rebuilt: Spread,
    /// Distance of the rebuilt position from the true point, in the same units.
    pub(crate) round_trip: Spread,
    /// Error of the parameters of a patch, the larger of both, in units of 2⁻²⁴.
    pub(crate) uv: Spread,
    /// Error of the normal in degrees.
    pub(crate) normal: Spread,
    /// The same for the normal rebuilt from the parameters.
    pub(crate) rebuilt_normal: Spread,
    /// The worst case of each kind.
    pub(crate) worst: Vec<Worst>,
}

impl Tally {
    /// Returns the sum of false misses, false hits, wrong roots and answers that are not finite.
    pub(crate) fn false_results(&self) -> usize {
        self.false_misses + self.false_hits + self.wrong_roots + self.invalid
    }
}

/// Collects a tally.
#[derive(Default)]
pub(crate) struct Collector {
    tally: Tally,
    t: Vec<f64>,
    position: Vec<f64>,
    on_ray: Vec<f64>,
    rebuilt: Vec<f64>,
    round_trip: Vec<f64>,
    uv: Vec<f64>,
    normal: Vec<f64>,
    rebuilt_normal: Vec<f64>,
}

impl Collector {
    /// Compares the answer of `method` with the truth, and returns it if it is correct.
    pub(crate) fn add<S: Measured>(
        &mut self,
        method: &Method<S>,
        shape: &S,
        ray: &Ray,
        truth: &Truth,
    ) -> Option<Hit> {
        let found = (method.closest)(shape, ray);
        let case = || Case::of(shape, ray).to_string();
        if let Some(Others { any, closest_t }) = method.others
            && (any(shape, ray) != found.is_some() || closest_t(shape, ray) != found.map(|h| h.t))
        {
            self.tally.queries_differ += 1;
            self.worst("queries differ", 1.0, case);
        }
        if !truth.either {
            *(if truth.hit.is_some() {
                &mut self.tally.true_hits
            } else {
                &mut self.tally.true_misses
            }) += 1;
        }
        let Some(hit) = found else {
            if truth.hit.is_some() && !truth.either {
                self.tally.false_misses += 1;
                self.worst("false miss", 1.0, case);
            }
            return None;
        };
        if !(hit.t.is_finite() && hit.position.is_finite() && hit.normal.is_finite()) {
            self.tally.invalid += 1;
            self.worst("not a number", 1.0, case);
            return None;
        }
        let apart = |c: &Crossing| (f64::from(hit.t) - c.t.to_f64()).abs();
        let nearest = truth.crossings.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let expected = if truth.either { nearest } else { truth.first() };
        let Some(expected) = expected else {
            if !truth.either {
                self.tally.false_hits += 1;
                self.worst("false hit", 1.0, case);
            }
            return None;
        };
        let t_error = apart(expected) / unit_of(expected.t.to_f64());
        if t_error > WRONG_ROOT_UNITS && nearest.is_some_and(|c| apart(c) < apart(expected)) {
            self.tally.wrong_roots += 1;
            self.worst("wrong root", t_error, case);
            return None;
        }
        self.t.push(t_error);
        self.worst("t", t_error, case);
        self.measure(method, shape, ray, truth, expected, &hit);
        Some(hit)
    }

    fn measure<S: Measured>(
        &mut self,
        method: &Method<S>,
        shape: &S,
        ray: &Ray,
        truth: &Truth,
        expected: &Crossing,
        hit: &Hit,
    ) {
        let case = || Case::of(shape, ray).to_string();
        let point = expected.point.to_f64();
        let unit = UNIT * point.length().max(shape.size());
        let least = |error: &dyn Fn(&Crossing) -> f64| {
            same_place(truth, expected).map(error).fold(f64::INFINITY, f64::min)
        };
        let off = |p: Vec3| least(&|c| shape.distance(p.into(), c));

        let distance = off(hit.position);
        if hit.error > 0.0 && distance > f64::from(hit.error) {
            self.tally.bounds_broken += 1;
            self.worst("bound broken", distance / f64::from(hit.error), case);
        }
        self.position.push(distance / unit);
        self.worst("position", distance / unit, case);
        self.on_ray.push(off(ray.at(hit.t)) / unit);

        let normal = least(&|c| normal_error(hit.normal, c));
        self.normal.push(normal);
        self.worst("normal", normal, case);

        if let Some(uv) = expected.uv {
            self.uv.push((hit.parameters.as_dvec2() - uv).abs().max_element() / UNIT);
        }
        if let Some(rebuild) = method.rebuild {
            let rebuilt = rebuild(shape, hit);
            let distance = off(rebuilt.position) / unit;
            self.rebuilt.push(distance);
            self.worst("rebuilt", distance, case);
            self.round_trip.push((rebuilt.position.as_dvec3() - point).length() / unit);
            self.rebuilt_normal.push(least(&|c| normal_error(rebuilt.normal, c)));
        }
    }

    /// Keeps the case if its error is the largest of its kind so far.
    fn worst(&mut self, what: &'static str, value: f64, case: impl Fn() -> String) {
        // A NaN is the largest error.
        let value = if value.is_nan() { f64::INFINITY } else { value };
        match self.tally.worst.iter_mut().find(|worst| worst.what == what) {
            Some(worst) if worst.value >= value => {}
            Some(worst) => *worst = Worst { what, value, case: case() },
            None => self.tally.worst.push(Worst { what, value, case: case() }),
        }
    }

    pub(crate) fn finish(self) -> Tally {
        Tally {
            t: Spread::of(self.t),
            position: Spread::of(self.position),
            on_ray: Spread::of(self.on_ray),
            rebuilt: Spread::of(self.rebuilt),
            round_trip: Spread::of(self.round_trip),
            uv: Spread::of(self.uv),
            normal: Spread::of(self.normal),
            rebuilt_normal: Spread::of(self.rebuilt_normal),
            ..self.tally
        }
    }
}

/// Returns the angle in degrees that subtends the chord from `found` to the true normal, so that a
/// length other than one counts as an error too.
fn normal_error(found: Vec3, crossing: &Crossing) -> f64 {
    let chord = found.as_dvec3().distance(crossing.normal);
    (2.0 * (0.5 * chord).min(1.0).asin()).to_degrees()
}

/// Returns the crossings at the place of the expected one: where a surface intersects itself, each
/// of them is correct.
fn same_place<'a>(truth: &'a Truth, expected: &'a Crossing) -> impl Iterator<Item = &'a Crossing> {
    let t = expected.t.to_f64();
    truth.crossings.iter().filter(move |c| (c.t.to_f64() - t).abs() <= 1e-12 * t.abs())
}

#[cfg(test)]
mod tests {
    use rotund_geometry::Sphere;

    use super::*;

    const SPHERE: Sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };

    fn judge(closest: fn(&Sphere, &Ray) -> Option<Hit>, rays: &[Ray]) -> Tally {
        let method = Method::published("planted", closest);
        let mut collector = Collector::default();
        for ray in rays {
            collector.add(&method, &SPHERE, ray, &Truth::of(&SPHERE, ray));
        }
        collector.finish()
    }

    fn rays() -> Vec<Ray> {
        let x = |y| Ray::new(Vec3::new(-3.0, y, 0.0), Vec3::X);
        vec![x(0.0), x(0.5), x(-0.25), x(1.5), x(-2.0)]
    }

    #[test]
    fn a_planted_fault_is_counted_as_what_it_is() {
        let right = judge(Sphere::closest, &rays());
        assert_eq!((right.true_hits, right.true_misses, right.false_results()), (3, 2, 0));
        assert!(right.t.max <= 1.0 && right.position.max <= 1.5, "{right:?}");

        let blind = judge(|_, _| None, &rays());
        assert_eq!((blind.false_misses, blind.false_results()), (3, 3));

        let blinded =
            |_: &Sphere, ray: &Ray| SPHERE.closest(&Ray::new(Vec3::X * -3.0, ray.direction));
        let credulous = judge(blinded, &rays());
        assert_eq!((credulous.false_hits, credulous.false_misses), (2, 0));

        let far = |s: &Sphere, ray: &Ray| {
            let near = s.closest(ray)?;
            s.closest(&Ray { t_min: near.t + 0.1, ..*ray })
        };
        assert_eq!(judge(far, &rays()).wrong_roots, 3);

        let nan = |s: &Sphere, ray: &Ray| Some(Hit { t: f32::NAN, ..s.closest(ray)? });
        assert_eq!(judge(nan, &rays()).invalid, 3);
    }

    #[test]
    fn a_planted_error_has_the_size_it_was_planted_with() {
        let moved = |s: &Sphere, ray: &Ray| {
            let hit = s.closest(ray)?;
            let position = hit.position + hit.normal * 1e-3;
            let t = hit.t * (1.0 + 1e-5);
            let normal = (hit.normal + hit.normal.any_orthonormal_vector() * 1e-2).normalize();
            Some(Hit { t, position, normal, ..hit })
        };
        let tally = judge(moved, &rays());
        let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < 0.02;
        assert!(near(tally.t.p50, 1e-5 / UNIT), "{:?}", tally.t);
        assert!(near(tally.position.max, 1e-3 / UNIT), "{:?}", tally.position);
        assert!(near(tally.normal.p99, 1e-2f64.to_degrees()), "{:?}", tally.normal);
        assert_eq!(tally.bounds_broken, 3, "the bound of the hit was true of its own position");
    }

    #[test]
    fn queries_that_disagree_are_counted() {
        let others = Others { any: |_, _| true, closest_t: Sphere::closest_t };
        let method =
            Method { others: Some(others), ..Method::published("planted", Sphere::closest) };
        let mut collector = Collector::default();
        for ray in &rays() {
            collector.add(&method, &SPHERE, ray, &Truth::of(&SPHERE, ray));
        }
        assert_eq!(collector.finish().queries_differ, 2, "the rays that miss");
    }

    #[test]
    fn the_worst_case_is_kept_and_can_be_replayed() {
        let tally = judge(|_, _| None, &rays()[1..]);
        let worst = tally.worst.iter().find(|w| w.what == "false miss").expect("a false miss");
        let (sphere, ray) = worst.case.parse::<Case>().expect("a case").as_shape().expect("sphere");
        assert_eq!((sphere, ray), (SPHERE, rays()[1]));
    }

    #[test]
    fn percentiles_of_known_values() {
        let spread = Spread::of((0..=100).rev().map(f64::from).collect());
        assert_eq!((spread.p50, spread.p99, spread.max, spread.count), (50.0, 99.0, 100.0, 101));
        assert_eq!(Spread::of(vec![]).max, 0.0);
    }
}
