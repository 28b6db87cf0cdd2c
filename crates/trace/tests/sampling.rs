//! Facet normals and phase functions are sampled with their stated densities.

mod support;

use glam::{Vec2, Vec3};
use rotund_trace::bsdf::microfacet;
use rotund_trace::{Sequence, phase};
use std::f64::consts::TAU;
use support::{chi_squared_limit, direction, numbers};

const SAMPLES: u32 = 100_000;
const CELLS: usize = 24;
/// Steps of the quadrature along each side of a cell.
const STEPS: usize = 16;

/// Tests samples against a density over the unit square by chi-squared. `place` maps a sample to
/// the square; `density` is per area of the square.
fn assert_drawn(
    why: &str,
    sample: impl Fn(Vec2) -> Vec3,
    place: impl Fn(Vec3) -> [f64; 2],
    density: impl Fn(f64, f64) -> f64,
) {
    let mut observed = [[0_u32; CELLS]; CELLS];
    let cell = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
    for index in 0..SAMPLES {
        let (_, u) = numbers(Sequence::Independent, 11, index);
        let [x, y] = place(sample(u));
        observed[cell(x)][cell(y)] += 1;
    }
    let (mut statistic, mut cells, mut total) = (0.0, 0, 0.0);
    // Cells of low expectation are joined to one.
    let (mut thin_expected, mut thin_observed) = (0.0, 0.0);
    let side = 1.0 / (CELLS * STEPS) as f64;
    for (row, counts) in observed.iter().enumerate() {
        for (column, &count) in counts.iter().enumerate() {
            let at = |cell: usize, step: usize| ((cell * STEPS + step) as f64 + 0.5) * side;
            let sum: f64 = (0..STEPS * STEPS)
                .map(|k| density(at(row, k / STEPS), at(column, k % STEPS)))
                .sum();
            let share = sum * side * side;
            let expected = share * f64::from(SAMPLES);
            total += share;
            if expected > 20.0 {
                statistic += (f64::from(count) - expected).powi(2) / expected;
                cells += 1;
            } else {
                thin_expected += expected;
                thin_observed += f64::from(count);
            }
        }
    }
    assert!((total - 1.0).abs() < 1e-3, "{why}: the density integrates to {total}");
    assert!(
        (thin_observed - thin_expected).abs()
            < 4.0 * thin_expected.sqrt() + 1e-4 * f64::from(SAMPLES),
        "{why}: {thin_observed} in thin cells, not {thin_expected}"
    );
    let limit = chi_squared_limit(cells);
    assert!(statistic < limit, "{why}: chi-squared {statistic} exceeds {limit}");
}

/// Returns the azimuth of a direction about +z, in turns.
fn turns(direction: Vec3) -> f64 {
    (f64::from(direction.y).atan2(f64::from(direction.x)) / TAU).rem_euclid(1.0)
}

#[test]
fn facets_have_their_density_at_every_roughness_and_angle() {
    for alpha in [0.0009_f32, 0.01, 0.09, 0.3, 1.0] {
        for cosine in [1.0, 0.9, 0.5, 0.1, 0.01, 1e-3] {
            let outgoing = direction(cosine, 0.4);
            let alpha2 = f64::from(alpha) * f64::from(alpha);
            // Squared slopes t² are mapped to s = 1 / sqrt(1 + t² / α²), which is independent of α.
            // Most facets that are visible at grazing angles have a small s.
            let place = |half: Vec3| {
                let [x, y, z] = half.as_dvec3().to_array();
                let slope2 = (x * x + y * y) / (z * z);
                [1.0 / (1.0 + slope2 / alpha2).sqrt(), turns(half)]
            };
            let density = |s: f64, turn: f64| {
                let slope2 = alpha2 * (1.0 / (s * s) - 1.0);
                let z = 1.0 / (1.0 + slope2).sqrt();
                let side = slope2.sqrt() * z;
                let (y, x) = (TAU * turn).sin_cos();
                let half = Vec3::new((side * x) as f32, (side * y) as f32, z as f32);
                // Solid angle: dz = z³ / 2 d(slope²), d(slope²) = 2 α² / s³ ds.
                let measure = TAU * z.powi(3) * alpha2 / s.powi(3);
                f64::from(microfacet::pdf(alpha, outgoing, half)) * measure
            };
            let why = format!("alpha {alpha} cosine {cosine}");
            assert_drawn(&why, |u| microfacet::sample(alpha, outgoing, u), place, density);
        }
    }
}

#[test]
fn phase_functions_have_their_density_and_mean_cosine() {
    for g in [-0.95_f32, -0.3, -1e-4, 0.0, 1e-3, 0.2, 0.8, 0.99] {
        let outgoing = direction(0.3, 1.0);
        // The direction of propagation after scattering, relative to that before.
        let (x, y) = outgoing.any_orthonormal_pair();
        let local = |v: Vec3| Vec3::new(x.dot(v), y.dot(v), -outgoing.dot(v));
        // The cosine is mapped by its cumulative distribution, so that all cells have samples.
        let wide = f64::from(g);
        let rank = |cosine: f64| {
            if g == 0.0 {
                return 0.5 * (1.0 + cosine);
            }
            let root = (1.0 + wide * wide - 2.0 * wide * cosine).sqrt();
            ((1.0 - wide * wide) / (2.0 * wide) * (1.0 / root - 1.0 / (1.0 + wide))).clamp(0.0, 1.0)
        };
        let cosine_at = |rank: f64| {
            if g == 0.0 {
                return 2.0 * rank - 1.0;
            }
            let root = 1.0 / (2.0 * wide * rank / (1.0 - wide * wide) + 1.0 / (1.0 + wide));
            ((1.0 + wide * wide - root * root) / (2.0 * wide)).clamp(-1.0, 1.0)
        };
        let density = |r: f64, turn: f64| {
            let cosine = cosine_at(r);
            let step = 1e-4;
            let slope = (cosine_at(r + step) - cosine_at(r - step)) / (2.0 * step);
            let sine = (1.0 - cosine * cosine).sqrt();
            let (sin, cos) = (TAU * turn).sin_cos();
            let incoming =
                (sine * cos) as f32 * x + (sine * sin) as f32 * y - cosine as f32 * outgoing;
            f64::from(phase::henyey_greenstein(g, outgoing, incoming)) * slope * TAU
        };
        let sample = |u: Vec2| local(phase::sample(g, outgoing, u));
        let place = |v: Vec3| [rank(f64::from(v.z)), turns(v)];
        assert_drawn(&format!("g {g}"), sample, place, density);
        let cosines = (0..SAMPLES).map(|index| {
            let v = sample(numbers(Sequence::Sobol, 2, index).1);
            assert!(v.is_normalized(), "g {g}: {v}");
            f64::from(v.z)
        });
        let mean = cosines.sum::<f64>() / f64::from(SAMPLES);
        assert!((mean - wide).abs() < 1e-4, "the mean cosine is {mean}, not {g}");
    }
}

#[test]
fn scattering_is_reciprocal() {
    for g in [-0.9, 0.0, 0.5, 0.99] {
        for (a, b) in [(0.9, -0.8), (0.1, 0.2), (1.0, -1.0)] {
            let (a, b) = (direction(a, 0.3), direction(b, 2.0));
            let [there, back] = [(a, b), (b, a)].map(|(o, i)| phase::henyey_greenstein(g, o, i));
            assert_eq!(there, back, "g {g}");
        }
    }
}
