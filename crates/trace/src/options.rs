//! The options of a render.

use crate::{RenderError, Sequence, Shard, View};

/// The options of a render. Scene, camera and options together determine every bit of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Pixels in a row.
    ///
    /// Width over height should be the aspect of the camera; otherwise the picture is stretched.
    /// [`rotund_scene::Camera::resolution`] gives such a size. The default, 720 x 480, is that of
    /// the default camera.
    pub width: u32,
    /// Number of rows; see [`Self::width`].
    pub height: u32,
    /// Samples per pixel, over all shards.
    pub samples: u32,
    /// Largest number of segments of a path, counted from the camera: 1 shows emission only, 2 adds
    /// direct illumination.
    pub bounces: u32,
    /// Seed of the random numbers: pictures of different seeds are statistically independent.
    pub seed: u64,
    /// Generator of the random numbers.
    pub sequence: Sequence,
    /// Subset of the samples to render.
    pub shard: Shard,
    /// Quantity that the picture shows.
    pub view: View,
    /// Limit to which samples with a larger channel are scaled down. Clamping removes energy, so
    /// there is no limit by default; [`crate::Film::clamped`] counts the samples that it changed.
    /// What a path from a light adds to a pixel is spread over eight samples, and each is limited
    /// alike.
    pub clamp: Option<f32>,
    /// Hides the environment from the camera: a camera ray that reaches it, possibly straight
    /// through surfaces of partial opacity and clouds, adds no radiance and alpha 0. The
    /// environment still illuminates the scene, and reflections and refractions show it.
    pub transparent: bool,
    /// Moves the origin to the camera while rendering [`View::Path`], if the origin is so far away
    /// that single-precision positions lose digits: at 10 km the spacing of `f32` is about 1 mm.
    /// Other views show positions of the scene, so they never move it.
    pub recenter: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            width: 720,
            height: 480,
            samples: 64,
            bounces: 8,
            seed: 0,
            sequence: Sequence::Sobol,
            shard: Shard::default(),
            view: View::Path,
            clamp: None,
            transparent: false,
            recenter: true,
        }
    }
}

impl Options {
    /// Checks that each option has a meaning by itself.
    ///
    /// # Errors
    ///
    /// If the size, `samples` or `bounces` is zero, the shard is out of range, or `clamp` is not a
    /// positive number.
    pub fn validate(&self) -> Result<(), RenderError> {
        let Self { width, height, samples, bounces, shard, clamp, .. } = *self;
        for (field, value) in
            [("width", width), ("height", height), ("samples", samples), ("bounces", bounces)]
        {
            if value == 0 {
                return Err(RenderError::Zero { field });
            }
        }
        if shard.index >= shard.count {
            return Err(RenderError::Shard { index: shard.index, count: shard.count });
        }
        match clamp {
            Some(clamp) if clamp.is_nan() || clamp <= 0.0 => Err(RenderError::Clamp { clamp }),
            _ => Ok(()),
        }
    }
}
