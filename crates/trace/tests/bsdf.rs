//! Every lobe: the samples have the stated density, the weight is value over density, and
//! reciprocal lobes are reciprocal.

mod support;

use glam::Vec3;
use rotund_scene::MaterialKind::{self, Glossy, Matte, Reflective, Refractive, Transparent};
use rotund_trace::{Bsdf, Sequence};
use std::f64::consts::{PI, TAU};
use support::{chi_squared_limit, direction, numbers, white};

const ROUGH: [(MaterialKind, f32); 13] = [
    (Matte, 0.0),
    (Glossy, 0.01),
    (Glossy, 0.09),
    (Glossy, 0.5),
    (Glossy, 1.0),
    (Reflective, 0.09),
    (Reflective, 0.5),
    (Reflective, 1.0),
    (Refractive, 0.09),
    (Refractive, 0.5),
    (Refractive, 1.0),
    (Transparent, 0.09),
    (Transparent, 0.5),
];
/// Cosines of outgoing directions; only glass is visible from below.
const COSINES: [f32; 9] = [1.0, 0.9, 0.5, 0.1, 0.01, -0.01, -0.1, -0.5, -1.0];

/// Combinations of material, alpha and cosine that occur.
fn cases() -> impl Iterator<Item = (MaterialKind, f32, f32)> {
    ROUGH.into_iter().flat_map(|(kind, alpha)| {
        COSINES
            .into_iter()
            .filter(move |&cosine| cosine > 0.0 || kind == Refractive)
            .map(move |cosine| (kind, alpha, cosine))
    })
}

#[test]
fn samples_have_their_density() {
    const ROWS: usize = 24;
    const COLUMNS: usize = 24;
    const SAMPLES: u32 = 100_000;
    for (kind, alpha, cosine) in cases().filter(|&(_, alpha, _)| alpha != 0.01) {
        let outgoing = direction(cosine, 0.4);
        let bsdf = Bsdf::new(&white(kind, alpha), Vec3::Z, outgoing);
        // Rows are uniform in the angle to the normal, so that those near grazing are not too wide.
        // At the critical angle the density of refraction rises like a square root. Near grazing a
        // narrow lobe is narrower still.
        let steps = if kind == Refractive || alpha < 0.1 && cosine < 0.1 { 64 } else { 24 };
        let mut observed = [[0_u32; COLUMNS]; ROWS];
        let mut absorbed = 0;
        for index in 0..SAMPLES {
            let (choice, u) = numbers(Sequence::Independent, 3, index);
            let Some(sample) = bsdf.sample(choice, u) else {
                absorbed += 1;
                continue;
            };
            let at = sample.incoming;
            let row = f64::from(at.z).clamp(-1.0, 1.0).acos() / PI * ROWS as f64;
            let azimuth = f64::from(at.y).atan2(f64::from(at.x)).rem_euclid(TAU);
            let column = azimuth / TAU * COLUMNS as f64;
            observed[(row as usize).min(ROWS - 1)][(column as usize).min(COLUMNS - 1)] += 1;
        }
        let mut statistic = 0.0;
        let mut cells = 0;
        let (mut rest_expected, mut rest_observed) = (f64::from(SAMPLES), f64::from(absorbed));
        for (row, counts) in observed.iter().enumerate() {
            for (column, &count) in counts.iter().enumerate() {
                let share = quadrature(steps, [row, ROWS], [column, COLUMNS], |incoming| {
                    f64::from(bsdf.eval(incoming).pdf)
                });
                let expected = share * f64::from(SAMPLES);
                if expected > 20.0 {
                    statistic += (f64::from(count) - expected).powi(2) / expected;
                    cells += 1;
                    rest_expected -= expected;
                } else {
                    rest_observed += f64::from(count);
                }
            }
        }
        // Absorbed samples and cells of low expectation form one cell. Its expectation is a small
        // difference of large numbers, so it has the error of the quadrature.
        let slack = 4.0 * rest_expected.abs().sqrt() + 0.002 * f64::from(SAMPLES);
        assert!(
            (rest_observed - rest_expected).abs() < slack,
            "{kind:?} alpha {alpha} cosine {cosine}: {rest_observed} elsewhere, not {rest_expected}"
        );
        let limit = chi_squared_limit(cells);
        assert!(
            statistic < limit,
            "{kind:?} alpha {alpha} cosine {cosine}: chi-squared {statistic} exceeds {limit}"
        );
    }
}

