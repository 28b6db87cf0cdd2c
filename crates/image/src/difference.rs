//! How two images differ: numbers, and maps that show where.

use crate::error::{CompareError, same_size};
use crate::metrics::{Metrics, metrics};
use crate::{Image, Plane, flip, legend, luminance, maps};

/// How an image `a` differs from an image `b`. Alpha is ignored.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Single numbers.
    pub metrics: Metrics,
    /// Luminance of `a` minus that of `b`; 0 where one of them is not finite.
    pub signed: Plane,
    /// FLIP error of each pixel, see [`flip()`](crate::flip()).
    pub flip: Plane,
}

impl Difference {
    /// Compares two images. `b` is the one that relative errors are relative to.
    ///
    /// # Errors
    ///
    /// If the images differ in size, or no pixel is finite in both.
    pub fn between(a: &Image, b: &Image) -> Result<Self, CompareError> {
        same_size(a, b)?;
        let flip = flip(a, b)?;
        let metrics = metrics(a, b, flip.mean())?;
        let difference = |(&a, &b)| {
            let difference = luminance(a) - luminance(b);
            if difference.is_finite() { difference } else { 0.0 }
        };
        let values = a.pixels.iter().zip(&b.pixels).map(difference).collect();
        Ok(Self { metrics, signed: Plane { values, ..flip.clone() }, flip })
    }

    /// Draws where `a` is lighter (red) or darker (blue) than `b`, with a legend below that starts
    /// with `title`. The scale ends at [`maps::signed_range`]. `title` is drawn in ASCII: other
    /// characters leave a gap.
    #[must_use]
    pub fn signed_map(&self, title: &str) -> Image {
        let range = maps::signed_range(&self.signed);
        let labels = [format!("-{range}"), "0".to_owned(), format!("+{range}")];
        legend::below(&maps::signed(&self.signed, range), title, &labels, maps::diverging)
    }

    /// Draws the FLIP error of each pixel, with a legend below.
    #[must_use]
    pub fn flip_map(&self) -> Image {
        let labels = ["0", "0.5", "1"].map(str::to_owned);
        legend::below(&maps::flip(&self.flip), "FLIP error", &labels, maps::sequential)
    }
}
