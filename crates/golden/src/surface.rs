//! The surfaces of a scene as its camera sees them, without light and so without noise.
//!
//! Sixteen rays go through each pixel, always the same ones. Their results have no random part, so
//! any change is a fault and the comparison is a yes or no: light is compared by the statistical
//! tests of [`crate::verdict`]. The check detects anything that moves the mean of a pixel by two of
//! the steps in which it is stored: one ray more or less, a flipped normal, a texture shifted by
//! 1/256.
//!
//! | check | mean over the rays of a pixel | finds |
//! | --- | --- | --- |
//! | `coverage` | 1 where a surface is met, else 0 | a leak, a superfluous shape |
//! | `crossings` | number of surfaces along the whole ray | leaks and double hits farther back |
//! | `shadow` | 1 where a second ray, in a fixed direction, is free | leaks of shadow rays |
//! | `depth` | `t` of the first surface | a wrong root, a moved shape |
//! | `normal` | shading normal there | a flipped or bent normal |
//! | `texcoord` | texture coordinates there | a shift |
//! | `colour` | material colour there | a wrong material, texel or vertex colour |

use crate::check::{Check, Finding};
use crate::probe::{Probe, RAYS, SIDE, VALUES};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// One number for each pixel, and how it is stored and compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Channel {
    /// Name of the channel in the file of a reference.
    pub(crate) name: &'static str,
    check: Check,
    /// Values are stored as multiples of this, or with eleven bits if that is coarser.
    step: f64,
    /// Tolerance in steps: mathematics libraries differ in their rounding.
    steps: f64,
}

/// Step of channels that count rays: one ray of sixteen, which is exact in binary.
const COUNT: f64 = 1.0 / RAYS as f64;
/// Step of the other channels: well above the rounding errors of colours, normals and texture
/// coordinates in a picture of this size, and well below the effect of one ray on the mean of a
/// pixel.
const FINE: f64 = 1.0 / 512.0;
const ELEVEN_BITS: f64 = 1.0 / 2048.0;

/// The channels, in the order of [`Probe::values`].
pub(crate) const CHANNELS: [Channel; VALUES] = {
    const fn channel(name: &'static str, check: Check, step: f64, steps: f64) -> Channel {
        Channel { name, check, step, steps }
    }
    [
        channel("surface.coverage", Check::Coverage, COUNT, 0.5),
        channel("surface.crossings", Check::Crossings, COUNT, 0.5),
        channel("surface.shadow", Check::Shadow, COUNT, 0.5),
        channel("surface.depth", Check::Depth, FINE, 1.0),
        channel("surface.normal.X", Check::Normal, FINE, 1.0),
        channel("surface.normal.Y", Check::Normal, FINE, 1.0),
        channel("surface.normal.Z", Check::Normal, FINE, 1.0),
        channel("surface.texcoord.U", Check::Texcoord, FINE, 1.0),
        channel("surface.texcoord.V", Check::Texcoord, FINE, 1.0),
        channel("surface.color.R", Check::Color, FINE, 1.0),
        channel("surface.color.G", Check::Color, FINE, 1.0),
        channel("surface.color.B", Check::Color, FINE, 1.0),
    ]
};

impl Channel {
    /// Returns the distance of stored values near `value`. Large values have eleven bits: the
    /// texture coordinates of a texture that is repeated a thousand times are no finer than that.
    fn step(&self, value: f64) -> f64 {
        let relative = if self.step == COUNT { 0.0 } else { value.abs() * ELEVEN_BITS };
        self.step.max(relative.log2().floor().exp2())
    }

    /// Returns the stored value nearest to `value`.
    fn round(&self, value: f64) -> f32 {
        let step = self.step(value);
        ((value / step).round() * step) as f32
    }

    fn differ(&self, actual: f32, expected: f32) -> bool {
        let (actual, expected) = (f64::from(actual), f64::from(expected));
        let allowed = self.steps * self.step(actual.abs().max(expected.abs()));
        let difference = (actual - expected).abs();
        difference.is_nan() || difference > allowed * 1.001
    }
}

