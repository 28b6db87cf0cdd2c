//! Participating media inside of solids and clouds, and the stack of those around a path.

use glam::Vec3;
use rotund_scene::{MaterialKind, MaterialPoint, SceneHit};

/// Largest number of nested solids around a path; deeper ones count as empty.
const DEPTH: usize = 8;

/// A homogeneous medium inside of a solid or cloud.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Medium {
    /// Extinction coefficient per meter.
    pub(crate) extinction: Vec3,
    /// Single-scattering albedo: the fraction of the extinction that is scattering.
    pub(crate) albedo: Vec3,
    /// Mean cosine of the scattering angle.
    pub(crate) anisotropy: f32,
    /// The boundary refracts light.
    pub(crate) walled: bool,
}

/// What is known of a path that crosses the surface of a solid in the other direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WayBack {
    /// It was inside of the same media on all segments so far.
    SameMedia,
    /// The path leaves a solid that it never entered: it began inside.
    Unknown,
    /// It was inside of other media: the solid overlaps another, of which the last to be entered
    /// counts, or has another color here than where it was entered.
    OtherMedia,
}

/// The stack of solids around a path, innermost last.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Media {
    /// Index of the instance, and its medium.
    solids: [(u32, Medium); DEPTH],
    depth: usize,
}

impl Medium {
    /// Returns the medium behind a surface of this material.
    pub(crate) fn new(material: &MaterialPoint) -> Self {
        Self {
            extinction: material.extinction,
            albedo: material.albedo,
            anisotropy: material.anisotropy,
            walled: material.kind == MaterialKind::Refractive,
        }
    }

    /// Returns true if light passes without loss.
    pub(crate) fn is_clear(&self) -> bool {
        self.extinction == Vec3::ZERO
    }

    /// Returns true if both have the same effect on light.
    fn is_like(&self, other: &Self) -> bool {
        self == other || (self.is_clear() && other.is_clear())
    }

    /// Returns true if light is scattered inside.
    pub(crate) fn scatters(&self) -> bool {
        self.albedo != Vec3::ZERO
    }

    /// Returns the transmittance over a length, by the Beer-Lambert law.
    fn transmittance(&self, length: f32) -> Vec3 {
        (-length * self.extinction).exp()
    }

    /// Samples the distance to the next scattering event, infinite where there is none.
    ///
    /// `channel` picks the channel whose extinction is sampled, `u` the distance; the density is
    /// the mean over the three channels.
    pub(crate) fn sample(&self, channel: f32, u: f32) -> f32 {
        let drawn = self.extinction[((channel * 3.0) as usize).min(2)];
        if drawn > 0.0 { -(-u).ln_1p() / drawn } else { f32::INFINITY }
    }

    /// Returns the factor of the throughput of a path that scatters after a sampled distance.
    pub(crate) fn scattered(&self, distance: f32) -> Vec3 {
        let remains = self.transmittance(distance);
        self.albedo * self.extinction * remains / mean(self.extinction * remains)
    }

    /// Returns the factor of the throughput of a path that passes `length`, since the sampled
    /// distance is not less.
    pub(crate) fn passed(&self, length: f32) -> Vec3 {
        let remains = self.transmittance(length);
        // The transmittance of every channel may underflow: then nothing is transmitted.
        let probability = mean(remains);
        if probability > 0.0 { remains / probability } else { Vec3::ZERO }
    }
}

/// Returns the mean over the three channels.
fn mean(channels: Vec3) -> f32 {
    channels.element_sum() / 3.0
}

impl Media {
    /// Pushes the medium of an instance that a path enters.
    fn enter(&mut self, instance: u32, medium: Medium) {
        if self.depth < DEPTH {
            self.solids[self.depth] = (instance, medium);
            self.depth += 1;
        }
    }

    /// Removes the medium of an instance that a path leaves. Solids that overlap may be left in any
    /// order; leaving one that was never entered, because the camera is inside, changes nothing.
    fn leave(&mut self, instance: u32) {
        let inside = &self.solids[..self.depth];
        if let Some(place) = inside.iter().rposition(|&(solid, _)| solid == instance) {
            self.solids.copy_within(place + 1..self.depth, place);
            self.depth -= 1;
        }
    }

    /// Enters or leaves the instance of `hit`, by the side of the surface that `direction` points
    /// to.
    pub(crate) fn cross(&mut self, hit: &SceneHit, direction: Vec3, medium: Medium) {
        if hit.normal.dot(direction) < 0.0 {
            self.enter(hit.instance, medium);
        } else {
            self.leave(hit.instance);
        }
    }

    /// Does as [`Self::cross`] does, and returns what is known of the way back.
    pub(crate) fn cross_known(
        &mut self,
        hit: &SceneHit,
        direction: Vec3,
        medium: Medium,
    ) -> WayBack {
        let inside = &self.solids[..self.depth];
        let leaves = hit.normal.dot(direction) >= 0.0;
        let entered = inside.iter().rposition(|&(solid, _)| solid == hit.instance);
        let way_back = match entered {
            _ if !leaves => WayBack::SameMedia,
            None => WayBack::Unknown,
            // A path that comes back enters this solid here, and after those that this one entered
            // later and is still inside of.
            Some(place) if inside[place..].iter().all(|(_, other)| other.is_like(&medium)) => {
                WayBack::SameMedia
            }
            Some(_) => WayBack::OtherMedia,
        };
        self.cross(hit, direction, medium);
        way_back
    }

    /// Returns true if the path is inside of no solid.
    pub(crate) fn is_outside(&self) -> bool {
        self.depth == 0
    }

