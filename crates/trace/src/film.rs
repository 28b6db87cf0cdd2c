//! What a render leaves behind: sums of samples, and the picture they make.

use crate::Options;
use rotund_image::Image;

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
    /// Samples brighter than any source of light in the scene, which no picture can be: the noise of
    /// paths that are found too seldom. They count in full.
    pub fireflies: u64,
    /// Samples that [`Options::clamp`] has scaled down.
    pub clamped: u64,
    /// The seed of its samples.
    pub seed: u64,
    /// Which samples of the picture it holds.
    pub shard: Shard,
    /// What the samples are of, in the words of whoever renders: films of different labels are of
    /// different pictures.
    pub label: String,
    /// Row by row.
    pub(crate) pixels: Vec<PixelSum>,
}

/// Every `count`-th sample of a picture from the `index`-th on. Shards of one picture can be rendered
/// anywhere, at any time; [`Film::merge`] puts them together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Less than `count`.
    pub index: u32,
    /// Into how many shards the picture is divided.
    pub count: u32,
}

impl Default for Shard {
    /// All samples.
    fn default() -> Self {
        Self { index: 0, count: 1 }
    }
}

impl Shard {
    /// How many of the first `samples` of a picture this shard has.
    #[must_use]
    pub fn share_of(self, samples: u32) -> u32 {
        samples.saturating_sub(self.index).div_ceil(self.count)
    }
}

/// Why films do not make one picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum MergeError {
    #[error("there is no film to merge")]
    Nothing,
    #[error(
        "film {number} is of another picture than film 1: size, seed, label and shard count must agree"
    )]
    Different { number: usize },
    #[error("shard {}/{count} is there {times} times, not once", index + 1)]
    Shards { index: u32, count: u32, times: usize },
    #[error("shard {} has {samples} samples, not {expected}: it is not finished", index + 1)]
    Unfinished { index: u32, samples: u32, expected: u32 },
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
    pub fn new(options: &Options) -> Self {
        let &Options { width, height, seed, shard, .. } = options;
        Self {
            width,
            height,
            samples: 0,
            rejected: 0,
            fireflies: 0,
            clamped: 0,
            seed,
            shard,
            label: String::new(),
            pixels: vec![PixelSum::default(); width as usize * height as usize],
        }
    }

    /// Puts all shards of a picture together, in any order: bit for bit the film of an undivided render.
    ///
    /// # Errors
    ///
    /// If the films are not all shards of one picture, each once and finished.
    pub fn merge(films: &[Self]) -> Result<Self, MergeError> {
        let first = films.first().ok_or(MergeError::Nothing)?;
        let of = |film: &Self| {
            (film.width, film.height, film.seed, film.shard.count, film.label.clone())
        };
        if let Some(other) = films.iter().position(|film| of(film) != of(first)) {
            return Err(MergeError::Different { number: other + 1 });
        }
        let count = first.shard.count;
        for index in 0..count {
            let times = films.iter().filter(|film| film.shard.index == index).count();
            if times != 1 {
                return Err(MergeError::Shards { index, count, times });
            }
        }
        let samples = films.iter().map(|film| film.samples).sum();
        for film in films {
            let (index, expected) = (film.shard.index, film.shard.share_of(samples));
            if film.samples != expected {
                return Err(MergeError::Unfinished { index, samples: film.samples, expected });
            }
        }
        let mut sum = Self { shard: Shard::default(), samples, ..first.clone() };
        for film in &films[1..] {
            sum.rejected += film.rejected;
            sum.fireflies += film.fireflies;
            sum.clamped += film.clamped;
            for (pixel, part) in sum.pixels.iter_mut().zip(&film.pixels) {
                pixel.covered += part.covered;
                for (radiance, part) in pixel.radiance.iter_mut().zip(part.radiance) {
                    *radiance += part;
                }
            }
        }
        Ok(sum)
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
            let mut film = Film::new(&Options { width: 1, height: 1, ..Options::default() });
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
