//! Random numbers that depend on pixel, sample and seed, never on threads.

use sobol_burley::{NUM_DIMENSION_SETS_4D, sample_4d};

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
    sample: u32,
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
            Sequence::Sobol => Self {
                sequence,
                key: mix(key ^ u64::from(sample >> SEQUENCE_BITS)),
                sample: sample & ((1 << SEQUENCE_BITS) - 1),
            },
            Sequence::Independent => {
                Self { sequence, key: mix(key ^ u64::from(sample)), sample: 0 }
            }
        }
    }

    /// The `set`-th four numbers.
    #[must_use]
    pub fn set(&self, set: u32) -> [f32; 4] {
        if self.sequence == Sequence::Sobol && set < NUM_DIMENSION_SETS_4D {
            return sample_4d(self.sample, set, self.key as u32);
        }
        let first = mix(self.key ^ mix(u64::from(set) | u64::from(self.sample) << 32));
        let second = mix(first);
        let unit = |bits: u64| (bits as u32 >> 8) as f32 * (1.0 / (1_u32 << 24) as f32);
        [unit(first), unit(first >> 32), unit(second), unit(second >> 32)]
    }
}

/// One step of SplitMix64 (G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014): every bit of the result depends on every bit of the argument.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}
