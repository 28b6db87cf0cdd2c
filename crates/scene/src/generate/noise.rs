//! Gradient noise, and hashes of integers in place of random numbers.

use glam::{DVec2, Vec3};
use std::f64::consts::TAU;

/// Returns a smooth random vector of wavelength about 1, each coordinate in `-1.0..=1.0`.
pub(super) fn vector_noise(p: Vec3) -> Vec3 {
    // These offsets decorrelate the three coordinates.
    Vec3::new(noise(p), noise(p + Vec3::splat(33.25)), noise(p + Vec3::splat(71.75)))
}

/// Returns gradient noise: zero at every lattice point, with a random gradient there.
///
/// Source: K. Perlin, "Improving Noise", SIGGRAPH 2002, with a hash instead of its table.
fn noise(p: Vec3) -> f32 {
    let corner = p.floor();
    let inside = p - corner;
    let fade = inside.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let lattice = corner.to_array().map(|c| c as i32);
    let slope = |x: i32, y: i32, z: i32| {
        let offset = Vec3::new(x as f32, y as f32, z as f32);
        gradient(lattice[0] + x, lattice[1] + y, lattice[2] + z).dot(inside - offset)
    };
    let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
    let row = |y, z| mix(slope(0, y, z), slope(1, y, z), fade.x);
    let sheet = |z| mix(row(0, z), row(1, z), fade.y);
    mix(sheet(0), sheet(1), fade.z)
}

/// Returns one of the twelve directions to the edges of a cube.
fn gradient(x: i32, y: i32, z: i32) -> Vec3 {
    let hash = hash([x as u32, y as u32, z as u32]);
    let a = if hash & 1 == 0 { 1.0 } else { -1.0 };
    let b = if hash & 2 == 0 { 1.0 } else { -1.0 };
    match (hash >> 2) % 3 {
        0 => Vec3::new(a, b, 0.0),
        1 => Vec3::new(a, 0.0, b),
        _ => Vec3::new(0.0, a, b),
    }
}

/// Returns a hash of three integers.
pub(super) fn hash([x, y, z]: [u32; 3]) -> u32 {
    let mut hash =
        x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    hash = (hash ^ (hash >> 12)).wrapping_mul(0x297a_2d39);
    hash ^ (hash >> 15)
}

/// Returns a number in `0.0..1.0` for a key.
pub(super) fn share(key: [u32; 3]) -> f64 {
    f64::from(hash(key)) / (f64::from(u32::MAX) + 1.0)
}

/// Returns a unit vector for a key, evenly distributed over all keys.
pub(super) fn unit_vector([a, b, c]: [u32; 3]) -> Vec3 {
    let z = 2.0 * share([a, b, c]) - 1.0;
    let around = (1.0 - z * z).sqrt() * DVec2::from_angle(TAU * share([a, b, !c]));
    around.extend(z).as_vec3()
}
