//! Surfaces in a white furnace: the fraction of uniform illumination that they reflect and
//! transmit.

mod support;

use glam::Vec3;
use rotund_scene::MaterialKind::{self, Glossy, Matte, Reflective, Refractive, Transparent};
use rotund_scene::MaterialPoint;
use rotund_trace::{Bsdf, Sequence};
use std::f64::consts::PI;
use support::{direction, numbers, white};

const KINDS: [MaterialKind; 5] = [Matte, Glossy, Reflective, Refractive, Transparent];
const ALPHAS: [f32; 7] = [0.0, 0.0009, 0.01, 0.09, 0.25, 0.5, 1.0];
const COSINES: [f32; 9] = [1.0, 0.9, 0.7, 0.5, 0.3, 0.1, 0.01, -0.3, -0.8];

/// Outgoing directions from which a material is visible, for each alpha.
fn cases() -> impl Iterator<Item = (MaterialKind, f32, f32)> {
    KINDS.into_iter().flat_map(|kind| {
        ALPHAS.into_iter().flat_map(move |alpha| {
            // The scene clamps the alpha of matte and glossy surfaces from below.
            let alpha = if matches!(kind, Matte | Glossy) { alpha.max(0.0009) } else { alpha };
            COSINES
                .into_iter()
                .filter(move |&cosine| cosine > 0.0 || kind == Refractive)
                .map(move |cosine| (kind, alpha, cosine))
        })
    })
}

/// Returns the mean weight of samples: the directional albedo.
fn albedo(kind: MaterialKind, alpha: f32, cosine: f32) -> f64 {
    albedo_of(&white(kind, alpha), cosine)
}

fn albedo_of(material: &MaterialPoint, cosine: f32) -> f64 {
    const SAMPLES: u32 = 1 << 15;
    let bsdf = Bsdf::new(material, Vec3::Z, direction(cosine, 0.3));
    let sum: f64 = (0..SAMPLES)
        .filter_map(|index| {
            let (choice, u) = numbers(Sequence::Sobol, 7, index);
            bsdf.sample(choice, u).map(|sample| f64::from(sample.weight.x))
        })
        .sum();
    sum / f64::from(SAMPLES)
}

#[test]
fn no_surface_gains_energy() {
    for (kind, alpha, cosine) in cases() {
        let albedo = albedo(kind, alpha, cosine);
        assert!(albedo <= 1.00002, "{kind:?} alpha {alpha} cosine {cosine}: {albedo}");
    }
}

/// The cases in which the coat and a white base weighted by the Fresnel term of the normal would
/// together gain most energy: up to 0.07 %.
#[test]
fn a_coat_over_a_white_base_gains_no_energy_at_its_worst() {
    for (ior, alpha) in
        [(1.05, 0.0574), (1.2, 0.0965), (1.33, 0.0965), (1.5, 0.0745), (1.8, 0.0443), (2.5, 0.0093)]
    {
        for cosine in [0.2, 0.3, 0.41, 0.5, 0.62, 0.68, 0.75, 0.85] {
            let material = MaterialPoint { ior, ..white(Glossy, alpha) };
            let albedo = albedo_of(&material, cosine);
            assert!(albedo <= 1.00002, "ior {ior} alpha {alpha} cosine {cosine}: {albedo}");
        }
    }
}

#[test]
fn smooth_surfaces_lose_no_energy() {
    for cosine in [1.0, 0.7, 0.3, 0.1] {
        assert!((albedo(Matte, 0.0, cosine) - 1.0).abs() < 1e-5);
        assert!((albedo(Transparent, 0.0, cosine) - 1.0).abs() < 1e-5);
        assert!((albedo(Refractive, 0.0, cosine) - 1.0).abs() < 1e-5);
        assert!((albedo(Refractive, 0.0, -cosine) - 1.0).abs() < 1e-5);
    }
    // Each channel of a conductor is clamped to 0.99.
    assert!((albedo(Reflective, 0.0, 1.0) - 0.99).abs() < 1e-5);
    for cosine in [0.7, 0.1, 0.01_f32] {
        let expected = model::fresnel(model::metal(), f64::from(cosine));
        assert!((albedo(Reflective, 0.0, cosine) - expected).abs() < 1e-5, "{cosine}");
    }
}

