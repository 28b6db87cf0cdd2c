//! FLIP: how visible the difference is to a person who flips between two images.
//!
//! Each pixel gets an error from 0 (invisible) to 1 (the largest possible difference): the
//! difference in colour after a model of the eye's blur, increased where edges and points differ.
//!
//! Source: P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. Fairchild,
//! "FLIP: A Difference Evaluator for Alternating Images", Proceedings of the ACM on Computer
//! Graphics and Interactive Techniques 3(2), 2020. Symbols of the paper are given where a constant
//! appears.

use crate::error::{CompareError, same_size};
use crate::opponent::{lab_from_rgb, opponent_from_rgb, rgb_from_opponent};
use crate::{Image, Plane};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// Pixels per degree of vision (p) of the paper's viewer: 0.7 m from a screen that is 0.7 m wide
/// and has 3840 pixels.
const PIXELS_PER_DEGREE: f32 = 3840.0 * PI / 180.0;
/// Exponent that compresses colour differences (q_c).
const COLOR_EXPONENT: f32 = 0.7;
/// Share of the largest colour difference (p_c) that is mapped to `COLOR_KNEE_ERROR` (p_t).
const COLOR_KNEE: f32 = 0.4;
const COLOR_KNEE_ERROR: f32 = 0.95;
/// Exponent that strengthens small feature differences (q_f).
const FEATURE_EXPONENT: f32 = 0.5;
/// Width of the features that edge and point detectors look for, in degrees (w).
const FEATURE_DEGREES: f32 = 0.082;

/// A Gaussian `a sqrt(pi / b) exp(-(pi x)² / b)` over `x` in degrees.
#[derive(Clone, Copy)]
struct Gaussian {
    a: f32,
    b: f32,
}

/// The eye's sensitivity to contrast, one sum of Gaussians for each of the three opponent channels:
/// lightness, red against green, blue against yellow (table 1).
const SENSITIVITY: [&[Gaussian]; 3] = [
    &[Gaussian { a: 1.0, b: 0.0047 }],
    &[Gaussian { a: 1.0, b: 0.0053 }],
    &[Gaussian { a: 34.1, b: 0.04 }, Gaussian { a: 13.5, b: 0.025 }],
];
/// The widest of them decides how far all filters reach.
const WIDEST: f32 = 0.04;

/// Returns the LDR-FLIP error of each pixel, in `0.0..=1.0`: how visible the difference is to a
/// person who flips between the two images on a screen.
///
/// Linear values are clipped to `0.0..=1.0` first, and NaN counts as black. Alpha is ignored. The
/// viewer is that of the paper: 0.7 m from a screen that is 0.7 m wide and has 3840 pixels. The
/// result is symmetric in the arguments.
///
/// Source: P. Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", Proceedings
/// of the ACM on Computer Graphics and Interactive Techniques 3(2), 2020.
///
/// # Errors
///
/// If the images differ in size.
pub fn flip(a: &Image, b: &Image) -> Result<Plane, CompareError> {
    same_size(a, b)?;
    let [a, b] = [a, b].map(|image| {
        let opponent: Vec<Vec3> = image
            .pixels
            .par_iter()
            .map(|&[r, g, b, _]| opponent_from_rgb(Vec3::from([r, g, b].map(clip))))
            .collect();
        (opponent, image.width as usize, image.height as usize)
    });
    let color = color_difference(&a, &b);
    let feature = feature_difference(&a, &b);
    let values = color.iter().zip(&feature).map(|(c, f)| c.powf(1.0 - f)).collect();
    Ok(Plane { width: a.1, height: a.2, values })
}

/// Opponent colours, width and height.
type Opponent = (Vec<Vec3>, usize, usize);

