//! The sum of the samples of one pixel, in fixed point.

/// A sum in steps of 2⁻⁵⁶: the low half of a `u128` and the high one. A `u128` itself is aligned to
/// 16 bytes, which makes a pixel of 64 bytes, eight of them empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sum(pub(crate) [u64; 2]);

impl Sum {
    fn get(self) -> u128 {
        u128::from(self.0[0]) | u128::from(self.0[1]) << 64
    }

    fn add(&mut self, steps: u128) {
        // No sum of a picture comes near the limit. Saturation keeps addition associative.
        let sum = self.get().saturating_add(steps);
        self.0 = [sum as u64, (sum >> 64) as u64];
    }
}

/// The sum of the samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PixelSum {
    /// Sums of red, green and blue. What is added is less than 2³⁹, so 2³² additions do not
    /// overflow.
    pub(crate) radiance: [Sum; 3],
    /// Number of samples that met a surface or an environment.
    pub(crate) covered: u32,
    /// Number of samples.
    pub(crate) samples: u32,
}

/// Bits after the binary point of a sum.
const FRACTION_BITS: i32 = 56;
/// Upper limit of a sample's radiance, exclusive.
const LIMIT: f32 = (1_u64 << 39) as f32;

impl PixelSum {
    /// Adds a sample and returns true. A radiance that is NaN, negative, or 2³⁹ or more is counted
    /// as black, and the result is false.
    pub(super) fn add(&mut self, radiance: [f32; 3], covered: bool) -> bool {
        self.samples += 1;
        self.covered += u32::from(covered);
        self.add_light(radiance)
    }

    /// Adds light that belongs to the pixel but to none of its samples; see [`Self::add`].
    pub(super) fn add_light(&mut self, radiance: [f32; 3]) -> bool {
        // The comparison is false for NaN and true for negative zero.
        let valid = radiance.iter().all(|&c| (0.0..LIMIT).contains(&c));
        if valid {
            for (sum, c) in self.radiance.iter_mut().zip(radiance) {
                sum.add(fixed(c));
            }
        }
        valid
    }

    /// Adds the samples of another sum.
    pub(super) fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.covered += other.covered;
        for (radiance, other) in self.radiance.iter_mut().zip(other.radiance) {
            radiance.add(other.get());
        }
    }

    /// Returns true if at most `most` samples, and light paths, can have made this sum. What light
    /// paths add does not depend on the samples of the pixel, so the radiance may be that of 2³²
    /// additions whatever the samples are.
    pub(crate) fn is_possible(&self, most: u32) -> bool {
        let limit = 1 << (32 + 39 + FRACTION_BITS);
        self.samples <= most
            && self.covered <= self.samples
            && self.radiance.iter().all(|sum| sum.get() <= limit)
    }

    /// Returns mean radiance and coverage, rounded once; black and transparent without samples.
    pub(super) fn mean(&self) -> [f32; 4] {
        if self.samples == 0 {
            return [0.0; 4];
        }
        let count = f64::from(self.samples);
        let scale = (-f64::from(FRACTION_BITS)).exp2() / count;
        let [r, g, b] = self.radiance.map(|sum| (sum.get() as f64 * scale) as f32);
        [r, g, b, (f64::from(self.covered) / count) as f32]
    }
}

/// Returns `x` in steps of 2⁻⁵⁶, rounded down; `x` must be in `0.0..LIMIT`.
fn fixed(x: f32) -> u128 {
    // A normal number is its mantissa, 24 bits with the hidden one, times 2^(exponent - 150).
    // Subnormal numbers are far below one step.
    let bits = x.to_bits() & 0x7fff_ffff;
    let exponent = (bits >> 23) as i32;
    let mantissa = u128::from(bits & 0x007f_ffff | 0x0080_0000);
    let shift = exponent - 150 + FRACTION_BITS;
    if (0..=40).contains(&shift) {
        // The usual case, up to 256, takes 64 bits.
        u128::from((mantissa as u64) << shift)
    } else if shift >= 0 {
        mantissa << shift
    } else if shift > -24 {
        mantissa >> -shift
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::PixelSum;

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
            let mut pixel = PixelSum::default();
            for &x in samples {
                assert!(pixel.add([x; 3], true), "{why}");
            }
            let [r, _, _, a] = pixel.mean();
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
    fn an_invalid_radiance_counts_as_black() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e12] {
            let mut pixel = PixelSum::default();
            assert!(!pixel.add([1.0, bad, 1.0], true), "{bad}");
            assert_eq!(pixel.mean(), [0.0, 0.0, 0.0, 1.0], "{bad}");
        }
    }

    #[test]
    fn a_pixel_takes_56_bytes() {
        assert_eq!(size_of::<PixelSum>(), 56);
    }

    #[test]
    fn a_sum_that_its_samples_cannot_make_is_found() {
        let mut bright = PixelSum::default();
        assert!(bright.add([super::LIMIT.next_down(); 3], true));
        assert!(bright.is_possible(1) && !bright.is_possible(0));
        let overflowing = PixelSum { radiance: [super::Sum([0, u64::MAX]); 3], ..bright };
        assert!(!overflowing.is_possible(u32::MAX));
        assert!(!PixelSum { covered: 2, ..bright }.is_possible(9));
    }

    #[test]
    fn a_sum_that_does_not_fit_is_the_largest() {
        let mut full = PixelSum { radiance: [super::Sum([u64::MAX; 2]); 3], ..Default::default() };
        assert!(full.add([1.0; 3], true));
        full.merge(&full.clone());
        assert_eq!(full.radiance, [super::Sum([u64::MAX; 2]); 3]);
    }
}
