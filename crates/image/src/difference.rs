//! How two pictures differ: numbers, and maps that show where.

use crate::convolve::Plane;
use crate::metrics::Metrics;
use crate::picture::Picture;
use crate::{color, flip, legend, maps, metrics};
use anyhow::{Result, bail};
use image::RgbImage;

/// Everything that is known about how a picture `a` differs from `b`.
#[derive(Clone, Debug)]
pub struct Difference {
    /// Single numbers.
    pub metrics: Metrics,
    /// Luminance of `a` minus that of `b`; 0 where one of them is not finite.
    pub signed: Plane,
    /// The FLIP error of each pixel.
    pub flip: Plane,
}

impl Difference {
    /// Compares two pictures.
    ///
    /// # Errors
    ///
    /// They must have the same size and at least one pixel that is finite in both.
    pub fn between(a: &Picture, b: &Picture) -> Result<Self> {
        let size = |picture: &Picture| format!("{} x {}", picture.width, picture.height);
        if (a.width, a.height) != (b.width, b.height) {
            bail!("the images differ in size: {} and {}", size(a), size(b));
        }
        let flip = flip::flip(a, b);
        let metrics = metrics::metrics(a, b, flip.mean())?;
        let difference = |(&a, &b)| {
            let difference = color::luminance(a) - color::luminance(b);
            if difference.is_finite() { difference } else { 0.0 }
        };
        let values = a.pixels.iter().zip(&b.pixels).map(difference).collect();
        Ok(Self { metrics, signed: Plane { values, ..flip.clone() }, flip })
    }

    /// Where `a` is lighter (red) or darker (blue) than `b`, with a legend below that starts with
    /// `title`.
    pub fn signed_map(&self, title: &str) -> RgbImage {
        let range = maps::signed_range(&self.signed);
        let labels = [format!("-{range}"), "0".to_owned(), format!("+{range}")];
        legend::below(maps::signed(&self.signed, range), title, &labels, maps::diverging)
    }

    /// The FLIP error of each pixel, with a legend below.
    pub fn flip_map(&self) -> RgbImage {
        let labels = ["0", "0.5", "1"].map(str::to_owned);
        legend::below(maps::flip(&self.flip), "FLIP error", &labels, maps::sequential)
    }
}
