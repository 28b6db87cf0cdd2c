//! Random numbers with a fixed sequence, and directions and points made of them.
//!
//! Source: G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", OOPSLA
//! 2014.

use glam::DVec3;

/// A generator: splitmix64.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

/// Applies the finaliser of splitmix64: each input bit flips half of the result's bits on average.
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Random {
    /// Starts the sequence of splitmix64 from its published state.
    pub(crate) fn from_state(state: u64) -> Self {
        Self(state)
    }

    /// Starts a sequence that shares no numbers with those of the seeds nearby.
    #[cfg(test)]
    pub(crate) fn new(seed: u64) -> Self {
        Self(mix(seed))
    }

    /// Starts the sequence of one ray: the same whatever the number of rays, threads or families.
    pub(crate) fn of(seed: u64, name: &str, index: u64) -> Self {
        let name = name.bytes().fold(0xcbf2_9ce4_8422_2325, |h, byte| mix(h ^ u64::from(byte)));
        Self(mix(mix(seed ^ name).wrapping_add(index)))
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Returns a number in `0.0..1.0` with 24 bits.
    pub(crate) fn unit_f32(&mut self) -> f32 {
        (self.next() >> 40) as f32 * 2f32.powi(-24)
    }

    /// Returns a number in `0.0..1.0` with 53 bits.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Returns a number in `low..high`, distributed uniformly.
    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns 1 or -1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.next() >> 63 == 0 { 1.0 } else { -1.0 }
    }

    /// Returns an index in `0..count`.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    /// Returns a unit vector, distributed uniformly.
    pub(crate) fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let phi = self.range(0.0, std::f64::consts::TAU);
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    /// Returns a unit vector perpendicular to `axis`, which has unit length, distributed uniformly.
    pub(crate) fn perpendicular(&mut self, axis: DVec3) -> DVec3 {
        let x = axis.any_orthonormal_vector();
        let phi = self.range(0.0, std::f64::consts::TAU);
        x * phi.cos() + axis.cross(x) * phi.sin()
    }

    /// Returns a point of the unit ball, distributed uniformly.
    pub(crate) fn ball(&mut self) -> DVec3 {
        self.direction() * self.unit().cbrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_depends_on_seed_name_and_index_alone() {
        let first = Random::of(1, "sphere", 0).next();
        assert_eq!(first, Random::of(1, "sphere", 0).next());
        for other in
            [Random::of(2, "sphere", 0), Random::of(1, "cone", 0), Random::of(1, "sphere", 1)]
        {
            assert_ne!(first, other.clone().next());
        }
    }

    #[test]
    fn neighbouring_seeds_and_rows_share_no_numbers() {
        let mut seen = std::collections::HashSet::new();
        for seed in 0..8 {
            for name in ["sphere distance 1.5e0", "sphere distance 1.5e1"] {
                for index in 0..1_000 {
                    let mut random = Random::of(seed, name, index);
                    let first = [0; 8].map(|_| random.next());
                    assert!(first.iter().all(|&number| seen.insert(number)), "{seed} {name}");
                }
            }
        }
    }

    #[test]
    fn directions_have_unit_length_and_no_preference() {
        let mut random = Random::new(3);
        let mut sum = DVec3::ZERO;
        for _ in 0..100_000 {
            let axis = random.direction();
            let across = random.perpendicular(axis);
            assert!((axis.length() - 1.0).abs() < 1e-14);
            assert!(axis.dot(across).abs() < 1e-14 && (across.length() - 1.0).abs() < 1e-14);
            sum += axis;
        }
        assert!(sum.length() / 100_000.0 < 0.01, "{sum}");
    }
}
