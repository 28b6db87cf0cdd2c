//! What fills the solids that a path is in.

use glam::Vec3;

/// How many solids a path may be in at once; the innermost beyond that count as empty.
const DEPTH: usize = 8;

/// The solids around a path, innermost last.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Media {
    /// Instance, and extinction per meter.
    solids: [(u32, Vec3); DEPTH],
    depth: usize,
}

impl Media {
    /// A path goes into an instance.
    pub(crate) fn enter(&mut self, instance: u32, density: Vec3) {
        if self.depth < DEPTH {
            self.solids[self.depth] = (instance, density);
            self.depth += 1;
        }
    }

    /// A path comes out of an instance. Solids that overlap may be left in any order; one that was
    /// never entered, because the camera is inside, changes nothing.
    pub(crate) fn leave(&mut self, instance: u32) {
        let inside = &self.solids[..self.depth];
        if let Some(place) = inside.iter().rposition(|&(solid, _)| solid == instance) {
            self.solids.copy_within(place + 1..self.depth, place);
            self.depth -= 1;
        }
    }

    /// What remains of the light over a distance, by Beer and Lambert.
    pub(crate) fn transmittance(&self, distance: f32) -> Vec3 {
        match self.solids[..self.depth].last() {
            Some((_, density)) if *density != Vec3::ZERO => (-distance * *density).exp(),
            _ => Vec3::ONE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_innermost_solid_absorbs() {
        let [a, b] = [Vec3::new(1.0, 0.0, 2.0), Vec3::splat(3.0)];
        let mut media = Media::default();
        assert_eq!(media.transmittance(5.0), Vec3::ONE);
        media.enter(7, a);
        assert!(media.transmittance(2.0).abs_diff_eq((-2.0 * a).exp(), 1e-7));
        media.enter(8, b);
        assert!(media.transmittance(2.0).abs_diff_eq((-2.0 * b).exp(), 1e-7));
        // The outer one ends first: they overlap.
        media.leave(7);
        assert!(media.transmittance(2.0).abs_diff_eq((-2.0 * b).exp(), 1e-7));
        media.leave(7);
        media.leave(8);
        assert_eq!(media.transmittance(5.0), Vec3::ONE);
    }

    #[test]
    fn more_solids_than_fit_change_nothing() {
        let mut media = Media::default();
        for instance in 0..20 {
            media.enter(instance, Vec3::ONE);
        }
        for instance in (0..20).rev() {
            media.leave(instance);
        }
        assert_eq!(media.transmittance(1.0), Vec3::ONE);
    }
}
