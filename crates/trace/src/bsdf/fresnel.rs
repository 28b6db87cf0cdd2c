//! Fresnel reflectance of smooth boundaries for unpolarised light.

use glam::Vec3;

/// Returns the reflectance of a boundary between dielectrics. `eta` is the index of refraction
/// beyond the boundary over that on the side of the light, `cosine` the cosine of the angle to the
/// normal, of either sign. Beyond the critical angle the reflectance is 1.
#[must_use]
pub fn dielectric(eta: f32, cosine: f32) -> f32 {
    let cosine = cosine.abs().min(1.0);
    let sine2 = (1.0 - cosine) * (1.0 + cosine);
    let transmitted2 = 1.0 - sine2 / (eta * eta);
    if transmitted2 <= 0.0 {
        // At grazing incidence and equal indices the formulas below are 0 / 0.
        return if eta == 1.0 { 0.0 } else { 1.0 };
    }
    let transmitted = transmitted2.sqrt();
    let perpendicular = (cosine - eta * transmitted) / (cosine + eta * transmitted);
    let parallel = (transmitted - eta * cosine) / (transmitted + eta * cosine);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// Returns the reflectance of a conductor without absorption (k = 0) that reflects `color` at
/// normal incidence. Each channel is clamped to 0.99, which is an index of refraction of 398.
#[must_use]
pub fn conductor(color: Vec3, cosine: f32) -> Vec3 {
    let root = color.clamp(Vec3::ZERO, Vec3::splat(0.99)).map(f32::sqrt);
    let eta = (1.0 + root) / (1.0 - root);
    eta.map(|eta| dielectric(eta, cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let brewster = (1.0 + 1.5_f32 * 1.5).sqrt().recip();
        let table = [
            ("head on, 4 % for glass", 1.5, 1.0, 0.04),
            ("head on from inside", 1.0 / 1.5, 1.0, 0.04),
            ("grazing", 1.5, 0.0, 1.0),
            ("Brewster's angle: the perpendicular half alone", 1.5, brewster, 0.5 * 0.147_929),
            ("beyond the critical angle", 1.0 / 1.5, 0.5, 1.0),
            ("no boundary", 1.0, 0.3, 0.0),
            ("the sign of the cosine does not matter", 1.5, -1.0, 0.04),
        ];
        for (why, eta, cosine, expected) in table {
            let f = dielectric(eta, cosine);
            assert!((f - expected).abs() < 1e-6, "{why}: {f} is not {expected}");
        }
    }

    #[test]
    fn a_conductor_reflects_its_color_head_on_and_everything_at_grazing() {
        let color = Vec3::new(0.0, 0.66, 0.99);
        assert!(conductor(color, 1.0).abs_diff_eq(color, 1e-5));
        assert!(conductor(color, 0.0).abs_diff_eq(Vec3::new(0.0, 1.0, 1.0), 1e-6));
        assert!(conductor(Vec3::ONE, 1.0).abs_diff_eq(Vec3::splat(0.99), 1e-5));
    }
}
