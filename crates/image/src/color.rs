//! The sRGB transfer function and luminance.

use std::sync::LazyLock;

static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0)));

/// Decodes an sRGB value: returns the linear value of `encoded`. Nothing is clipped.
///
/// Source: IEC 61966-2-1:1999.
#[inline]
#[must_use]
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encodes a linear value in sRGB. The value is clipped to `0.0..=1.0` first; NaN stays NaN.
///
/// Source: IEC 61966-2-1:1999.
#[inline]
#[must_use]
pub fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Returns the linear value of each 8-bit sRGB value: entry `byte` is [`linear_from_srgb`] of
/// `byte / 255`.
#[inline]
#[must_use]
pub fn linear_from_srgb_table() -> &'static [f32; 256] {
    &LINEAR_FROM_SRGB
}

/// Returns the relative luminance of a linear RGB pixel with the weights of ITU-R BT.709. Alpha is
/// ignored.
#[inline]
#[must_use]
pub fn luminance([r, g, b, _]: [f32; 4]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_transfer_functions_are_inverse() {
        for i in 0..=1000 {
            let linear = i as f32 / 1000.0;
            let back = linear_from_srgb(srgb_from_linear(linear));
            assert!((back - linear).abs() < 2e-6, "{linear} became {back}");
        }
        assert_eq!((srgb_from_linear(-1.0), srgb_from_linear(0.0)), (0.0, 0.0));
        assert_eq!(srgb_from_linear(7.0), srgb_from_linear(1.0));
        assert!(srgb_from_linear(f32::NAN).is_nan());
    }
}
