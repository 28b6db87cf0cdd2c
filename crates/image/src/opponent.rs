//! The colour spaces in which FLIP measures differences.

use glam::{Mat3, Vec3};
use std::sync::LazyLock;

/// Linear RGB with BT.709 primaries to CIE XYZ, from the exact chromaticities of the primaries and
/// of D65 (0.3127, 0.3290).
static XYZ_FROM_RGB: LazyLock<Mat3> = LazyLock::new(|| {
    Mat3::from_cols(
        Vec3::new(
            (10_135_552.0 / 24_577_794.0) as f32,
            (2_613_072.0 / 12_288_897.0) as f32,
            (1_425_312.0 / 73_733_382.0) as f32,
        ),
        Vec3::new(
            (8_788_810.0 / 24_577_794.0) as f32,
            (8_788_810.0 / 12_288_897.0) as f32,
            (8_788_810.0 / 73_733_382.0) as f32,
        ),
        Vec3::new(
            (4_435_075.0 / 24_577_794.0) as f32,
            (887_015.0 / 12_288_897.0) as f32,
            (70_074_185.0 / 73_733_382.0) as f32,
        ),
    )
});
static RGB_FROM_XYZ: LazyLock<Mat3> = LazyLock::new(|| XYZ_FROM_RGB.inverse());
/// XYZ of the white point, which is RGB (1, 1, 1).
static WHITE: LazyLock<Vec3> = LazyLock::new(|| *XYZ_FROM_RGB * Vec3::ONE);

/// Returns L*a*b* without its cube root (YCxCz): linear in light, and opponent. `x` runs from -16
/// to 100.
///
/// Source: X. Zhang, B. Wandell, "A spatial extension of CIELAB for digital color-image
/// reproduction", 1997.
pub(crate) fn opponent_from_rgb(rgb: Vec3) -> Vec3 {
    let xyz = *XYZ_FROM_RGB * rgb / *WHITE;
    Vec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
}

/// The inverse of [`opponent_from_rgb`].
pub(crate) fn rgb_from_opponent(opponent: Vec3) -> Vec3 {
    let y = (opponent.x + 16.0) / 116.0;
    let xyz = Vec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
    *RGB_FROM_XYZ * (xyz * *WHITE)
}

/// Returns CIE 1976 L*a*b*.
pub(crate) fn lab_from_rgb(rgb: Vec3) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let f = map(*XYZ_FROM_RGB * rgb / *WHITE, |t| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    });
    Vec3::new(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z))
}

fn map(color: Vec3, f: impl Fn(f32) -> f32) -> Vec3 {
    Vec3::new(f(color.x), f(color.y), f(color.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colors_have_their_published_lab() {
        // B. Lindbloom's CIE calculator, sRGB with D65.
        let table = [
            ("white", Vec3::ONE, Vec3::new(100.0, 0.0, 0.0)),
            ("red", Vec3::X, Vec3::new(53.24, 80.09, 67.20)),
            ("green", Vec3::Y, Vec3::new(87.73, -86.18, 83.18)),
            ("blue", Vec3::Z, Vec3::new(32.30, 79.19, -107.86)),
            ("black", Vec3::ZERO, Vec3::ZERO),
        ];
        for (name, rgb, lab) in table {
            assert!(lab_from_rgb(rgb).abs_diff_eq(lab, 0.03), "{name}: {}", lab_from_rgb(rgb));
        }
    }

    #[test]
    fn the_opponent_space_leads_back_to_rgb() {
        for rgb in [Vec3::new(0.2, 0.7, 0.01), Vec3::ONE, Vec3::ZERO] {
            assert!(rgb_from_opponent(opponent_from_rgb(rgb)).abs_diff_eq(rgb, 2e-6), "{rgb}");
        }
    }
}