#[test]
fn the_weight_of_a_sample_is_value_over_density() {
    for (kind, alpha, cosine) in cases() {
        let bsdf = Bsdf::new(&white(kind, alpha), Vec3::Z, direction(cosine, -1.0));
        for index in 0..2000 {
            let (choice, u) = numbers(Sequence::Sobol, 1, index);
            let Some(sample) = bsdf.sample(choice, u) else { continue };
            let again = bsdf.eval(sample.incoming);
            let pdf = sample.pdf.expect("no lobe here is discrete");
            // Directions are rounded by the conversion to world space, which changes the narrowest
            // lobe most.
            let tolerance = (1e-5 / alpha.max(0.01).powi(2)).max(1e-4);
            assert!(
                (again.pdf - pdf).abs() <= tolerance * pdf
                    && (again.value - sample.weight * pdf).abs().max_element() <= tolerance * pdf,
                "{kind:?} alpha {alpha} cosine {cosine} sample {index}: {sample:?} but {again:?}"
            );
            assert!(sample.weight.max_element() <= 1.0 + 1e-4 || kind == Glossy, "{sample:?}");
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    for (kind, alpha) in ROUGH {
        // The base of a glossy surface has the Fresnel term of one side only, so it is not
        // reciprocal.
        if kind == Glossy {
            continue;
        }
        for (a, b) in [(0.9, 0.3), (0.5, 0.1), (1.0, 0.7), (0.3, 0.01), (0.02, 0.05)] {
            let (a, b) = (direction(a, 0.0), direction(b, 2.0));
            let value = |outgoing: Vec3, incoming: Vec3| {
                let bsdf = Bsdf::new(&white(kind, alpha), Vec3::Z, outgoing);
                bsdf.eval(incoming).value.x / incoming.z
            };
            let (there, back) = (value(a, b), value(b, a));
            assert!((there - back).abs() <= 1e-4 * there, "{kind:?} {alpha}: {there} {back}");
        }
    }
}

#[test]
fn what_passes_a_sheet_is_reciprocal() {
    for alpha in [0.09, 0.5, 1.0] {
        for (a, b) in [(0.9, -0.8), (0.3, -0.9), (0.05, -0.02)] {
            let (a, b) = (direction(a, 0.0), direction(b, 3.0));
            let value = |outgoing: Vec3, incoming: Vec3| {
                let bsdf = Bsdf::new(&white(Transparent, alpha), Vec3::Z, outgoing);
                bsdf.eval(incoming).value.x / incoming.z.abs()
            };
            let (there, back) = (value(a, b), value(b, a));
            assert!((there - back).abs() <= 1e-4 * there, "{alpha}: {there} {back}");
        }
    }
}

#[test]
fn refraction_is_reciprocal_up_to_the_squared_index() {
    for alpha in [0.09, 0.5, 1.0] {
        for (a, b) in [(0.9, -0.8), (0.6, -0.9), (1.0, -0.7)] {
            let (a, b) = (direction(a, 0.0), direction(b, 3.0));
            let value = |outgoing: Vec3, incoming: Vec3| {
                let bsdf = Bsdf::new(&white(Refractive, alpha), Vec3::Z, outgoing);
                bsdf.eval(incoming).value.x / incoming.z.abs()
            };
            // Light that leaves towards a is spread over a solid angle larger by 1.5².
            let (out, inwards) = (value(a, b), value(b, a) * 1.5 * 1.5);
            assert!((out - inwards).abs() <= 1e-4 * out, "{alpha}: {out} {inwards}");
        }
    }
}

#[test]
fn smooth_lobes_reflect_and_refract_where_snell_says() {
    let outgoing = direction(0.8, 0.0);
    let glass = Bsdf::new(&white(Refractive, 0.0), Vec3::Z, outgoing);
    let mirror = Bsdf::new(&white(Reflective, 0.0), Vec3::Z, outgoing);
    // By Snell's law a sine of 0.6 becomes 0.4 inside of an index of 1.5.
    let refracted = Vec3::new(-0.4, 0.0, -(1.0_f32 - 0.16).sqrt());
    let reflected = Vec3::new(-0.6, 0.0, 0.8);
    let table = [
        ("low choices reflect", glass, 0.0, reflected),
        ("high choices refract", glass, 0.99, refracted),
        ("a mirror always reflects", mirror, 0.99, reflected),
    ];
    for (why, bsdf, choice, expected) in table {
        assert!(bsdf.is_delta(), "{why}");
        let sample = bsdf.sample(choice, [0.3, 0.7].into()).expect(why);
        assert!(sample.incoming.abs_diff_eq(expected, 1e-6), "{why}: {sample:?}");
        assert_eq!(sample.pdf, None, "{why}");
        assert_eq!(bsdf.eval(sample.incoming).pdf, 0.0, "{why}");
    }
    let inside = Bsdf::new(&white(Refractive, 0.0), Vec3::Z, direction(-0.5, 0.0));
    let total = inside.sample(0.999, [0.5; 2].into()).expect("total reflection").incoming;
    assert!(total.abs_diff_eq(direction(-0.5, std::f32::consts::PI), 1e-6), "{total}");
}

#[test]
fn hard_directions_give_numbers() {
    for (kind, alpha) in [(Matte, 0.0), (Glossy, 9e-4), (Reflective, 0.0), (Refractive, 1.0)] {
        for ior in [1.0, 1.0001, 1.5, 1e6, 0.2] {
            for z in [0.0, -0.0, 1e-30, 1e-6, 1.0] {
                let material = rotund_scene::MaterialPoint { ior, ..white(kind, alpha) };
                let bsdf = Bsdf::new(&material, Vec3::Z, direction(z, 0.0));
                for index in 0..64 {
                    let (choice, u) = numbers(Sequence::Sobol, 2, index);
                    let Some(sample) = bsdf.sample(choice, u) else { continue };
                    let again = bsdf.eval(sample.incoming);
                    let finite = again.value.is_finite() && again.pdf.is_finite();
                    assert!(
                        finite && sample.weight.is_finite() && sample.incoming.is_normalized(),
                        "{kind:?} alpha {alpha} ior {ior} z {z}: {sample:?}"
                    );
                }
            }
        }
    }
}

/// Integrates `f` over one cell of directions by the midpoint rule.
fn quadrature(
    steps: usize,
    [row, rows]: [usize; 2],
    [column, columns]: [usize; 2],
    f: impl Fn(Vec3) -> f64,
) -> f64 {
    let mut sum = 0.0;
    for i in 0..steps {
        let theta = (row as f64 + (i as f64 + 0.5) / steps as f64) / rows as f64 * PI;
        for j in 0..steps {
            let azimuth = (column as f64 + (j as f64 + 0.5) / steps as f64) / columns as f64 * TAU;
            let incoming = Vec3::new(
                (theta.sin() * azimuth.cos()) as f32,
                (theta.sin() * azimuth.sin()) as f32,
                theta.cos() as f32,
            );
            sum += f(incoming) * theta.sin();
        }
    }
    sum * PI * TAU / (rows * columns * steps * steps) as f64
}