/// Compares the samples with a quadrature in `f64` of a second implementation of the documented
/// formulas: D, the separable G, and Fresnel's reflectances.
#[test]
fn rough_surfaces_return_what_a_quadrature_of_the_model_says() {
    for (kind, alpha, cosine) in cases() {
        if kind == Matte || alpha == 0.0 {
            continue;
        }
        let expected = model::albedo(kind, f64::from(alpha), f64::from(cosine));
        let albedo = albedo(kind, alpha, cosine);
        assert!(
            (albedo / expected - 1.0).abs() < 1e-3,
            "{kind:?} alpha {alpha} cosine {cosine}: {albedo}, not {expected}"
        );
    }
}

/// The documented model, integrated over facet normals.
mod model {
    use super::{Glossy, MaterialKind, PI, Reflective, Transparent};

    const IOR: f64 = 1.5;

    /// Returns the index of refraction that reflects 0.99 at normal incidence.
    pub(super) fn metal() -> f64 {
        (1.0 + 0.99_f64.sqrt()) / (1.0 - 0.99_f64.sqrt())
    }

    pub(super) fn fresnel(eta: f64, cosine: f64) -> f64 {
        let transmitted = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
        if transmitted <= 0.0 {
            return 1.0;
        }
        let transmitted = transmitted.sqrt();
        let s = (cosine - eta * transmitted) / (cosine + eta * transmitted);
        let p = (eta * cosine - transmitted) / (eta * cosine + transmitted);
        0.5 * (s * s + p * p)
    }

    fn visible(alpha: f64, cosine: f64) -> f64 {
        let tangent2 = 1.0 / (cosine * cosine) - 1.0;
        2.0 / (1.0 + (1.0 + alpha * alpha * tangent2).sqrt())
    }

    /// Returns `∫ D(h) G1(o) G1(i) F |o·h| / |o·n| dh` over the facets that reflect and those that
    /// refract, to which both Jacobians transform the integral over incoming directions.
    pub(super) fn albedo(kind: MaterialKind, alpha: f64, cosine: f64) -> f64 {
        const STEPS: usize = 800;
        const TURNS: usize = 200;
        let eta = if cosine > 0.0 { IOR } else { 1.0 / IOR };
        let metal = metal();
        let cosine = cosine.abs();
        let o = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
        let mut sum = 0.0;
        for i in 0..STEPS {
            // Facet normals by inverting the cumulative distribution of D cos. The integrand rises
            // like 1 / sqrt(1 - u); substituting a square removes the singularity.
            let rest = (i as f64 + 0.5) / STEPS as f64;
            let (u, weight) = (1.0 - rest * rest, 2.0 * rest);
            let z = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
            let side = (1.0 - z * z).sqrt();
            for j in 0..TURNS {
                let azimuth = (j as f64 + 0.5) / TURNS as f64 * PI;
                let h = [side * azimuth.cos(), side * azimuth.sin(), z];
                let oh = o[0] * h[0] + o[2] * h[2];
                if oh <= 0.0 {
                    continue;
                }
                let facets = weight * visible(alpha, cosine) * oh / (cosine * z);
                let reflected = 2.0 * oh * z - cosine;
                let f = fresnel(if kind == Reflective { metal } else { eta }, oh);
                if reflected > 0.0 {
                    // A white sheet transmits what it does not reflect.
                    let f = if kind == Transparent { 1.0 } else { f };
                    sum += facets * f * visible(alpha, reflected);
                }
                let beyond = 1.0 - (1.0 - oh * oh) / (eta * eta);
                if kind == MaterialKind::Refractive && beyond > 0.0 {
                    let refracted = (oh / eta - beyond.sqrt()) * z - cosine / eta;
                    if refracted < 0.0 {
                        sum += facets * (1.0 - f) * visible(alpha, refracted);
                    }
                }
            }
        }
        let base = if kind == Glossy { 0.999 * (1.0 - fresnel(IOR, cosine)) } else { 0.0 };
        sum / (STEPS * TURNS) as f64 + base
    }
}
