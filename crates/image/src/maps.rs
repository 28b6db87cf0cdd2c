//! Maps: planes of numbers drawn in colours.

use crate::{Image, Plane};

/// Returns the 8-bit sRGB colour of `t` in `0.0..=1.0` on the scale from blue over white to red.
#[must_use]
pub fn diverging(t: f64) -> [u8; 3] {
    colorous::RED_BLUE.eval_continuous(1.0 - t).as_array()
}

/// Returns the 8-bit sRGB colour of `t` in `0.0..=1.0` on the scale from black over violet to pale
/// yellow (magma), which the authors of FLIP use.
#[must_use]
pub fn sequential(t: f64) -> [u8; 3] {
    colorous::MAGMA.eval_continuous(t).as_array()
}

/// Returns the difference at the ends of the scale of a signed map: the 99th percentile of the
/// absolute values that are not 0, rounded up to 1, 2 or 5 times a power of ten; at least 0.001.
#[must_use]
pub fn signed_range(signed: &Plane) -> f64 {
    let mut sizes: Vec<f32> =
        signed.values.iter().map(|value| value.abs()).filter(|&size| size > 0.0).collect();
    if sizes.is_empty() {
        return 0.001;
    }
    let index = (sizes.len() - 1) * 99 / 100;
    let (_, &mut size, _) = sizes.select_nth_unstable_by(index, f32::total_cmp);
    let size = f64::from(size).max(0.001);
    // The exponent may come out one too high for an exact power of ten; then 1 times it is right.
    let decade = 10f64.powi(size.log10().floor() as i32);
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().find(|step| size <= step * decade * 1.000_001);
    // Through text, so that 5e-3 is 0.005 to the last digit.
    format!("{:.0e}", step.unwrap_or(10.0) * decade).parse().expect("a number just printed")
}

/// Draws values from `-range` (blue) to `range` (red).
///
/// # Panics
///
/// If the plane does not hold `width * height` values.
#[must_use]
pub fn signed(signed: &Plane, range: f64) -> Image {
    draw(signed, |value| diverging((0.5 + 0.5 * f64::from(value) / range).clamp(0.0, 1.0)))
}

/// Draws values from 0 (black) to 1 (pale yellow).
///
/// # Panics
///
/// If the plane does not hold `width * height` values.
#[must_use]
pub fn flip(flip: &Plane) -> Image {
    draw(flip, |value| sequential(f64::from(value).clamp(0.0, 1.0)))
}

fn draw(plane: &Plane, color: impl Fn(f32) -> [u8; 3]) -> Image {
    let Plane { width, height, ref values } = *plane;
    let whole = width.checked_mul(height) == Some(values.len());
    assert!(whole, "a plane of {width} x {height} holds {} values", values.len());
    Image::from_srgb_fn(plane.width as u32, plane.height as u32, |x, y| {
        color(plane.values[y as usize * plane.width + x as usize])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(values: Vec<f32>) -> Plane {
        Plane { width: values.len(), height: 1, values }
    }

    #[test]
    fn the_scale_ends_at_a_round_number_above_most_differences() {
        let table = [
            (vec![0.0, 0.0], 0.001),
            (vec![0.0, 0.3], 0.5),
            (vec![-0.05, 0.04], 0.05),
            (vec![0.0001], 0.001),
            (vec![-700.0; 5], 1000.0),
        ];
        for (values, range) in table {
            assert_eq!(signed_range(&plane(values.clone())), range, "{values:?}");
        }
        let mut outlier = vec![0.15; 1000];
        outlier[3] = 1e6;
        assert_eq!(signed_range(&plane(outlier)), 0.2);
    }

    #[test]
    fn lighter_is_red_darker_is_blue_and_equal_is_white() {
        let map = signed(&plane(vec![1.0, 0.0, -1.0, 9.0]), 1.0);
        let [lighter, equal, darker, beyond] = *map.srgb_bytes() else { panic!("four pixels") };
        assert!(lighter[0] > 80 && lighter[2] < 60 && lighter == beyond, "{lighter:?}");
        assert!(equal.iter().all(|&c| c > 230), "{equal:?}");
        assert!(darker[2] > 80 && darker[0] < 60, "{darker:?}");
    }
}
