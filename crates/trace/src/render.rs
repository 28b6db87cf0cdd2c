//! All pixels of a picture, over all threads.

use crate::{Film, Sequence};
use std::time::Duration;

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Pixels in a row; see [`picture_size`].
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Segments of the longest path, counted from the camera: 1 shows what shines, 2 direct light.
    pub bounces: u32,
    /// Another seed is another, independent picture of the same scene.
    pub seed: u64,
    /// Where random numbers come from.
    pub sequence: Sequence,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            width: 720,
            height: 405,
            samples: 64,
            bounces: 8,
            seed: 0,
            sequence: Sequence::Sobol,
        }
    }
}

/// How far a render has come; it is told after each pass over all pixels.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// What there is: `film.samples` of the samples are done.
    pub film: &'a Film,
    /// Rays traced in this run, shadow rays included.
    pub rays: u64,
    /// Since this run began.
    pub elapsed: Duration,
}

/// Width and height of a picture whose longer side has `resolution` pixels: the other is rounded,
/// but at least 1.
#[must_use]
pub fn picture_size(aspect: f32, resolution: u32) -> (u32, u32) {
    let other = |factor: f32| ((resolution as f32 * factor).round() as u32).max(1);
    if aspect >= 1.0 { (resolution, other(1.0 / aspect)) } else { (other(aspect), resolution) }
}
