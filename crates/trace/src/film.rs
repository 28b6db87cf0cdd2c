//! What a render leaves behind: sums of samples, and the picture they make.

/// The sums of the samples of each pixel.
///
/// Sums are exact: they are counted in whole steps of 2⁻⁵⁶, so the order in which samples come
/// does not matter. Whatever the number of threads, and whether the samples were taken in one run, in two, or on
/// several machines, the same samples make the same bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    /// Pixels in a row.
    pub width: u32,
    /// Rows, from the top.
    pub height: u32,
    /// Samples in each pixel.
    pub samples: u32,
    /// Samples whose radiance was not a number, negative, or 2³⁹ and more: they count as black.
    pub rejected: u64,
    /// Row by row.
    pub(crate) pixels: Vec<PixelSum>,
}

/// Linear RGB and coverage, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and alpha.
    pub pixels: Vec<[f32; 4]>,
}

/// The sum of the samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PixelSum {
    /// Radiance in steps of 2⁻⁵⁶. A sample is less than 2³⁹, so 2³² of them do not overflow.
    pub(crate) radiance: [u128; 3],
    /// How many samples met a surface or an environment.
    pub(crate) covered: u32,
}

/// Bits after the binary point of a sum.
const FRACTION_BITS: i32 = 56;
/// A sample at or above this radiance is rejected.
const LIMIT: f32 = (1_u64 << 39) as f32;

impl Film {
    /// A film without samples.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![PixelSum::default(); width as usize * height as usize];
        Self { width, height, samples: 0, rejected: 0, pixels }
    }

    /// The mean of the samples, rounded once; black where there are none.
    #[must_use]
    pub fn image(&self) -> Image {
        let scale = (-f64::from(FRACTION_BITS)).exp2() / f64::from(self.samples.max(1));
        let mean = |pixel: &PixelSum| {
            let [r, g, b] = pixel.radiance.map(|sum| (sum as f64 * scale) as f32);
            [r, g, b, (f64::from(pixel.covered) / f64::from(self.samples.max(1))) as f32]
        };
        Image {
            width: self.width,
            height: self.height,
            pixels: self.pixels.iter().map(mean).collect(),
        }
    }
}

impl PixelSum {
    /// Adds a sample; says whether it was fit to be added.
    pub(crate) fn add(&mut self, radiance: [f32; 3], covered: bool) -> bool {
        self.covered += u32::from(covered);
        // False for NaN. Negative zero is zero.
        let fit = radiance.iter().all(|&c| (0.0..LIMIT).contains(&c));
        if fit {
            for (sum, c) in self.radiance.iter_mut().zip(radiance) {
                *sum += fixed(c);
            }
        }
        fit
    }
}

/// `x` in steps of 2⁻⁵⁶, rounded down; `x` must be in `0.0..LIMIT`.
fn fixed(x: f32) -> u128 {
    // A normal number is its mantissa, 24 bits with the hidden one, times 2^(exponent - 150). What
    // is subnormal is far below one step.
    let bits = x.to_bits() & 0x7fff_ffff;
    let exponent = (bits >> 23) as i32;
    let mantissa = u128::from(bits & 0x007f_ffff | 0x0080_0000);
    let shift = exponent - 150 + FRACTION_BITS;
    if shift >= 0 {
        mantissa << shift
    } else if shift > -24 {
        mantissa >> -shift
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_is_that_of_exact_sums() {
        let table: [(&str, &[f32], f32); 6] = [
            ("one", &[1.0], 1.0),
            ("zeros of both signs", &[0.0, -0.0], 0.0),
            ("large and small do not absorb each other", &[1e9, 1e-3, 1e-3, 1e9], 5e8 + 5e-4),
            ("thirds", &[1.0 / 3.0; 3], 1.0 / 3.0),
            ("tiny", &[1e-12, 3e-12], 2e-12),
            ("subnormal", &[1e-40], 0.0),
        ];
        for (why, samples, mean) in table {
            let mut film = Film::new(1, 1);
            for &x in samples {
                assert!(film.pixels[0].add([x; 3], true), "{why}");
                film.samples += 1;
            }
            let [r, _, _, a] = film.image().pixels[0];
            assert!((r - mean).abs() <= 2e-5 * mean, "{why}: {r} is not {mean}");
            assert_eq!(a, 1.0, "{why}");
        }
    }

    #[test]
    fn the_order_of_samples_changes_no_bit() {
        let samples: Vec<f32> = (0..999).map(|i| (i as f32 * 0.7).sin().exp() * 1e3).collect();
        let sum = |order: &mut dyn Iterator<Item = &f32>| {
            let mut pixel = PixelSum::default();
            order.for_each(|&x| assert!(pixel.add([x; 3], true)));
            pixel
        };
        assert_eq!(sum(&mut samples.iter()), sum(&mut samples.iter().rev()));
    }

    #[test]
    fn what_is_not_a_radiance_is_rejected() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e12] {
            let mut pixel = PixelSum::default();
            assert!(!pixel.add([1.0, bad, 1.0], true), "{bad}");
            assert_eq!(pixel.radiance, [0; 3], "{bad}");
        }
    }
}
