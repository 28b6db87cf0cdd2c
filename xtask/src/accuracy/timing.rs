//! Nanoseconds of one test: a call that is not inlined and returns t, position and normal.
//!
//! The methods take turns, round by round, so that whatever slows the machine down slows all of them;
//! the median over the rounds is reported, and how far the middle half of them spreads. The loop
//! around the call is part of the time and reported by itself as the method that does nothing.

use std::{hint::black_box, time::Instant};

use rotund_geometry::{Hit, Ray};
use serde::Serialize;

use super::{
    families::rows,
    methods::{Measured, Method, Rebuilt},
    random::Random,
    truth::Truth,
};

/// Pairs of a shape and a ray; they stay in the first cache.
const PAIRS: usize = 1024;

/// Rounds of all methods, each over all pairs a few times.
const ROUNDS: usize = 41;
const SWEEPS: usize = 12;

/// A median over the rounds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Nanoseconds {
    pub(crate) median: f64,
    /// From the first to the third quartile.
    pub(crate) spread: f64,
}

/// What a test of one method costs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Timing {
    pub(crate) shape: &'static str,
    pub(crate) method: &'static str,
    /// Half of the rays hit, in random order.
    pub(crate) mixed: Nanoseconds,
    pub(crate) hits: Nanoseconds,
    pub(crate) misses: Nanoseconds,
    /// Parameters, and position and normal rebuilt from them, of a hit that is there already.
    pub(crate) rebuild: Option<Nanoseconds>,
}

/// The name of the loop that calls nothing.
pub(crate) const LOOP: &str = "the loop alone";

type Pairs<S> = Vec<(S, Ray)>;

/// Times all methods of a shape; single-threaded.
pub(crate) fn time<S: Measured>(methods: &[&Method<S>], seed: u64) -> Vec<Timing> {
    let nothing = Method {
        name: LOOP,
        own: false,
        approximate: true,
        closest: |_, _| None,
        any: None,
        rebuild: None,
    };
    let methods: Vec<&Method<S>> = methods.iter().copied().chain([&nothing]).collect();
    let (hits, misses) = (pairs::<S>(seed, PAIRS, true), pairs::<S>(seed, PAIRS, false));
    let mixed = shuffled(&hits[..PAIRS / 2], &misses[..PAIRS / 2], seed);
    let sets = [&mixed, &hits, &misses];

    let mut samples = vec![[const { Vec::new() }; 3]; methods.len()];
    let mut rebuilds = vec![Vec::new(); methods.len()];
    for round in 0..=ROUNDS {
        for (i, method) in methods.iter().enumerate() {
            for (set, samples) in sets.iter().zip(&mut samples[i]) {
                let ns = sweep(method.closest, set);
                // The first round warms caches, branch predictors and the clock of the processor.
                if round > 0 {
                    samples.push(ns);
                }
            }
            if let Some(rebuild) = method.rebuild
                && round > 0
            {
                rebuilds[i].push(sweep_rebuild(method.closest, rebuild, &hits));
            }
        }
    }
    let timing =
        |(method, ([mixed, hits, misses], rebuild)): (&&Method<S>, ([Vec<f64>; 3], _))| Timing {
            shape: S::NAME,
            method: method.name,
            mixed: summary(mixed),
            hits: summary(hits),
            misses: summary(misses),
            rebuild: method.rebuild.map(|_| summary(rebuild)),
        };
    methods.iter().zip(samples.into_iter().zip(rebuilds)).map(timing).collect()
}

/// Rays of the timed family that truly hit, or truly miss.
fn pairs<S: Measured>(seed: u64, count: usize, hitting: bool) -> Pairs<S> {
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

fn shuffled<S: Measured>(a: &[(S, Ray)], b: &[(S, Ray)], seed: u64) -> Pairs<S> {
    let mut all = [a, b].concat();
    let mut random = Random::of(seed, "shuffle", 0);
    for i in (1..all.len()).rev() {
        all.swap(i, random.index(i + 1));
    }
    all
}

/// Nanoseconds a call.
fn sweep<S: Measured>(closest: fn(&S, &Ray) -> Option<Hit>, pairs: &Pairs<S>) -> f64 {
    let closest = black_box(closest);
    let start = Instant::now();
    for _ in 0..SWEEPS {
        for (shape, ray) in pairs {
            black_box(closest(shape, ray));
        }
    }
    start.elapsed().as_secs_f64() * 1e9 / (SWEEPS * pairs.len()) as f64
}

/// Nanoseconds a hit.
fn sweep_rebuild<S: Measured>(
    closest: fn(&S, &Ray) -> Option<Hit>,
    rebuild: fn(&S, &Hit) -> Rebuilt,
    pairs: &Pairs<S>,
) -> f64 {
    let hits: Vec<(S, Hit)> =
        pairs.iter().filter_map(|(shape, ray)| Some((*shape, closest(shape, ray)?))).collect();
    let rebuild = black_box(rebuild);
    let start = Instant::now();
    for _ in 0..SWEEPS {
        for (shape, hit) in &hits {
            black_box(rebuild(shape, hit));
        }
    }
    start.elapsed().as_secs_f64() * 1e9 / (SWEEPS * hits.len().max(1)) as f64
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
        // The own method agrees with the truth, so the clock times answers and not failures.
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
    fn a_median_is_not_moved_by_an_outlier() {
        let summary = summary(vec![1.0, 2.0, 3.0, 4.0, 1000.0]);
        assert_eq!((summary.median, summary.spread), (3.0, 2.0));
    }
}
