//! Maps from the unit square to the domains that samples are taken from.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_4, TAU};
use std::hint::select_unpredictable;

/// Returns a point of the unit disk, uniform by area, by the concentric map.
///
/// Source: P. Shirley, K. Chiu, "A low distortion map between disk and square", Journal of Graphics
/// Tools 2(3), 1997.
#[must_use]
pub fn disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - 1.0;
    let wide = p.x.abs() > p.y.abs();
    let [radius, across] = select_unpredictable(wide, [p.x, p.y], [p.y, p.x]);
    let share = if radius == 0.0 { 0.0 } else { across / radius };
    let (sine, cosine) = sine_and_cosine(FRAC_PI_4 * share);
    let point = select_unpredictable(wide, [cosine, sine], [sine, cosine]);
    radius * Vec2::from_array(point)
}

/// Returns sine and cosine of an angle of at most π / 4, within 1e-7.
///
/// Source: minimax polynomials of S. Moshier, "Methods and Programs for Mathematical Functions",
/// 1989.
fn sine_and_cosine(angle: f32) -> (f32, f32) {
    let square = angle * angle;
    let s = (-1.951_529_6e-4 * square + 8.332_161e-3) * square - 1.666_665_5e-1;
    let c = (2.443_315_7e-5 * square - 1.388_731_6e-3) * square + 4.166_664_6e-2;
    (s * square * angle + angle, c * square * square - 0.5 * square + 1.0)
}

/// Returns a direction about +z with density `z / π` per solid angle.
#[must_use]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    // The concentric map takes squares to circles, so the radius is known before the map is
    // evaluated.
    let radius = (2.0 * u - 1.0).abs().max_element();
    disk(u).extend(((1.0 - radius) * (1.0 + radius)).max(0.0).sqrt())
}

/// Returns a direction with density `1 / 4π` per solid angle.
#[must_use]
pub fn sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    // 1 - z² without cancellation near the poles.
    let radius = 2.0 * (u.x * (1.0 - u.x)).sqrt();
    (radius * Vec2::from_angle(TAU * u.y)).extend(z)
}

/// Returns the barycentric weights of the second and third corner of a triangle, uniform by area.
///
/// Source: E. Heitz, "A low-distortion map between triangle and square", 2019.
#[must_use]
pub fn triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let half = 0.5 * u.x;
        Vec2::new(half, u.y - half)
    } else {
        let half = 0.5 * u.y;
        Vec2::new(u.x - half, half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_sine_and_cosine() {
        for step in -1_000_000..=1_000_000 {
            let angle = FRAC_PI_4 * (step as f32 / 1e6);
            let (sine, cosine) = sine_and_cosine(angle);
            let (exact_sine, exact_cosine) = f64::from(angle).sin_cos();
            assert!((f64::from(sine) - exact_sine).abs() <= 1e-7 * exact_sine.abs(), "{angle}");
            assert!((f64::from(cosine) - exact_cosine).abs() <= 1e-7, "{angle}");
        }
    }

    #[test]
    fn the_map_to_the_disk_keeps_rays_through_the_middle_and_area() {
        let table = [
            ("the middle", [0.5, 0.5], [0.0, 0.0]),
            ("a corner", [1.0, 1.0], [0.5_f32.sqrt(), 0.5_f32.sqrt()]),
            ("the other corner", [0.0, 1.0], [-0.5_f32.sqrt(), 0.5_f32.sqrt()]),
            ("the right edge", [1.0, 0.5], [1.0, 0.0]),
            ("the left edge", [0.0, 0.5], [-1.0, 0.0]),
            ("the lower edge", [0.5, 0.0], [0.0, -1.0]),
        ];
        for (why, u, expected) in table {
            let found = disk(u.into());
            assert!(found.abs_diff_eq(expected.into(), 2e-7), "{why}: {found}");
        }
        let inner = |k: u32| (k as f32 + 0.5) / 512.0;
        let points = (0..512).flat_map(|i| (0..512).map(move |j| Vec2::new(inner(i), inner(j))));
        let within = points.filter(|&u| disk(u).length() < 0.5).count();
        assert!((within as f32 / (512.0 * 512.0) - 0.25).abs() < 1e-3, "{within}");
    }
}