/// Clips to `0.0..=1.0`; NaN becomes 0.
fn clip(x: f32) -> f32 {
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

fn channel((pixels, width, height): &Opponent, index: usize) -> Plane {
    let values = pixels.iter().map(|pixel| pixel[index]).collect();
    Plane { width: *width, height: *height, values }
}

/// Section 4.1: blurs both images by the contrast sensitivity of the eye, then measures distances
/// in a space where they match perception.
fn color_difference(a: &Opponent, b: &Opponent) -> Vec<f32> {
    let largest = hyab(hunt(lab_from_rgb(Vec3::Y)), hunt(lab_from_rgb(Vec3::Z)));
    let largest = largest.powf(COLOR_EXPONENT);
    let [a, b] = [a, b].map(seen);
    let redistribute = |difference: f32| {
        let knee = COLOR_KNEE * largest;
        if difference < knee {
            COLOR_KNEE_ERROR / knee * difference
        } else {
            let above = (difference - knee) / (largest - knee);
            COLOR_KNEE_ERROR + above * (1.0 - COLOR_KNEE_ERROR)
        }
    };
    a.par_iter()
        .zip(&b)
        .map(|(&a, &b)| redistribute(hyab(a, b).powf(COLOR_EXPONENT)).min(1.0))
        .collect()
}

/// Returns the image after the blur of the eye, in L*a*b* with Hunt's adjustment.
fn seen(picture: &Opponent) -> Vec<Vec3> {
    let filtered = [0, 1, 2].map(|index| filter_channel(&channel(picture, index), index));
    (0..picture.0.len())
        .into_par_iter()
        .map(|i| {
            let [l, x, z] = [0, 1, 2].map(|c: usize| filtered[c].values[i]);
            hunt(lab_from_rgb(rgb_from_opponent(Vec3::new(l, x, z)).clamp(Vec3::ZERO, Vec3::ONE)))
        })
        .collect()
}

/// Filters a channel with its sensitivity, whose weights sum to 1. Each Gaussian is separable, the
/// sum of two is not, so it is the sum of two filtered planes.
fn filter_channel(plane: &Plane, index: usize) -> Plane {
    let reach = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let weights = |gaussian: &Gaussian| -> Vec<f32> {
        let weight = |x: i32| {
            let degrees = x as f32 / PIXELS_PER_DEGREE;
            (-(PI * degrees).powi(2) / gaussian.b).exp()
        };
        (-reach..=reach).map(weight).collect()
    };
    let sum = |weights: &[f32]| weights.iter().sum::<f32>();
    let terms: Vec<(f32, Vec<f32>)> = SENSITIVITY[index]
        .iter()
        .map(|gaussian| (gaussian.a * (PI / gaussian.b).sqrt(), weights(gaussian)))
        .collect();
    let total: f32 = terms.iter().map(|(scale, weights)| scale * sum(weights).powi(2)).sum();
    let mut filtered = vec![0.0; plane.values.len()];
    for (scale, weights) in &terms {
        let term = plane.convolve(weights, weights);
        for (filtered, value) in filtered.iter_mut().zip(&term.values) {
            *filtered += scale / total * value;
        }
    }
    Plane { values: filtered, ..*plane }
}

/// Scales chroma by lightness, because dark colours look less colourful (the Hunt effect).
fn hunt(lab: Vec3) -> Vec3 {
    Vec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
}

/// HyAB distance: city-block in lightness, Euclidean in chroma (S. Abasi et al., "Distance metrics
/// for very large color differences", 2020).
fn hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// Section 4.2: measures edges and points that only one of the images has.
fn feature_difference(a: &Opponent, b: &Opponent) -> Vec<f32> {
    let [a, b] = [a, b].map(|picture| {
        let mut lightness = channel(picture, 0);
        lightness.values.iter_mut().for_each(|value| *value = (*value + 16.0) / 116.0);
        let [smooth, first, second] = feature_filters();
        let magnitude = |derivative: &[f32]| -> Vec<f32> {
            let along_x = lightness.convolve(derivative, &smooth);
            let along_y = lightness.convolve(&smooth, derivative);
            let pairs = along_x.values.iter().zip(&along_y.values);
            pairs.map(|(&x, &y)| Vec2::new(x, y).length()).collect()
        };
        (magnitude(&first), magnitude(&second))
    });
    (0..a.0.len())
        .map(|i| {
            let (edge, point) = ((a.0[i] - b.0[i]).abs(), (a.1[i] - b.1[i]).abs());
            (FRAC_1_SQRT_2 * edge.max(point)).powf(FEATURE_EXPONENT)
        })
        .collect()
}

/// Returns a Gaussian and its first and second derivatives, in one dimension. The weights of the
/// Gaussian sum to 1. Of a derivative, the positive weights sum to 1 and the negative ones to -1.
fn feature_filters() -> [Vec<f32>; 3] {
    let deviation = 0.5 * FEATURE_DEGREES * PIXELS_PER_DEGREE;
    let reach = (3.0 * deviation).ceil() as i32;
    let sample = |f: fn(f32, f32) -> f32| -> Vec<f32> {
        let gaussian = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        let weights: Vec<f32> =
            (-reach..=reach).map(|x| f(x as f32, deviation) * gaussian(x as f32)).collect();
        let positive: f32 = weights.iter().filter(|&&w| w > 0.0).sum();
        let negative: f32 = -weights.iter().filter(|&&w| w < 0.0).sum::<f32>();
        weights.iter().map(|&w| if w > 0.0 { w / positive } else { w / negative }).collect()
    };
    // The Gaussian has no negative weights, so its empty negative sum divides nothing.
    [sample(|_, _| 1.0), sample(|x, _| -x), sample(|x, s| x * x / (s * s) - 1.0)]
}

#[cfg(test)]
mod tests {
    use super::Plane;
    use crate::{Image, linear_from_srgb};

    fn flip(a: &Image, b: &Image) -> Plane {
        super::flip(a, b).expect("images of the same size")
    }

    /// Returns an image whose sRGB values are given by a formula of the pixel.
    fn image(width: u32, height: u32, srgb: impl Fn(f32, f32) -> [f32; 3]) -> Image {
        Image::from_fn(width, height, |x, y| {
            let [r, g, b] = srgb(x as f32, y as f32).map(linear_from_srgb);
            [r, g, b, 1.0]
        })
    }

    fn gradient(x: f32, y: f32) -> [f32; 3] {
        [x / 63.0, y / 47.0, 0.5]
    }

    fn checker(x: f32, y: f32) -> [f32; 3] {
        let on = ((x / 4.0).floor() + (y / 4.0).floor()) % 2.0 == 0.0;
        if on { [0.9, 0.8, 0.1] } else { [0.1, 0.2, 0.7] }
    }

    fn waves(x: f32, y: f32) -> [f32; 3] {
        let wave = |phase: f32| 0.5 + 0.45 * (0.31 * x + 0.17 * y + phase).sin();
        [wave(0.0), wave(2.0), wave(4.0)]
    }

    #[test]
    fn equal_images_have_no_error() {
        let a = image(20, 10, gradient);
        assert_eq!(flip(&a, &a).mean(), 0.0);
    }

    #[test]
    fn the_largest_error_is_one_and_nan_counts_as_black() {
        let green = image(40, 40, |_, _| [0.0, 1.0, 0.0]);
        let blue = image(40, 40, |_, _| [0.0, 0.0, 1.0]);
        assert!((flip(&green, &blue).mean() - 1.0).abs() < 1e-5, "{}", flip(&green, &blue).mean());
        let mut broken = image(8, 8, |_, _| [0.0; 3]);
        let black = broken.clone();
        broken.pixels[9] = [f32::NAN; 4];
        assert_eq!(flip(&broken, &black).mean(), 0.0);
    }

    #[test]
    fn values_agree_with_those_of_the_authors() {
        // Mean and the errors of the pixels (5, 7), (31, 20) and (63, 47), from flip-evaluator 1.7
        // with its default of 67.02 pixels per degree, for the same 64 x 48 sRGB pictures.
        type Formula = fn(f32, f32) -> [f32; 3];
        let mirrored: Formula = |x, y| gradient(63.0 - x, y);
        let shifted: Formula = |x, y| checker(x + 1.0, y);
        let grey: Formula = |_, _| [0.3; 3];
        let dot: Formula = |x, y| [if (x, y) == (31.0, 20.0) { 1.0 } else { 0.3 }; 3];
        let table: [(&str, Formula, Formula, [f32; 4]); 5] = [
            ("colours", gradient, mirrored, [0.679_607, 0.961_325, 0.068_153, 0.955_086]),
            ("edges", gradient, checker, [0.830_275, 0.960_466, 0.716_067, 0.808_326]),
            ("both", waves, checker, [0.908_708, 0.969_645, 0.872_169, 0.971_296]),
            ("a dot", grey, dot, [0.002_270, 0.0, 0.553_661, 0.0]),
            ("a shift", checker, shifted, [0.279_373, 0.006_664, 0.264_264, 0.969_141]),
        ];
        for (name, a, b, [mean, p, q, r]) in table {
            let map = flip(&image(64, 48, a), &image(64, 48, b));
            let at = |x: usize, y: usize| map.values[y * 64 + x];
            let found = [map.mean() as f32, at(5, 7), at(31, 20), at(63, 47)];
            for (found, expected) in found.into_iter().zip([mean, p, q, r]) {
                assert!((found - expected).abs() < 2e-4, "{name}: {found} is not {expected}");
            }
        }
    }
}
