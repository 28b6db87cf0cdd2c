//! What is to be seen of a scene, without light and so without noise.
//!
//! Sixteen rays go through each pixel, always the same. What they meet is known to the last bit, so
//! that a change of one ray is a fault and not chance: where [`crate::verdict`] says how sure it is,
//! this says yes or no. Whatever moves the mean of a pixel by two of the steps in which it is stored is
//! found: one ray more or less, one normal that is flipped, a texture that is shifted by 1/256.
//!
//! | check | mean over the rays of a pixel | finds |
//! | --- | --- | --- |
//! | `coverage` | 1 where a surface is met, else 0 | a leak, a shape too many |
//! | `crossings` | surfaces met along the whole ray | leaks and doubles behind the first, self-hits |
//! | `shadow` | 1 where a ray off the surface, to a fixed direction, gets away | leaks of shadow rays |
//! | `depth` | `t` of the first surface | another root, another place |
//! | `normal` | shading normal there | a flipped or bent normal |
//! | `texcoord` | texture coordinates there | a shift |
//! | `colour` | colour of the material there | another material, texel or vertex colour |

use crate::verdict::{Check, Finding};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use rotund_scene::{Camera, Scene, Trees};
use std::f32::consts::TAU;

/// Rays through a pixel, in a square of so many by so many.
const SIDE: usize = 4;
const RAYS: usize = SIDE * SIDE;
/// Who crosses more surfaces is stuck on one.
const MOST_CROSSINGS: u32 = 64;

/// One number for each pixel.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    /// In the file of a reference.
    pub name: &'static str,
    check: Check,
    /// Values are stored in multiples of this, or with eleven bits if that is coarser.
    step: f64,
    /// How many steps apart two values may be: other libraries of mathematics round otherwise.
    steps: f64,
}

/// A sixteenth is exact, and one ray makes one.
const COUNT: f64 = 1.0 / RAYS as f64;
/// Well above what rounding does to colours, normals and texture coordinates of a picture of this
/// size, and well below what one ray of a pixel does to their mean.
const FINE: f64 = 1.0 / 512.0;
const ELEVEN_BITS: f64 = 1.0 / 2048.0;

/// What is stored, in the order of [`Probe::values`].
pub const CHANNELS: [Channel; 12] = {
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
    /// The distance of stored values about `value`. Eleven bits where values are large: a whole
    /// texture repeated a thousand times has no finer texture coordinates than that.
    fn step(&self, value: f64) -> f64 {
        let relative = if self.step == COUNT { 0.0 } else { value.abs() * ELEVEN_BITS };
        self.step.max(relative.log2().floor().exp2())
    }

    /// The stored value nearest to `value`.
    pub fn round(&self, value: f64) -> f32 {
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

/// What one ray meets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probe {
    pub crossings: u32,
    pub escapes: bool,
    pub depth: f32,
    pub normal: Vec3,
    pub texcoord: Vec2,
    pub color: Vec3,
}

impl Probe {
    /// Follows a ray of the camera through all surfaces. `index` tells the rays of a pixel apart.
    pub fn new(
        scene: &Scene,
        trees: &Trees,
        camera: &Camera,
        image_uv: Vec2,
        index: usize,
    ) -> Self {
        let mut ray = camera.ray(image_uv, Vec2::ZERO);
        let Some(first) = trees.closest(scene, &ray) else { return Self::default() };
        let mut crossings = 1;
        let mut hit = first;
        while crossings < MOST_CROSSINGS {
            ray.origin = hit.spawn(ray.direction).origin;
            let Some(next) = trees.closest(scene, &ray) else { break };
            (hit, crossings) = (next, crossings + 1);
        }
        let away = {
            let direction = fixed_direction(index);
            let side = first.normal.dot(direction) * first.normal.dot(ray.direction);
            if side > 0.0 { -direction } else { direction }
        };
        let material = scene.eval_material(first.instance, first.element, first.uv);
        Self {
            crossings,
            escapes: !trees.any(scene, &first.spawn(away)),
            depth: first.t,
            normal: scene.shading_normal(&first, -ray.direction),
            texcoord: scene.eval_texcoord(first.instance, first.element, first.uv),
            color: material.color,
        }
    }

    fn values(&self) -> [f32; CHANNELS.len()] {
        let Self { crossings, escapes, depth, normal: n, texcoord: uv, color: c } = *self;
        let coverage = f32::from(u8::from(crossings > 0));
        let shadow = f32::from(u8::from(escapes));
        [coverage, crossings as f32, shadow, depth, n.x, n.y, n.z, uv.x, uv.y, c.x, c.y, c.z]
    }
}

/// One of [`RAYS`] directions spread over the sphere (R. Swinbank, R. Purser, "Fibonacci grids",
/// Quarterly Journal of the Royal Meteorological Society 132, 2006).
fn fixed_direction(index: usize) -> Vec3 {
    const GOLDEN_RATIO: f32 = 1.618_034;
    let z = 1.0 - (2 * index + 1) as f32 / RAYS as f32;
    let (sin, cos) = (TAU * (index as f32 / GOLDEN_RATIO).fract()).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}

/// The means over the rays of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// One plane for each of [`CHANNELS`], row by row, rounded as they are stored.
    pub planes: Vec<Vec<f32>>,
}

impl Surface {
    /// Shoots all rays of a picture; `probe` gets a point of the picture, `0.0..=1.0`, and which of
    /// the rays of its pixel it is.
    pub fn measure(
        width: usize,
        height: usize,
        probe: impl Fn(Vec2, usize) -> Probe + Sync,
    ) -> Self {
        let size = Vec2::new(width as f32, height as f32);
        let pixel = |i: usize| {
            let corner = Vec2::new((i % width) as f32, (i / width) as f32);
            let mut sums = [0.0; CHANNELS.len()];
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

    /// One finding for each check that fails: how many pixels differ, and the first of them.
    ///
    /// # Panics
    ///
    /// If the pictures differ in size.
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
                "pixel ({x}, {y}): {part} is {} instead of {}, without any noise; so in {count} pixels",
                ours[first], theirs[first]
            );
            // One finding for the three coordinates of a normal: the one with the most pixels.
            match findings.iter_mut().find(|(finding, _)| finding.check == channel.check) {
                Some((_, most)) if *most >= count => {}
                Some(found) => *found = (Finding { check: channel.check, text }, count),
                None => findings.push((Finding { check: channel.check, text }, count)),
            }
        }
        findings.into_iter().map(|(finding, _)| finding).collect()
    }

    /// Whether anything differs in a pixel.
    pub fn differs_at(&self, expected: &Self, i: usize) -> bool {
        let planes = self.planes.iter().zip(&expected.planes);
        CHANNELS.iter().zip(planes).any(|(channel, (a, b))| channel.differ(a[i], b[i]))
    }

    /// The mean shading normal of a pixel; zero where there is no surface.
    pub fn normal(&self, i: usize) -> Vec3 {
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

    #[test]
    fn the_fixed_directions_have_unit_length_and_go_everywhere() {
        let directions: Vec<Vec3> = (0..RAYS).map(fixed_direction).collect();
        let sum: Vec3 = directions.iter().sum();
        assert!(directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-6));
        assert!(sum.length() < 0.1 * RAYS as f32, "{sum}");
    }
}
