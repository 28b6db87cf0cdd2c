//! One number per question about two pictures of the same size.

use crate::color::{luminance, srgb_from_linear};
use crate::picture::Picture;
use anyhow::{Result, bail};
use glam::Vec3;
use serde::Serialize;

/// A pixel counts as changed if a channel moves by more than this in sRGB: two steps of an 8-bit
/// image. One step could be a rounding.
const CHANGED_SRGB: f32 = 2.0 / 255.0;

/// Keeps the relative error of black pixels finite: about the square of a dark grey, 0.1.
const REL_MSE_FLOOR: f32 = 0.01;

/// The share of pixels that [`Metrics::rel_mse_trimmed`] leaves out.
const TRIMMED_SHARE: f64 = 0.001;

/// Differences between a picture `a` and the picture `b` it is held against, in linear RGB.
///
/// Means run over all pixels and channels in which both pictures are finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Mean relative luminance (BT.709) of `a`.
    pub mean_luminance_a: f64,
    /// Mean relative luminance of `b`.
    pub mean_luminance_b: f64,
    /// `mean_luminance_a / mean_luminance_b`; 1 if both are zero.
    pub luminance_ratio: f64,
    /// Mean of `|a - b|`.
    pub mean_abs: f64,
    /// Square root of the mean of `(a - b)²`.
    pub rmse: f64,
    /// Mean of `(a - b)² / (b² + 0.01)`.
    pub rel_mse: f64,
    /// The same without the worst 0.1 % of the pixels: what remains without fireflies.
    pub rel_mse_trimmed: f64,
    /// Mean of [`flip`](mod@super::flip), `0.0..=1.0`.
    pub flip_mean: f64,
    /// Share of the pixels of which a channel differs by more than two steps of 8-bit sRGB.
    pub changed_fraction: f64,
    /// Pixels left out because one of the pictures is NaN or infinite there.
    pub invalid_pixels: usize,
}

/// Compares `a` with `b`, whose mean FLIP error is `flip_mean`.
///
/// # Errors
///
/// There must be at least one pixel that is finite in both.
///
/// # Panics
///
/// If the pictures differ in size.
pub fn metrics(a: &Picture, b: &Picture, flip_mean: f64) -> Result<Metrics> {
    assert_eq!((a.width, a.height), (b.width, b.height), "pictures of the same size");
    let (mut sum_a, mut sum_b, mut abs, mut squares) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let mut changed = 0usize;
    let mut relative: Vec<f32> = Vec::with_capacity(a.pixels.len());
    for (&a, &b) in a.pixels.iter().zip(&b.pixels) {
        if !(a.is_finite() && b.is_finite()) {
            continue;
        }
        let d = a - b;
        sum_a += f64::from(luminance(a));
        sum_b += f64::from(luminance(b));
        abs += f64::from(d.abs().element_sum());
        squares += f64::from(d.length_squared());
        relative.push(relative_square(a, b));
        let shown = (srgb_from_linear(a) - srgb_from_linear(b)).abs();
        changed += usize::from(shown.max_element() > CHANGED_SRGB);
    }
    let valid = relative.len();
    if valid == 0 {
        bail!("the images have no pixel that is finite in both");
    }
    let rel_mse_trimmed = trimmed_mean(&mut relative);
    // Sorted by now, so the sum of the small ones is also the accurate one.
    let sum = relative.iter().map(|&value| f64::from(value)).sum::<f64>();
    let pixels = valid as f64;
    let (mean_a, mean_b) = (sum_a / pixels, sum_b / pixels);
    Ok(Metrics {
        mean_luminance_a: mean_a,
        mean_luminance_b: mean_b,
        luminance_ratio: if mean_a == mean_b { 1.0 } else { mean_a / mean_b },
        mean_abs: abs / (3.0 * pixels),
        rmse: (squares / (3.0 * pixels)).sqrt(),
        rel_mse: sum / pixels,
        rel_mse_trimmed,
        flip_mean,
        changed_fraction: changed as f64 / pixels,
        invalid_pixels: a.pixels.len() - valid,
    })
}

/// [`Metrics::rel_mse_trimmed`] alone; NaN if no pixel is finite in both.
pub fn noise(a: &Picture, b: &Picture) -> f64 {
    let finite = |(a, b): &(&Vec3, &Vec3)| a.is_finite() && b.is_finite();
    let pairs = a.pixels.iter().zip(&b.pixels).filter(finite);
    trimmed_mean(&mut pairs.map(|(&a, &b)| relative_square(a, b)).collect::<Vec<_>>())
}

fn relative_square(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    (d * d / (b * b + Vec3::splat(REL_MSE_FLOOR))).element_sum() / 3.0
}

/// Sorts the values; the mean without the largest.
fn trimmed_mean(values: &mut [f32]) -> f64 {
    values.sort_unstable_by(f32::total_cmp);
    let kept = values.len() - (values.len() as f64 * TRIMMED_SHARE) as usize;
    values[..kept].iter().map(|&value| f64::from(value)).sum::<f64>() / kept as f64
}

#[cfg(test)]
mod tests {
    use super::metrics;
    use crate::picture::Picture;
    use glam::Vec3;

    fn picture(pixels: Vec<Vec3>) -> Picture {
        Picture { width: pixels.len(), height: 1, pixels }
    }

    #[test]
    fn equal_pictures_differ_by_nothing() {
        let a = picture(vec![Vec3::ZERO, Vec3::new(0.5, 7.0, 0.1)]);
        let m = metrics(&a, &a, 0.0).unwrap();
        assert_eq!((m.mean_abs, m.rmse, m.rel_mse, m.changed_fraction), (0.0, 0.0, 0.0, 0.0));
        assert_eq!(m.luminance_ratio, 1.0);
    }

    #[test]
    fn one_channel_of_one_pixel_of_two_gives_the_numbers_done_by_hand() {
        let a = picture(vec![Vec3::new(0.5, 0.2, 0.2), Vec3::splat(0.2)]);
        let b = picture(vec![Vec3::new(0.2, 0.2, 0.2), Vec3::splat(0.2)]);
        let m = metrics(&a, &b, 0.0).unwrap();
        let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-6, "{x} is not {y}");
        near(m.mean_abs, 0.3 / 6.0);
        near(m.rmse, (0.09f64 / 6.0).sqrt());
        near(m.rel_mse, 0.09 / 0.05 / 6.0);
        near(m.changed_fraction, 0.5);
        near(m.mean_luminance_a - m.mean_luminance_b, 0.3 * 0.2126 / 2.0);
    }

    #[test]
    fn one_firefly_in_a_thousand_pixels_is_trimmed() {
        let b = picture(vec![Vec3::ONE; 1000]);
        let mut a = b.clone();
        a.pixels[17] = Vec3::splat(1e4);
        let m = metrics(&a, &b, 0.0).unwrap();
        assert!(m.rel_mse > 1e4 && m.rel_mse_trimmed == 0.0, "{m:?}");
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_left_out() {
        let a = picture(vec![Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::ONE]);
        let b = picture(vec![Vec3::ONE; 3]);
        let m = metrics(&a, &b, 0.0).unwrap();
        assert_eq!((m.invalid_pixels, m.mean_abs), (2, 0.0));
        assert!(metrics(&picture(vec![Vec3::NAN]), &picture(vec![Vec3::ONE]), 0.0).is_err());
    }
}