    /// Returns true if light passes all solids around the path without loss, as far as known.
    pub(crate) fn is_clear(&self) -> bool {
        self.depth < DEPTH && self.solids[..self.depth].iter().all(|(_, medium)| medium.is_clear())
    }

    /// Returns the medium around the path, unless it is empty.
    pub(crate) fn innermost(&self) -> Option<&Medium> {
        let (_, medium) = self.solids[..self.depth].last()?;
        (!medium.is_clear()).then_some(medium)
    }

    /// Returns the transmittance over a distance, by the Beer-Lambert law.
    pub(crate) fn transmittance(&self, distance: f32) -> Vec3 {
        self.innermost().map_or(Vec3::ONE, |medium| medium.transmittance(distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn the_innermost_solid_absorbs() {
        let of = |extinction| Medium { extinction, ..Medium::default() };
        let [a, b] = [Vec3::new(1.0, 0.0, 2.0), Vec3::splat(3.0)];
        let mut media = Media::default();
        assert_eq!(media.transmittance(5.0), Vec3::ONE);
        media.enter(7, of(a));
        assert!(media.transmittance(2.0).abs_diff_eq((-2.0 * a).exp(), 1e-7));
        media.enter(8, of(b));
        assert!(media.transmittance(2.0).abs_diff_eq((-2.0 * b).exp(), 1e-7));
        // The outer solid ends first: the two overlap.
        media.leave(7);
        assert!(media.transmittance(2.0).abs_diff_eq((-2.0 * b).exp(), 1e-7));
        media.leave(7);
        media.leave(8);
        assert_eq!(media.transmittance(5.0), Vec3::ONE);
    }

    /// Crosses the walls of solids, each with its extinction, and returns the last way back.
    fn walk(walls: &[(char, f32)]) -> WayBack {
        let (mut media, mut last) = (Media::default(), WayBack::SameMedia);
        for &(wall, extinction) in walls {
            let hit = SceneHit {
                instance: u32::from(wall.to_ascii_lowercase()),
                element: 0,
                uv: Vec2::ZERO,
                t: 1.0,
                position: Vec3::ZERO,
                normal: if wall.is_uppercase() { Vec3::NEG_Z } else { Vec3::Z },
                error: 0.0,
            };
            let extinction = Vec3::splat(extinction);
            last = media.cross_known(&hit, Vec3::Z, Medium { extinction, ..Medium::default() });
        }
        last
    }

    /// Capital letters are walls that a path enters by, small ones those that it leaves by.
    #[test]
    fn the_way_back_is_known_of_solids_that_are_nested_or_alike() {
        for (walls, expected) in [
            (&[('A', 1.0), ('a', 1.0)][..], WayBack::SameMedia),
            (&[('A', 1.0), ('B', 2.0), ('b', 2.0), ('a', 1.0)], WayBack::SameMedia),
            // B begins inside of A and ends outside: which one counts where they overlap depends on
            // the direction.
            (&[('A', 1.0), ('B', 2.0), ('a', 1.0)], WayBack::OtherMedia),
            (&[('A', 1.0), ('B', 1.0), ('a', 1.0)], WayBack::SameMedia),
            (&[('A', 0.0), ('B', 0.0), ('a', 0.0)], WayBack::SameMedia),
            (&[('A', 0.0), ('B', 1.0), ('a', 0.0)], WayBack::OtherMedia),
            // A texture gives the wall another color where the path leaves.
            (&[('A', 1.0), ('a', 2.0)], WayBack::OtherMedia),
            (&[('A', 1.0), ('A', 1.0), ('a', 1.0), ('a', 1.0)], WayBack::SameMedia),
            (&[('A', 1.0), ('b', 0.0)], WayBack::Unknown),
        ] {
            assert_eq!(walk(walls), expected, "{walls:?}");
        }
    }

    #[test]
    fn sampled_distances_scatter_and_transmit_what_beer_and_lambert_say() {
        let medium = Medium {
            extinction: Vec3::new(0.5, 2.0, 0.0),
            albedo: Vec3::new(0.3, 0.9, 0.5),
            anisotropy: 0.0,
            walled: false,
        };
        // The expected scattered light is the integral of albedo times extinction times
        // transmittance; that of the transmitted light is the transmittance over the limit of 1.5.
        let (mut scattered, mut arrived) = (Vec3::ZERO, Vec3::ZERO);
        const STEPS: u32 = 300;
        for i in 0..STEPS {
            for j in 0..STEPS {
                let place = |k: u32| (k as f32 + 0.5) / STEPS as f32;
                let distance = medium.sample(place(i), place(j));
                let (sum, factor) = if distance < 1.5 {
                    (&mut scattered, medium.scattered(distance))
                } else {
                    (&mut arrived, medium.passed(1.5))
                };
                *sum += factor / (STEPS * STEPS) as f32;
            }
        }
        let remains = (-1.5 * medium.extinction).exp();
        assert!(arrived.abs_diff_eq(remains, 1e-2), "{arrived} is not {remains}");
        let lost = medium.albedo * (1.0 - remains);
        assert!(scattered.abs_diff_eq(lost, 1e-2), "{scattered} is not {lost}");
        assert_eq!([0.0, 0.5].map(|u| medium.sample(0.9, u)), [f32::INFINITY; 2]);
    }

    #[test]
    fn more_solids_than_fit_change_nothing() {
        let mut media = Media::default();
        for instance in 0..20 {
            media.enter(instance, Medium { extinction: Vec3::ONE, ..Medium::default() });
        }
        for instance in (0..20).rev() {
            media.leave(instance);
        }
        assert_eq!(media.transmittance(1.0), Vec3::ONE);
    }
}
