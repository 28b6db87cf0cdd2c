//! Planes of numbers, and separable filters over them.

use rayon::prelude::*;

/// One number for each pixel, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plane {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// `width * height` numbers.
    pub values: Vec<f32>,
}

impl Plane {
    /// Returns the mean of all values, or 0 if there are none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.values.iter().map(|&value| f64::from(value)).sum();
        sum / self.values.len().max(1) as f64
    }

    /// Filters along the rows with `horizontal`, then along the columns with `vertical`. Both have
    /// an odd number of weights, centred on the pixel. Beyond the border, its pixels are repeated.
    pub(crate) fn convolve(&self, horizontal: &[f32], vertical: &[f32]) -> Self {
        let (width, height) = (self.width, self.height);
        if self.values.is_empty() {
            return self.clone();
        }
        let mut rows = vec![0.0; self.values.len()];
        rows.par_chunks_mut(width).zip(self.values.par_chunks(width)).for_each(|(out, row)| {
            let reach = (horizontal.len() / 2) as isize;
            for (x, out) in out.iter_mut().enumerate() {
                let at = |k: usize| row[clamp(x as isize + k as isize - reach, width)];
                *out = horizontal.iter().enumerate().map(|(k, weight)| weight * at(k)).sum();
            }
        });
        let mut values = vec![0.0; rows.len()];
        values.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            let reach = (vertical.len() / 2) as isize;
            for (k, weight) in vertical.iter().enumerate() {
                let from = clamp(y as isize + k as isize - reach, height) * width;
                for (out, value) in out.iter_mut().zip(&rows[from..from + width]) {
                    *out += weight * value;
                }
            }
        });
        Self { width, height, values }
    }
}

/// Returns the nearest index below `count`.
fn clamp(index: isize, count: usize) -> usize {
    index.clamp(0, count as isize - 1) as usize
}

#[cfg(test)]
mod tests {
    use super::Plane;

    #[test]
    fn a_normalized_filter_keeps_a_constant_up_to_the_border() {
        let plane = Plane { width: 3, height: 2, values: vec![2.0; 6] };
        assert_eq!(plane.convolve(&[0.25, 0.5, 0.25], &[0.0, 1.0, 0.0]), plane);
    }

    #[test]
    fn weights_run_from_left_to_right_and_from_top_to_bottom() {
        let plane = Plane { width: 3, height: 3, values: (0..9).map(|i| i as f32).collect() };
        let right = plane.convolve(&[0.0, 0.0, 1.0], &[1.0]);
        assert_eq!(right.values, [1., 2., 2., 4., 5., 5., 7., 8., 8.]);
        let above = plane.convolve(&[1.0], &[1.0, 0.0, 0.0]);
        assert_eq!(above.values, [0., 1., 2., 0., 1., 2., 3., 4., 5.]);
    }
}
