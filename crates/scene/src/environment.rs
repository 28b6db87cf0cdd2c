//! Environments: light from infinitely far away, and the parametrization of directions.

use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A light at infinity: a constant radiance, or one times a latitude-longitude image. The default
/// is black.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    /// Name for messages; may be empty.
    pub name: String,
    /// A rigid frame; its y axis points to the first row of the image.
    pub world_from_environment: Affine3A,
    /// Radiance, or the factor of the image. `rotund-trace` counts a sample of 2³⁹ or more as
    /// black, and in `Film::rejected`.
    pub emission: Vec3,
    /// Image that scales `emission`: an index into [`crate::Scene::textures`].
    pub emission_tex: Option<u32>,
}

impl Environment {
    /// Returns the image coordinates of `direction`, which need not have unit length: in the frame
    /// of the environment `u = atan2(z, x) / 2 pi` and `v = acos(y) / pi`, both in `0.0..=1.0`.
    ///
    /// They are within 2^-23 of the exact ones of the rounded direction, a thousandth of a pixel of
    /// an image 8192 pixels wide. A zero direction, or one whose square overflows, gives
    /// unspecified coordinates in that range.
    #[must_use]
    #[inline]
    pub fn uv(&self, direction: Vec3) -> Vec2 {
        // The frame is rigid: its inverse is its transpose.
        let axes = self.world_from_environment.matrix3;
        let x = Vec3::from(axes.x_axis).dot(direction);
        let y = Vec3::from(axes.y_axis).dot(direction);
        let z = Vec3::from(axes.z_axis).dot(direction);
        let turn = quarter_turn(x.abs(), z.abs());
        let turn = if x < 0.0 { 0.5 - turn } else { turn };
        let u = if z < 0.0 { 1.0 - turn } else { turn };
        // From both legs, since an arc cosine is ill-conditioned near the poles.
        let v = 2.0 * quarter_turn(y.abs(), (x * x + z * z).sqrt());
        Vec2::new(u, if y < 0.0 { 1.0 - v } else { v })
    }

    /// Returns the direction of unit length that [`Self::uv`] maps to `uv`.
    #[must_use]
    pub fn direction(&self, uv: Vec2) -> Vec3 {
        let (sin_u, cos_u) = (TAU * uv.x).sin_cos();
        let (sin_v, cos_v) = (PI * uv.y).sin_cos();
        let local = Vec3::new(cos_u * sin_v, cos_v, sin_u * sin_v);
        self.world_from_environment.transform_vector3(local)
    }
}

/// Returns `atan2(y, x) / 2 pi` for arguments that are not negative; zero at the origin.
///
/// The library function selects its interval by branches, which are mispredicted for random
/// directions, and every ray that leaves a scene needs two angles. This one is branch-free.
#[inline]
fn quarter_turn(x: f32, y: f32) -> f32 {
    let (low, high) = if x < y { (x, y) } else { (y, x) };
    let slope = if high > 0.0 { low / high } else { 0.0 };
    let square = slope * slope;
    // The minimax polynomial of 8 odd powers for `atan(slope) / 2 pi` in 0..1; its error is 6.0e-9.
    let turn = [
        -0.000_645_304_46,
        0.003_479_598,
        -0.008_898_723,
        0.015_346_034,
        -0.022_136_271,
        0.031_745_946,
        -0.053_046_12,
        0.159_154_84_f32,
    ]
    .into_iter()
    .fold(0.0, |sum, coefficient| sum * square + coefficient)
        * slope;
    if x < y { 0.25 - turn } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts;

    fn sky() -> Environment {
        Environment {
            name: String::new(),
            world_from_environment: Affine3A::IDENTITY,
            emission: Vec3::ONE,
            emission_tex: None,
        }
    }

    #[test]
    fn coordinates_are_those_of_the_exact_angles() {
        let sky = sky();
        let spiral = (0..200_000).map(|i| {
            let azimuth = f64::from(i) * 2.399_963;
            let height = (f64::from(i) + 0.5) / 100_000.0 - 1.0;
            let radius = (1.0 - height * height).sqrt();
            DVec3::new(radius * azimuth.cos(), height, radius * azimuth.sin()).as_vec3()
        });
        let near_poles = (0..1000).map(|i| Vec3::new(1e-3, 1.0, 1e-6 * i as f32 - 5e-4));
        let diagonal = (0..1000).map(|i| Vec3::new(1.0, 1.0 + 1e-7 * i as f32, 1.0));
        let (mut worst, bound) = (0.0_f64, 0.5_f64.powi(23));
        for direction in spiral.chain(near_poles).chain(diagonal) {
            let d = direction.as_dvec3();
            let turn = (d.z.atan2(d.x) / consts::TAU).rem_euclid(1.0);
            let v = d.x.hypot(d.z).atan2(d.y) / consts::PI;
            for scale in [1.0, -1.0, 1e-12, 1e12] {
                let found = sky.uv(scale * direction).as_dvec2();
                let (u, v) = if scale < 0.0 { ((turn + 0.5) % 1.0, 1.0 - v) } else { (turn, v) };
                let around = (found.x - u).abs();
                worst = worst.max(around.min(1.0 - around)).max((found.y - v).abs());
                assert!(worst < bound, "{direction} times {scale}: {found}, not {u} {v}");
            }
        }
        // The bound is tight.
        assert!(worst > 0.25 * bound, "{worst}");
    }

    #[test]
    fn axes_have_their_exact_coordinates() {
        let sky = sky();
        let table = [
            (Vec3::X, [0.0, 0.5]),
            (Vec3::Z, [0.25, 0.5]),
            (-Vec3::X, [0.5, 0.5]),
            (-Vec3::Z, [0.75, 0.5]),
            (Vec3::Y, [0.0, 0.0]),
            (-Vec3::Y, [0.0, 1.0]),
            (Vec3::ZERO, [0.0, 0.0]),
        ];
        for (direction, uv) in table {
            assert_eq!(sky.uv(direction).to_array(), uv, "{direction}");
        }
        for odd in [f32::NAN, f32::INFINITY, f32::MAX] {
            let Vec2 { x, y } = sky.uv(Vec3::splat(odd));
            assert!((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y), "{odd}: {x} {y}");
        }
    }
}
