//! Nanoseconds of one test: a call that is not inlined and returns t, position and normal.
//!
//! The clock is the CPU time of the thread, so the time of other programs is not counted, but their
//! effect on the caches is. The methods take turns, round by round, so that a disturbance slows all
//! of them alike. Reported are the median over the rounds and the interquartile range. The loop
//! around the call is part of the time; it is also reported alone, as a method that does nothing.
//!
//! The branch predictor learns rays that are repeated. Most published figures are of that kind, and
//! so are `mixed`, `hits` and `misses`. `fresh` uses rays that occur once in a round, far more of
//! them than a predictor remembers, as in a renderer.

use std::hint::black_box;

use cpu_time::ThreadTime;
use rotund_geometry::{Hit, Ray};
use serde::Serialize;

use super::methods::{Measured, Method};
use crate::families::rows;
use crate::random::Random;
use crate::truth::Truth;

/// How many pairs of a shape and a ray are repeated.
const PAIRS: usize = 1024;

/// How many pairs are not repeated within a round.
const FRESH_PAIRS: usize = 16 * PAIRS;

/// Rounds of all methods; each has sweeps over the pairs that warm up, and sweeps that are timed.
const ROUNDS: usize = 21;
const LEARNING_SWEEPS: usize = 20;
const SWEEPS: usize = 40;

/// A median over the rounds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Nanoseconds {
    pub(crate) median: f64,
    /// The interquartile range.
    pub(crate) spread: f64,
}

/// The cost of one test by one method.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Timing {
    pub(crate) shape: &'static str,
    pub(crate) method: &'static str,
    /// Repeated rays of which half hit, in random order.
    pub(crate) mixed: Nanoseconds,
    /// The same mixture of rays that are not repeated.
    pub(crate) fresh: Nanoseconds,
    pub(crate) hits: Nanoseconds,
    pub(crate) misses: Nanoseconds,
    /// Time to compute the parameters of a given hit, and to rebuild position and normal from them.
    pub(crate) rebuild: Option<Nanoseconds>,
}

/// A spread above this share of the median indicates that other programs were running.
const STEADY: f64 = 0.15;

/// Returns whether the machine was too busy for the times to be compared.
pub(crate) fn unsteady(timings: &[Timing]) -> bool {
    let unsteady = |ns: &Nanoseconds| ns.spread > STEADY * ns.median;
    timings.iter().any(|timing| unsteady(&timing.mixed) || unsteady(&timing.fresh))
}

/// The name of the method that does nothing.
pub(crate) const LOOP: &str = "the loop alone";

/// Times all methods of a shape on one thread.
pub(crate) fn time<S: Measured>(methods: &[&Method<S>], seed: u64) -> Vec<Timing> {
    let nothing = Method::published(LOOP, |_, _| None);
    let methods: Vec<&Method<S>> = methods.iter().copied().chain([&nothing]).collect();
    let (hits, misses) =
        (pairs::<S>(seed, FRESH_PAIRS / 2, true), pairs::<S>(seed, FRESH_PAIRS / 2, false));
    let fresh = shuffled(&hits, &misses, seed);
    let mixed = shuffled(&hits[..PAIRS / 2], &misses[..PAIRS / 2], seed);
    let (hits, misses) = (&hits[..PAIRS], &misses[..PAIRS]);

    let mut samples = vec![Samples::default(); methods.len()];
    for _ in 0..ROUNDS {
        for (method, samples) in methods.iter().zip(&mut samples) {
            let test = |pairs: &[(S, Ray)], sweeps| {
                sweep(pairs, sweeps, |(shape, ray)| (method.closest)(shape, ray))
            };
            let learned = |pairs: &[(S, Ray)]| {
                test(pairs, LEARNING_SWEEPS);
                test(pairs, SWEEPS)
            };
            samples.fresh.push(test(&fresh, 1));
            samples.mixed.push(learned(&mixed));
            samples.hits.push(learned(hits));
            samples.misses.push(learned(misses));
            if let Some(rebuild) = method.rebuild {
                let found: Vec<(S, Hit)> = hits
                    .iter()
                    .filter_map(|(s, ray)| Some((*s, (method.closest)(s, ray)?)))
                    .collect();
                samples.rebuild.push(sweep(&found, SWEEPS, |(shape, hit)| rebuild(shape, hit)));
            }
        }
    }
    let timing = |(method, samples): (&&Method<S>, Samples)| Timing {
        shape: S::NAME,
        method: method.name,
        mixed: summary(samples.mixed),
        fresh: summary(samples.fresh),
        hits: summary(samples.hits),
        misses: summary(samples.misses),
        rebuild: method.rebuild.map(|_| summary(samples.rebuild)),
    };
    methods.iter().zip(samples).map(timing).collect()
}

