//! The windows in which two pictures differ most.

use rotund_image::Plane;

/// A rectangle of pixels and the mean error in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crop {
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) error: f64,
}

/// Windows with a smaller mean error than this are not shown, because they would show noise.
const SMALLEST_ERROR: f64 = 0.002;

/// Returns up to `count` windows with the largest mean of `error`, worst first. They have `width`
/// by `height` pixels, or as many as fit, and do not overlap.
pub(super) fn worst(error: &Plane, width: usize, height: usize, count: usize) -> Vec<Crop> {
    let (width, height) = (width.min(error.width), height.min(error.height));
    let sums = SummedArea::new(error);
    let mut candidates = Vec::new();
    for y in steps(error.height - height) {
        for x in steps(error.width - width) {
            let error = sums.sum(x, y, width, height) / (width * height) as f64;
            if error >= SMALLEST_ERROR {
                candidates.push(Crop { x, y, width, height, error });
            }
        }
    }
    candidates.sort_by(|a, b| b.error.total_cmp(&a.error));
    let mut crops: Vec<Crop> = Vec::new();
    for candidate in candidates {
        if crops.len() == count {
            break;
        }
        let clear = |crop: &Crop| {
            crop.x.abs_diff(candidate.x) >= width || crop.y.abs_diff(candidate.y) >= height
        };
        if crops.iter().all(clear) {
            crops.push(candidate);
        }
    }
    crops
}

/// Returns every fourth position, and the last.
fn steps(last: usize) -> impl Iterator<Item = usize> {
    (0..last).step_by(4).chain([last])
}

/// Sums over rectangles in constant time (F. Crow, "Summed-area tables for texture mapping", 1984).
struct SummedArea {
    stride: usize,
    sums: Vec<f64>,
}

impl SummedArea {
    fn new(plane: &Plane) -> Self {
        let stride = plane.width + 1;
        let mut sums = vec![0.0; stride * (plane.height + 1)];
        for y in 0..plane.height {
            let mut row = 0.0;
            for x in 0..plane.width {
                row += f64::from(plane.values[y * plane.width + x]);
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
            }
        }
        Self { stride, sums }
    }

    fn sum(&self, x: usize, y: usize, width: usize, height: usize) -> f64 {
        let at = |x: usize, y: usize| self.sums[y * self.stride + x];
        at(x + width, y + height) - at(x, y + height) - at(x + width, y) + at(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(width: usize, height: usize, error: impl Fn(usize, usize) -> f32) -> Plane {
        let values = (0..width * height).map(|i| error(i % width, i / width)).collect();
        Plane { width, height, values }
    }

    #[test]
    fn planted_differences_are_found_worst_first_and_apart() {
        let plane = plane(100, 80, |x, y| match (x, y) {
            (40..48, 40..48) => 0.5,
            (92..100, 72..80) => 0.9,
            _ => 0.0,
        });
        let crops = worst(&plane, 8, 8, 2);
        assert_eq!(crops[0], Crop { x: 92, y: 72, width: 8, height: 8, error: crops[0].error });
        assert_eq!((crops[1].x, crops[1].y), (40, 40));
        assert!((crops[0].error - 0.9).abs() < 1e-6 && (crops[1].error - 0.5).abs() < 1e-6);
        for (i, a) in crops.iter().enumerate() {
            for b in &crops[..i] {
                assert!(a.x.abs_diff(b.x) >= 8 || a.y.abs_diff(b.y) >= 8, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_picture_smaller_than_a_window_is_one_window_and_equal_pictures_have_none() {
        let crops = worst(&plane(5, 3, |_, _| 0.1), 64, 48, 6);
        assert_eq!(crops.len(), 1);
        assert_eq!((crops[0].width, crops[0].height), (5, 3));
        assert!(worst(&plane(99, 99, |_, _| 0.0), 64, 48, 6).is_empty());
    }
}
