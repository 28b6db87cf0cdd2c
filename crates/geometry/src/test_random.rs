//! Seeded random numbers for the tests and benches of this crate and of `rotund-bvh`, which include
//! this file by its path.
#![allow(dead_code, reason = "each of them uses a part")]

use glam::{DVec3, Vec3};

/// splitmix64: the same numbers on every machine.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// A number in `0.0..1.0`.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * 2_f32.powi(-24)
    }

    /// An index below `count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// A unit vector, distributed uniformly.
    pub(crate) fn direction(&mut self) -> DVec3 {
        let (z, angle) = (self.range(-1.0, 1.0), self.range(0.0, core::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    }

    /// A unit vector perpendicular to `axis`.
    pub(crate) fn across(&mut self, axis: DVec3) -> DVec3 {
        loop {
            let v = self.direction();
            let v = v - axis * (v.dot(axis) / axis.length_squared());
            if v.length() > 0.1 {
                return v.normalize();
            }
        }
    }

    /// A number in `-1.0..=1.0`.
    pub(crate) fn signed(&mut self) -> f32 {
        self.range(-1.0, 1.0) as f32
    }

    /// A point of the cube from -1 to 1.
    pub(crate) fn in_cube(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    /// A power of ten with an exponent from `-decades` to `decades`.
    pub(crate) fn power(&mut self, decades: f32) -> f32 {
        10_f32.powf(decades * self.signed())
    }
}
