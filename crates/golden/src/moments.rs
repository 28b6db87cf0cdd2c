//! Statistics of a picture: the mean and the variance of each pixel.

use glam::DVec3;
use rotund_image::Image;

/// Mean and variance of the replicas of a picture, in linear RGB.
///
/// A picture is rendered as many small replicas that differ in their seed alone. They are
/// independent of each other, even where the samples of one render are not, so their spread tells
/// the error of their mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Number of replicas.
    pub replicas: u32,
    /// Mean over the replicas, row by row.
    pub mean: Vec<DVec3>,
    /// Unbiased estimate of the variance of one replica.
    pub variance: Vec<DVec3>,
    /// Number of samples that were negative, infinite or NaN.
    pub rejected: u64,
}

impl Moments {
    /// Returns the statistics of no replica.
    pub(crate) fn empty(width: usize, height: usize) -> Self {
        let zeros = vec![DVec3::ZERO; width * height];
        Self { width, height, replicas: 0, mean: zeros.clone(), variance: zeros, rejected: 0 }
    }

    /// Adds a replica. Until [`Self::finish`], `variance` holds sums of squares.
    ///
    /// Source: B. Welford, "Note on a method for calculating corrected sums of squares and
    /// products", Technometrics 4(3), 1962.
    pub(crate) fn push(&mut self, pixels: impl Iterator<Item = DVec3>) {
        self.replicas += 1;
        let count = f64::from(self.replicas);
        for ((mean, squares), x) in self.mean.iter_mut().zip(&mut self.variance).zip(pixels) {
            let before = x - *mean;
            *mean += before / count;
            *squares += before * (x - *mean);
        }
    }

    /// Turns sums of squares into variances.
    pub(crate) fn finish(mut self) -> Self {
        let freedom = f64::from(self.replicas.saturating_sub(1).max(1));
        self.variance.iter_mut().for_each(|squares| *squares /= freedom);
        self
    }

    /// Returns the mean as an image.
    #[must_use]
    pub fn picture(&self) -> Image {
        let pixels = self.mean.iter().map(|mean| mean.as_vec3().extend(1.0).to_array()).collect();
        Image { width: self.width as u32, height: self.height as u32, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_variance_are_those_of_the_textbook() {
        let mut moments = Moments::empty(1, 1);
        for x in [2.0, 4.0, 4.0, 10.0] {
            moments.push([DVec3::splat(x)].into_iter());
        }
        let moments = moments.finish();
        assert_eq!(moments.mean, [DVec3::splat(5.0)]);
        let off = moments.variance[0] - DVec3::splat(12.0);
        assert!(off.abs().max_element() < 1e-12, "{off} off");
    }
}
