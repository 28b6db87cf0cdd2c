//! Random numbers that depend on pixel, sample and seed, never on threads.

use sobol_burley::NUM_DIMENSION_SETS_4D;
use sobol_burley::parts::{
    Int4, hash, hash_int4, owen_scramble_int4_rev, owen_scramble_rev, sobol_rev,
};
use std::sync::LazyLock;

/// Where the numbers of a path come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sequence {
    /// Owen-scrambled Sobol points: the samples of a pixel cover the space of paths evenly, so noise
    /// falls faster than for independent numbers. For powers of two it falls fastest.
    #[default]
    Sobol,
    /// Independent numbers: the textbook Monte Carlo that tests of the other are held against.
    Independent,
}

/// The points of `[0, 1)` that one path of one pixel consumes, four dimensions at a time.
///
/// It has no state that advances: a dimension set has the same numbers whenever it is asked for, so
/// what one decision of a path consumes does not shift what the next one gets.
///
/// Source: B. Burley, "Practical Hash-based Owen Scrambling", Journal of Computer Graphics
/// Techniques 9(4), 2020.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    sequence: Sequence,
    /// A hash of the seed and the pixel.
    key: u64,
    /// The number of the sample, shuffled and with its bits reversed; 0 if numbers are independent.
    shuffled: u32,
}

/// The crate `sobol_burley` has sequences of this length; beyond it another scramble is used.
const SEQUENCE_BITS: u32 = 16;

impl Sampler {
    /// The numbers of the `sample`-th path of a pixel.
    #[must_use]
    pub fn new(sequence: Sequence, seed: u64, x: u32, y: u32, sample: u32) -> Self {
        let pixel = u64::from(x) | u64::from(y) << 32;
        let key = mix(mix(seed).wrapping_add(pixel));
        match sequence {
            Sequence::Sobol => {
                let key = mix(key ^ u64::from(sample >> SEQUENCE_BITS));
                let index = sample & ((1 << SEQUENCE_BITS) - 1);
                let shuffle = hash(key as u32 ^ 0x79c6_8e4a);
                Self { sequence, key, shuffled: owen_scramble_rev(index.reverse_bits(), shuffle) }
            }
            Sequence::Independent => {
                Self { sequence, key: mix(key ^ u64::from(sample)), shuffled: 0 }
            }
        }
    }

    /// The `set`-th four numbers.
    #[must_use]
    pub fn set(&self, set: u32) -> [f32; 4] {
        if self.sequence == Sequence::Sobol && set < NUM_DIMENSION_SETS_4D {
            // What `sobol_burley::sample_4d` does, with the shuffle done once for all sets.
            let seed = (self.key as u32).wrapping_mul(0x9c8f_2d3b) ^ set;
            let scrambles =
                [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8].map(|salt| seed ^ salt);
            let points = Int4::from(sobol_points(self.shuffled, set));
            let scrambled = owen_scramble_int4_rev(points, hash_int4(scrambles.into()));
            return scrambled.reverse_bits().to_f32_norm();
        }
        let first = mix(self.key ^ mix(u64::from(set)));
        let second = mix(first);
        let unit = |bits: u64| (bits as u32 >> 8) as f32 * (1.0 / (1_u32 << 24) as f32);
        [unit(first), unit(first >> 32), unit(second), unit(second >> 32)]
    }
}

/// The `set`-th four coordinates of a Sobol point, bits reversed, by the first 16 bits of its number.
///
/// Coordinates are linear over the bits of the number, so those of four bits at a time are summed
/// from a table instead of those of each bit.
#[inline]
fn sobol_points(index: u32, set: u32) -> [u32; 4] {
    let quarters = &SOBOL[set as usize];
    let mut sum = [0; 4];
    for (place, quarter) in quarters.iter().enumerate() {
        let points = quarter[(index >> (28 - 4 * place)) as usize & 15];
        for (sum, point) in sum.iter_mut().zip(points) {
            *sum ^= point;
        }
    }
    sum
}

/// Of one set: the four coordinates for each value of each four bits, from the highest.
type Quarters = [[[u32; 4]; 16]; 4];

static SOBOL: LazyLock<Vec<Quarters>> = LazyLock::new(|| {
    let points = |set: u32, place: usize, value: usize| {
        let index = (value as u32) << (28 - 4 * place);
        std::array::from_fn(|dimension| sobol_rev(index, 4 * set + dimension as u32))
    };
    let quarters =
        |set| std::array::from_fn(|place| std::array::from_fn(|value| points(set, place, value)));
    (0..NUM_DIMENSION_SETS_4D).map(quarters).collect()
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
        for (sample, set) in [(0, 0), (1, 0), (77, 3), (4096, 17), (65_535, 63)] {
            let sampler = Sampler::new(Sequence::Sobol, 5, 3, 2, sample);
            let expected = sobol_burley::sample_4d(sample, set, sampler.key as u32);
            assert_eq!(sampler.set(set), expected, "sample {sample}, set {set}");
        }
    }
}
