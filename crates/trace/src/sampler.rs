//! Random numbers as a function of seed, pixel, sample and dimension, independent of threads.

use rotund_bvh::{Isa, Vectorize};
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev, u32_to_f32_norm};
use std::sync::LazyLock;

/// The generator of the random numbers of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sequence {
    /// Owen-scrambled Sobol points: the samples of a pixel are stratified, so the error falls
    /// faster than with independent numbers, fastest at powers of two.
    #[default]
    Sobol,
    /// Independent numbers: plain Monte Carlo, the reference for tests of the other.
    Independent,
}

/// The random numbers of one path of one pixel, uniform in `0.0..1.0`, in sets of four dimensions.
///
/// A sampler has no state that advances: a set has the same numbers whenever it is asked for, so
/// the number of dimensions that one decision consumes does not shift those of the next.
///
/// Every set consists of the first four Sobol dimensions, whose two-dimensional projections are
/// best, with a shuffled order and a scramble of its own. Within a set the samples of a pixel are
/// stratified, best in the first two dimensions; different sets are independent. Further Sobol
/// dimensions would be stratified together only for far more samples than a pixel has.
///
/// Source: B. Burley, "Practical Hash-based Owen Scrambling", Journal of Computer Graphics
/// Techniques 9(4), 2020.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    sequence: Sequence,
    /// A hash of the seed and the pixel.
    key: u64,
    /// The index of the sample with its bits reversed; 0 for independent numbers.
    index: u32,
}

/// Bits of the length of a sequence of the crate `sobol_burley`; longer ones continue with another
/// scramble.
const SEQUENCE_BITS: u32 = 16;
/// Tells the numbers of light paths from those of pixels.
const LIGHT: u64 = 0x6c69_6768_7400_0000;

impl Sampler {
    /// Makes the sampler of the `sample`-th path of pixel `(x, y)`.
    #[must_use]
    pub fn new(sequence: Sequence, seed: u64, x: u32, y: u32, sample: u32) -> Self {
        let pixel = u64::from(x) | u64::from(y) << 32;
        let key = mix(mix(seed).wrapping_add(pixel));
        match sequence {
            Sequence::Sobol => {
                let key = mix(key ^ u64::from(sample >> SEQUENCE_BITS));
                let index = sample & ((1 << SEQUENCE_BITS) - 1);
                Self { sequence, key, index: index.reverse_bits() }
            }
            Sequence::Independent => Self { sequence, key: mix(key ^ u64::from(sample)), index: 0 },
        }
    }

    /// Makes the sampler of a light path, which belongs to no pixel.
    #[must_use]
    pub(crate) fn of_light_path(sequence: Sequence, seed: u64, number: u64) -> Self {
        let key = mix(mix(seed) ^ LIGHT);
        match sequence {
            Sequence::Sobol => {
                let key = mix(key ^ number >> SEQUENCE_BITS);
                let index = number as u32 & ((1 << SEQUENCE_BITS) - 1);
                Self { sequence, key, index: index.reverse_bits() }
            }
            Sequence::Independent => Self { sequence, key: mix(key ^ number), index: 0 },
        }
    }

    /// Returns the sampler of one of the `parts` paths that this one is split into. The parts of
    /// all samples of a pixel are stratified together, like `parts` times as many samples.
    #[must_use]
    pub(crate) fn part(&self, part: u32, parts: u32) -> Self {
        match self.sequence {
            Sequence::Sobol => {
                let number = self.index.reverse_bits() * parts + part;
                let key = mix(self.key ^ mix(u64::from(number >> SEQUENCE_BITS) + 1));
                let index = number & ((1 << SEQUENCE_BITS) - 1);
                Self { key, index: index.reverse_bits(), ..*self }
            }
            Sequence::Independent => {
                Self { key: mix(self.key ^ mix(u64::from(part) + 1)), ..*self }
            }
        }
    }

    /// Returns the sampler of a path that branches off this one at a segment.
    #[must_use]
    pub(crate) fn branch(&self, segment: u32) -> Self {
        Self { key: mix(self.key ^ mix(u64::from(segment) | 1 << 32)), ..*self }
    }

    /// Returns the four numbers of a set. Each decision of a path needs a set of its own;
    /// [`camera_ray`] consumes set 0. Numbers for a direction or point come first in a set, where
    /// they are stratified best.
    ///
    /// [`camera_ray`]: crate::camera_ray
    #[must_use]
    pub fn set(&self, set: u32) -> [f32; 4] {
        let [numbers] = self.sets(set);
        numbers
    }

    /// Returns the numbers of `N` sets from `first` on, in little more time than those of one:
    /// the chain of hashes that each number is takes most of it.
    #[must_use]
    pub(crate) fn sets<const N: usize>(&self, first: u32) -> [[f32; 4]; N] {
        let mut keys = [0; N];
        for (set, key) in (first..).zip(&mut keys) {
            *key = mix(self.key ^ mix(u64::from(set)));
        }
        if self.sequence == Sequence::Sobol {
            return Isa::default_set().vectorize(Scrambled { index: self.index, keys });
        }
        let unit = |bits: u64| (bits as u32 >> 8) as f32 * (1.0 / (1_u32 << 24) as f32);
        keys.map(|first| {
            let second = mix(first);
            [unit(first), unit(first >> 32), unit(second), unit(second >> 32)]
        })
    }
}