/// Geometry and surface buffers (AOVs), which need no light transport: means over the rays of each
/// pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Number of columns.
    pub(crate) width: usize,
    /// Number of rows.
    pub(crate) height: usize,
    /// One plane for each of [`CHANNELS`], row by row, rounded as they are stored.
    pub(crate) planes: Vec<Vec<f32>>,
}

impl Surface {
    /// Shoots all rays of a picture. `probe` gets a point of the picture, in `0.0..=1.0`, and the
    /// index of the ray in its pixel.
    pub(crate) fn measure(
        width: usize,
        height: usize,
        probe: impl Fn(Vec2, usize) -> Probe + Sync,
    ) -> Self {
        let size = Vec2::new(width as f32, height as f32);
        let pixel = |i: usize| {
            let corner = Vec2::new((i % width) as f32, (i / width) as f32);
            let mut sums = [0.0; VALUES];
            for ray in 0..RAYS {
                let within = Vec2::new((ray % SIDE) as f32, (ray / SIDE) as f32) + 0.5;
                let found = probe((corner + within / SIDE as f32) / size, ray);
                for (sum, value) in sums.iter_mut().zip(found.values()) {
                    *sum += f64::from(value);
                }
            }
            sums
        };
        let pixels: Vec<_> = (0..width * height).into_par_iter().map(pixel).collect();
        let plane = |(index, channel): (usize, &Channel)| {
            pixels.iter().map(|sums| channel.round(sums[index] / RAYS as f64)).collect()
        };
        Self { width, height, planes: CHANNELS.iter().enumerate().map(plane).collect() }
    }

    /// Returns one finding for each check that fails: how many pixels differ, and the first of
    /// them.
    ///
    /// # Panics
    ///
    /// If the pictures differ in size.
    #[must_use]
    pub fn compare(&self, expected: &Self) -> Vec<Finding> {
        let size = (self.width, self.height);
        assert_eq!(size, (expected.width, expected.height), "surfaces of the same size");
        let mut findings: Vec<(Finding, usize)> = Vec::new();
        for (channel, (ours, theirs)) in
            CHANNELS.iter().zip(self.planes.iter().zip(&expected.planes))
        {
            let differs = |&i: &usize| channel.differ(ours[i], theirs[i]);
            let mut wrong = (0..ours.len()).filter(differs);
            let Some(first) = wrong.next() else { continue };
            let count = 1 + wrong.count();
            let (x, y) = (first % self.width, first / self.width);
            let part = channel.name.rsplit('.').next().unwrap_or_default();
            let text = format!(
                "pixel ({x}, {y}): {part} is {} instead of {}, without any noise; so in {count} \
                 pixels",
                ours[first], theirs[first]
            );
            // The coordinates of a normal share a finding: that of the one that differs in most
            // pixels.
            match findings.iter_mut().find(|(finding, _)| finding.check == channel.check) {
                Some((_, most)) if *most >= count => {}
                Some(found) => *found = (Finding { check: channel.check, text }, count),
                None => findings.push((Finding { check: channel.check, text }, count)),
            }
        }
        findings.into_iter().map(|(finding, _)| finding).collect()
    }

    /// Returns true if any channel differs in a pixel.
    pub(crate) fn differs_at(&self, expected: &Self, i: usize) -> bool {
        let planes = self.planes.iter().zip(&expected.planes);
        CHANNELS.iter().zip(planes).any(|(channel, (a, b))| channel.differ(a[i], b[i]))
    }

    /// Returns the mean shading normal of a pixel; zero where there is no surface.
    pub(crate) fn normal(&self, i: usize) -> Vec3 {
        Vec3::new(self.planes[4][i], self.planes[5][i], self.planes[6][i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_stores_what_it_tells_apart() {
        let [coverage, _, _, depth, ..] = CHANNELS;
        assert!(coverage.differ(1.0, 0.9375) && !coverage.differ(1.0, 1.0));
        assert!(coverage.differ(f32::NAN, 1.0) && coverage.differ(1.0, f32::NAN));
        for value in [0.0, 0.3, -7.77, 1234.5] {
            let stored = depth.round(value);
            assert!(!depth.differ(stored, value as f32), "{value} is stored as {stored}");
            assert!(depth.differ(stored, (value * 1.004 + 0.01) as f32), "{value}");
        }
    }
}
