//! The statistical comparison of a picture with its reference.
//!
//! | check | question | finds |
//! | --- | --- | --- |
//! | `rejected` | is every sample finite and not negative | NaN that a film would count as black |
//! | `pixel` | Student's t for each pixel and channel | a leak of one pixel |
//! | `block` | the same for the mean of each 8 x 8 block | a wrong normal, a shifted texture |
//! | `energy` | the same for the mean of the picture | a loss of one percent of the light |
//! | `flip` | is the visible difference within that of the noise | visible changes of large areas |
//!
//! The three t-tests together fail by chance in at most one of a thousand runs over a whole set of
//! pictures: see [`FALSE_ALARMS`](crate::FALSE_ALARMS). [`crate::surface`] compares what has no
//! noise.

use crate::check::{Check, Finding};
use crate::moments::Moments;
use crate::significance::{Comparison, compare, level, p_value};
use rotund_image::{CompareError, Difference};
use rotund_trace::{Sampler, Sequence};
use std::f32::consts::TAU;
use std::fmt;

/// Side of a block in pixels.
const BLOCK: usize = 8;

/// FLIP may be this many times that of the noise alone. A mean over thousands of pixels scatters by
/// a few percent only; the rest allows for noise that is not normally distributed.
const FLIP_FACTOR: f64 = 1.5;
/// An invisible FLIP error, allowed even without noise.
const FLIP_MARGIN: f64 = 0.002;
/// Upper bound on the FLIP error, whatever the noise: no picture may be so noisy that it hides a
/// visible difference.
pub(crate) const FLIP_CEILING: f64 = 0.06;

/// Results of all checks of one picture.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The checks that failed; empty if the picture agrees with its reference.
    pub findings: Vec<Finding>,
    /// Relative difference of the means of the two pictures, in the channel with the smallest
    /// relative error.
    pub energy: f64,
    /// The same in standard errors.
    pub energy_t: f64,
    /// The smallest p-value of all t-tests, times the number of tests of its kind. A third of
    /// [`FALSE_ALARMS`](crate::FALSE_ALARMS) is the limit.
    pub smallest_p: f64,
    /// Mean FLIP error.
    pub flip: f64,
    /// Largest mean FLIP error that passes.
    pub flip_limit: f64,
    /// Metrics and maps of the difference of the mean pictures.
    pub difference: Difference,
}

/// Compares `actual` with `reference`, as one of `pictures` pictures of a run.
pub(crate) fn judge(
    actual: &Moments,
    reference: &Moments,
    pictures: usize,
) -> Result<Verdict, CompareError> {
    let difference = Difference::between(&actual.picture(), &reference.picture())?;
    let flip = difference.metrics.flip_mean;
    let flip_limit = flip_of_noise(actual, reference)?.min(FLIP_CEILING);
    let mut findings = Vec::new();
    if actual.rejected > 0 {
        let text = format!("{} samples were negative, infinite or not a number", actual.rejected);
        findings.push(Finding { check: Check::Rejected, text });
    }

    let (width, height) = (actual.width, actual.height);
    let mut smallest_p: f64 = 1.0;
    let regions = [
        (Check::Pixel, pixels(width, height)),
        (Check::Block, blocks(width, height)),
        (Check::Energy, vec![Region { x: 0, y: 0, width, height }]),
    ];
    for (check, regions) in regions {
        let tests = 3 * regions.len() * pictures;
        let mut failed = Vec::new();
        for region in &regions {
            for channel in 0..3 {
                let found = compare(actual, reference, region.indices(width), channel);
                // Never significant, so the costly p-value of most pixels is not needed.
                if found.t < 3.0 {
                    continue;
                }
                let p = p_value(found.t, found.freedom);
                smallest_p = smallest_p.min(p * tests as f64);
                if p < level(tests) {
                    failed.push((p, *region, channel, found));
                }
            }
        }
        findings.extend(describe(check, failed));
    }
    if flip > flip_limit {
        let text = format!("mean FLIP error {flip:.4}, at most {flip_limit:.4} allowed");
        findings.push(Finding { check: Check::Flip, text });
    }
    let energy = surest_energy(actual, reference);
    Ok(Verdict {
        findings,
        energy: energy.difference / energy.expected,
        energy_t: energy.t,
        smallest_p,
        flip,
        flip_limit,
        difference,
    })
}