/// Four coordinates of each of `N` Sobol points, whose index has its bits reversed. The index is
/// shuffled and each coordinate scrambled, both by Owen's method: `sobol_burley::sample_4d` with
/// two seeds, the lower and the upper half of a key.
struct Scrambled<const N: usize> {
    index: u32,
    keys: [u64; N],
}

impl<const N: usize> Vectorize for Scrambled<N> {
    type Output = [[f32; 4]; N];

    #[inline(always)]
    fn run(self) -> [[f32; 4]; N] {
        let Self { index, keys } = self;
        let salts = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];
        let mut points = [[0; 4]; N];
        for (point, key) in points.iter_mut().zip(keys) {
            *point = sobol_point(owen_scramble_rev(index, key as u32));
        }
        let mut coordinates = [[0.0; 4]; N];
        for ((coordinates, point), key) in coordinates.iter_mut().zip(points).zip(keys) {
            for ((coordinate, point), salt) in coordinates.iter_mut().zip(point).zip(salts) {
                let scrambled = owen_scramble_rev(point, hash((key >> 32) as u32 ^ salt));
                *coordinate = u32_to_f32_norm(scrambled.reverse_bits());
            }
        }
        coordinates
    }
}

/// Returns the first four coordinates of a Sobol point, bits reversed, from the first 16 bits of
/// its index.
///
/// Coordinates are linear over the bits of the index, so a table of four bits at a time replaces a
/// sum over single bits.
#[inline(always)]
fn sobol_point(index: u32) -> [u32; 4] {
    let mut sum = [0; 4];
    for (place, quarter) in SOBOL.iter().enumerate() {
        let point = quarter[(index >> (28 - 4 * place)) as usize & 15];
        for (sum, point) in sum.iter_mut().zip(point) {
            *sum ^= point;
        }
    }
    sum
}

/// Coordinates for each value of each group of four bits, from the highest group.
static SOBOL: LazyLock<[[[u32; 4]; 16]; 4]> = LazyLock::new(|| {
    let point = |place: usize, value: usize| {
        let index = (value as u32) << (28 - 4 * place);
        std::array::from_fn(|dimension| sobol_rev(index, dimension as u32))
    };
    std::array::from_fn(|place| std::array::from_fn(|value| point(place, value)))
});

/// One step of SplitMix64 (G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014): every bit of the result depends on every bit of the argument.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_are_those_of_the_published_sequence() {
        for (sample, seed) in [(0_u32, 0), (1, 7), (77, 3), (4096, 17), (65_535, 63)] {
            // The seeds that `sample_4d` makes of one.
            let [shuffle, scramble] = [hash(seed ^ 0x79c6_8e4a), seed.wrapping_mul(0x9c8f_2d3b)];
            let expected = sobol_burley::sample_4d(sample, 0, seed);
            for isa in Isa::available() {
                let (index, key) = (sample.reverse_bits(), u64::from(shuffle));
                let keys = [!key, key | u64::from(scramble) << 32];
                let [_, found] = isa.vectorize(Scrambled { index, keys });
                assert_eq!(found, expected, "sample {sample}, seed {seed}, {isa:?}");
            }
        }
    }

    #[test]
    fn the_samples_of_a_pixel_are_stratified_in_every_set() {
        for set in [0, 1, 2, 20, 500, 1 << 16] {
            // Each elementary interval of area 1/64 has one of 64 points.
            for rows in [1, 2, 4, 8, 16, 32, 64] {
                let mut counts = vec![0; 64];
                for sample in 0..64 {
                    let [x, y, ..] = Sampler::new(Sequence::Sobol, 9, 5, 6, sample).set(set);
                    let (row, column) = (y * rows as f32, x * (64 / rows) as f32);
                    counts[row as usize * (64 / rows) + column as usize] += 1;
                }
                assert!(counts.iter().all(|&count| count == 1), "set {set}, {rows} rows");
            }
        }
    }

    #[test]
    fn the_parts_of_all_samples_are_stratified_together() {
        for (first, set) in [(0, 1), (64, 7), (65_472, 4)] {
            let mut counts = vec![0; 64];
            for sample in first..first + 16 {
                for part in 0..4 {
                    let whole = Sampler::new(Sequence::Sobol, 9, 5, 6, sample);
                    let [x, y, ..] = whole.part(part, 4).set(set);
                    counts[(y * 8.0) as usize * 8 + (x * 8.0) as usize] += 1;
                }
            }
            assert!(counts.iter().all(|&count| count == 1), "from sample {first}, set {set}");
        }
    }

    #[test]
    fn sets_are_not_correlated() {
        // Two sets in the same order would fill one line of a plane.
        for [a, b] in [[0, 1], [1, 2], [1, 4], [2, 1 << 16]] {
            let numbers = |set| {
                (0..4096).map(move |sample| {
                    Sampler::new(Sequence::Sobol, 1, 2, 3, sample).set(set)[0] - 0.5
                })
            };
            let covariance: f32 =
                numbers(a).zip(numbers(b)).map(|(x, y)| x * y).sum::<f32>() / 4096.0;
            // Four standard deviations of the mean of 4096 products of independent numbers.
            assert!(covariance.abs() < 4.0 / 12.0 / 64.0, "sets {a} and {b}: {covariance}");
        }
    }
}
