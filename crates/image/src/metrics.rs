//! Differences between two images as single numbers.

use crate::error::{CompareError, same_size};
use crate::{Image, luminance, srgb_from_linear};
use glam::Vec3;

/// A pixel counts as changed if a channel moves by more than this in sRGB: two steps of an 8-bit
/// image. A single step may be due to rounding.
const CHANGED_SRGB: f32 = 2.0 / 255.0;

/// Added to the denominator of the relative error, so that it stays finite at black pixels: the
/// square of a dark grey, 0.1.
const REL_MSE_FLOOR: f32 = 0.01;

/// Share of the pixels that [`Metrics::rel_mse_trimmed`] leaves out.
const TRIMMED_SHARE: f64 = 0.001;

/// Differences between an image `a` and a reference `b`, in linear RGB.
///
/// Means run over the pixels in which all three channels of both images are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
    /// The same without the worst 0.1 % of the pixels, and so without most fireflies.
    pub rel_mse_trimmed: f64,
    /// Mean of [`flip()`](crate::flip()), in `0.0..=1.0`.
    pub flip_mean: f64,
    /// Share of the pixels in which a channel differs by more than two steps of 8-bit sRGB.
    pub changed_fraction: f64,
    /// Number of pixels left out because one of the images is NaN or infinite there.
    pub invalid_pixels: usize,
}

/// Compares two images of the same size whose mean FLIP error is `flip_mean`.
pub(crate) fn metrics(a: &Image, b: &Image, flip_mean: f64) -> Result<Metrics, CompareError> {
    let (mut sum_a, mut sum_b, mut abs, mut squares) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let mut changed = 0usize;
    let mut relative: Vec<f32> = Vec::with_capacity(a.pixels.len());
    for (&a, &b) in a.pixels.iter().zip(&b.pixels) {
        let (luminance_a, luminance_b) = (luminance(a), luminance(b));
        let (a, b) = (color(a), color(b));
        if !(a.is_finite() && b.is_finite()) {
            continue;
        }
        let d = a - b;
        sum_a += f64::from(luminance_a);
        sum_b += f64::from(luminance_b);
        abs += f64::from(d.abs().element_sum());
        squares += f64::from(d.length_squared());
        relative.push(relative_square(a, b));
        let shown = (a.map(srgb_from_linear) - b.map(srgb_from_linear)).abs();
        changed += usize::from(shown.max_element() > CHANGED_SRGB);
    }
    let valid = relative.len();
    if valid == 0 {
        return Err(CompareError::NothingFinite);
    }
    let rel_mse_trimmed = trimmed_mean(&mut relative);
    // The values are sorted by now, and adding small ones first loses the fewest digits.
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

/// Returns [`Metrics::rel_mse_trimmed`] alone, without the cost of FLIP. It is the measure of noise
/// of the renderer: fireflies do not dominate it.
///
/// # Errors
///
/// If the images differ in size, or no pixel is finite in both.
pub fn trimmed_relative_error(a: &Image, b: &Image) -> Result<f64, CompareError> {
    same_size(a, b)?;
    let pairs = a.pixels.iter().zip(&b.pixels).map(|(&a, &b)| (color(a), color(b)));
    let finite = pairs.filter(|(a, b)| a.is_finite() && b.is_finite());
    let mut values: Vec<f32> = finite.map(|(a, b)| relative_square(a, b)).collect();
    if values.is_empty() {
        return Err(CompareError::NothingFinite);
    }
    Ok(trimmed_mean(&mut values))
}

fn color([r, g, b, _]: [f32; 4]) -> Vec3 {
    Vec3::new(r, g, b)
}

fn relative_square(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    (d * d / (b * b + Vec3::splat(REL_MSE_FLOOR))).element_sum() / 3.0
}

/// Sorts the values and returns their mean without the largest ones.
fn trimmed_mean(values: &mut [f32]) -> f64 {
    values.sort_unstable_by(f32::total_cmp);
    let kept = values.len() - (values.len() as f64 * TRIMMED_SHARE) as usize;
    values[..kept].iter().map(|&value| f64::from(value)).sum::<f64>() / kept as f64
}

#[cfg(test)]
mod tests {
    use super::metrics;
    use crate::{CompareError, Image, trimmed_relative_error};
    use glam::Vec3;

    /// Returns an image of one row. Its alpha is one that would spoil every metric.
    fn image(pixels: Vec<Vec3>) -> Image {
        let pixels: Vec<_> = pixels.iter().map(|p| [p.x, p.y, p.z, f32::NAN]).collect();
        Image { width: pixels.len() as u32, height: 1, pixels }
    }

    #[test]
    fn equal_images_have_no_difference() {
        let a = image(vec![Vec3::ZERO, Vec3::new(0.5, 7.0, 0.1)]);
        let m = metrics(&a, &a, 0.0).unwrap();
        assert_eq!((m.mean_abs, m.rmse, m.rel_mse, m.changed_fraction), (0.0, 0.0, 0.0, 0.0));
        assert_eq!(m.luminance_ratio, 1.0);
    }

    #[test]
    fn one_channel_of_one_pixel_of_two_gives_the_numbers_done_by_hand() {
        let a = image(vec![Vec3::new(0.5, 0.2, 0.2), Vec3::splat(0.2)]);
        let b = image(vec![Vec3::new(0.2, 0.2, 0.2), Vec3::splat(0.2)]);
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
        let b = image(vec![Vec3::ONE; 1000]);
        let mut a = b.clone();
        a.pixels[17] = [1e4; 4];
        let m = metrics(&a, &b, 0.0).unwrap();
        assert!(m.rel_mse > 1e4 && m.rel_mse_trimmed == 0.0, "{m:?}");
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_left_out() {
        let a = image(vec![Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::ONE]);
        let b = image(vec![Vec3::ONE; 3]);
        let m = metrics(&a, &b, 0.0).unwrap();
        assert_eq!((m.invalid_pixels, m.mean_abs), (2, 0.0));
        assert!(metrics(&image(vec![Vec3::NAN]), &image(vec![Vec3::ONE]), 0.0).is_err());
    }
    #[test]
    fn images_that_cannot_be_compared_are_refused() {
        let (one, two) = (image(vec![Vec3::ONE]), image(vec![Vec3::ONE; 2]));
        let sizes = CompareError::Size { a: [1, 1], b: [2, 1] };
        assert_eq!(trimmed_relative_error(&one, &two), Err(sizes.clone()));
        assert_eq!(crate::Difference::between(&one, &two), Err(sizes));
        let short = Image { width: 2, ..one.clone() };
        let expected = CompareError::PixelCount { width: 2, height: 1, count: 1 };
        assert_eq!(crate::flip(&short, &two), Err(expected));
        let nan = image(vec![Vec3::NAN]);
        assert_eq!(trimmed_relative_error(&nan, &one), Err(CompareError::NothingFinite));
    }
}