/// Compares whole pictures in the channel whose relative error is the smallest.
pub(crate) fn surest_energy(actual: &Moments, reference: &Moments) -> Comparison {
    (0..3)
        .map(|channel| compare(actual, reference, 0..actual.mean.len(), channel))
        .min_by(|a, b| (a.error / a.expected).total_cmp(&(b.error / b.expected)))
        .expect("a picture has three channels")
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
struct Region {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

impl Region {
    fn indices(self, stride: usize) -> impl Iterator<Item = usize> {
        (self.y..self.y + self.height)
            .flat_map(move |y| (self.x..self.x + self.width).map(move |x| y * stride + x))
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

fn pixels(width: usize, height: usize) -> Vec<Region> {
    let pixel = |i| Region { x: i % width, y: i / width, width: 1, height: 1 };
    (0..width * height).map(pixel).collect()
}

fn blocks(width: usize, height: usize) -> Vec<Region> {
    let mut blocks = Vec::new();
    for y in (0..height).step_by(BLOCK) {
        for x in (0..width).step_by(BLOCK) {
            blocks.push(Region {
                x,
                y,
                width: BLOCK.min(width - x),
                height: BLOCK.min(height - y),
            });
        }
    }
    blocks
}

/// Returns one finding that counts the regions that failed and describes the worst.
fn describe(check: Check, failed: Vec<(f64, Region, usize, Comparison)>) -> Option<Finding> {
    let worst = failed.iter().min_by(|a, b| a.0.total_cmp(&b.0).then(b.3.t.total_cmp(&a.3.t)))?;
    let &(p, region, channel, Comparison { expected, difference, t, .. }) = worst;
    let channel = ["red", "green", "blue"][channel];
    let place = match check {
        Check::Pixel => format!("pixel {region}"),
        Check::Block => format!("the block at {region}"),
        _ => "the whole picture".to_owned(),
    };
    let values = format!("{:.4} instead of {expected:.4}", expected + difference);
    let sureness = if t.is_finite() {
        // The model of the noise does not hold for smaller probabilities.
        format!("{t:.1} standard errors, p = {:.0e}", p.max(1e-30))
    } else {
        "without any noise".to_owned()
    };
    let others = match failed.len() {
        1 => String::new(),
        count => format!("; {count} such tests failed"),
    };
    let percent = 100.0 * difference / expected;
    let percent = if percent.is_finite() { format!(" ({percent:+.1} %)") } else { String::new() };
    let text = format!("{place}: {channel} is {values}{percent}, {sureness}{others}");
    Some(Finding { check, text })
}

/// Returns the limit of the mean FLIP error: that of noise alone, with some margin.
///
/// It is measured: the reference is compared with a copy of itself that has noise of the size of
/// both pictures.
pub(crate) fn flip_of_noise(actual: &Moments, reference: &Moments) -> Result<f64, CompareError> {
    let clean = reference.picture();
    let mut noisy = clean.clone();
    for (i, pixel) in noisy.pixels.iter_mut().enumerate() {
        let normal = normal(i as u32);
        // Alpha is the fourth channel.
        for (channel, value) in pixel.iter_mut().take(3).enumerate() {
            let error = compare(actual, reference, [i].into_iter(), channel).error;
            // The same number for all channels: noise changes brightness more than hue.
            *value = (*value + normal * error as f32).max(0.0);
        }
    }
    let noise = Difference::between(&noisy, &clean)?.metrics.flip_mean;
    Ok(FLIP_FACTOR * noise + FLIP_MARGIN)
}

/// Returns a standard normal number for each index (G. Box, M. Muller, "A note on the generation of
/// random normal deviates", 1958).
fn normal(index: u32) -> f32 {
    let [u, v, ..] = Sampler::new(Sequence::Independent, 0, index, 0, 0).set(0);
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}