/// Nanoseconds of each round.
#[derive(Clone, Default)]
struct Samples {
    mixed: Vec<f64>,
    fresh: Vec<f64>,
    hits: Vec<f64>,
    misses: Vec<f64>,
    rebuild: Vec<f64>,
}

/// Returns rays of the timed family that truly hit, or truly miss.
fn pairs<S: Measured>(seed: u64, count: usize, hitting: bool) -> Vec<(S, Ray)> {
    let (family, level) = S::TIMED;
    let row = rows::<S>()
        .find(|row| row.family.name == family && row.level == level)
        .expect("the timed family is in the table");
    (0u64..)
        .map(|i| row.generate(&mut Random::of(seed, "timing", i)))
        .filter(|(shape, ray)| Truth::of(shape, ray).hit.is_some() == hitting)
        .take(count)
        .collect()
}

fn shuffled<S: Measured>(a: &[(S, Ray)], b: &[(S, Ray)], seed: u64) -> Vec<(S, Ray)> {
    let mut all = [a, b].concat();
    let mut random = Random::of(seed, "shuffle", 0);
    for i in (1..all.len()).rev() {
        all.swap(i, random.index(i + 1));
    }
    all
}

/// Returns the nanoseconds of a call of `test`, which calls through a function pointer.
fn sweep<T, R>(inputs: &[T], sweeps: usize, test: impl Fn(&T) -> R) -> f64 {
    let start = ThreadTime::now();
    for _ in 0..sweeps {
        for input in inputs {
            black_box(test(black_box(input)));
        }
    }
    start.elapsed().as_secs_f64() * 1e9 / (sweeps * inputs.len()).max(1) as f64
}

fn summary(mut samples: Vec<f64>) -> Nanoseconds {
    samples.sort_by(f64::total_cmp);
    let n = samples.len();
    let at = |quarter: usize| samples.get(n * quarter / 4).copied().unwrap_or(0.0);
    Nanoseconds { median: at(2), spread: at(3) - at(1) }
}

#[cfg(test)]
mod tests {
    use rotund_geometry::{BilinearPatch, RoundedCone, Sphere};

    use super::*;

    fn half_of_the_timed_rays_hit<S: Measured>() {
        let hits = pairs::<S>(1, 64, true);
        let misses = pairs::<S>(1, 64, false);
        let mixed = shuffled(&hits, &misses, 1);
        let met = mixed.iter().filter(|(s, ray)| Truth::of(s, ray).hit.is_some()).count();
        assert_eq!((met, mixed.len()), (64, 128), "{}", S::NAME);
        // Our method agrees with the truth, so correct answers are timed and not failures.
        let own = S::METHODS[0].closest;
        assert!(hits.iter().all(|(s, ray)| own(s, ray).is_some()), "{}", S::NAME);
        assert!(misses.iter().all(|(s, ray)| own(s, ray).is_none()), "{}", S::NAME);
    }

    #[test]
    fn timed_rays_hit_and_miss_in_equal_number() {
        half_of_the_timed_rays_hit::<Sphere>();
        half_of_the_timed_rays_hit::<RoundedCone>();
        half_of_the_timed_rays_hit::<BilinearPatch>();
    }

    #[test]
    fn times_that_spread_are_unsteady() {
        let timing = |spread| Timing {
            shape: "sphere",
            method: "planted",
            mixed: Nanoseconds { median: 10.0, spread },
            fresh: Nanoseconds { median: 20.0, spread: 1.0 },
            hits: Nanoseconds::default(),
            misses: Nanoseconds::default(),
            rebuild: None,
        };
        assert!(!unsteady(&[timing(0.5), timing(1.0)]));
        assert!(unsteady(&[timing(0.5), timing(4.0)]));
    }

    #[test]
    fn a_median_is_not_moved_by_an_outlier() {
        let summary = summary(vec![1.0, 2.0, 3.0, 4.0, 1000.0]);
        assert_eq!((summary.median, summary.spread), (3.0, 2.0));
    }
}
