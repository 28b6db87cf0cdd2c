//! Random primitives in the cube from -1 to 1.

use super::Random;
use rotund_geometry::{BilinearPatch, RoundedCone, Sphere, Triangle};

pub(crate) fn spheres(random: &mut Random, count: usize, size: f32) -> Vec<Sphere> {
    (0..count)
        .map(|_| Sphere { center: random.in_cube(), radius: size * (0.01 + random.unit()) })
        .collect()
}

pub(crate) fn cones(random: &mut Random, count: usize, size: f32) -> Vec<RoundedCone> {
    (0..count)
        .map(|i| {
            let p0 = random.in_cube();
            // Long and thin, short and thick, and one ball in the other.
            let length = size * 2f32.powi(i as i32 % 7 - 4);
            RoundedCone {
                p0,
                r0: 0.2 * size * random.unit(),
                p1: p0 + length * random.in_cube(),
                r1: 0.2 * size * random.unit(),
            }
        })
        .collect()
}

pub(crate) fn patches(random: &mut Random, count: usize, size: f32) -> Vec<BilinearPatch> {
    (0..count)
        .map(|i| {
            let p00 = random.in_cube();
            let (u, v) = (size * random.in_cube(), size * random.in_cube());
            let twist = size * random.in_cube() * [0.0, 0.1, 1.0][i % 3];
            BilinearPatch { p00, p10: p00 + u, p01: p00 + v, p11: p00 + u + v + twist }
        })
        .collect()
}

pub(crate) fn triangles(random: &mut Random, count: usize, size: f32) -> Vec<Triangle> {
    (0..count)
        .map(|_| {
            let p0 = random.in_cube();
            Triangle { p0, p1: p0 + size * random.in_cube(), p2: p0 + size * random.in_cube() }
        })
        .collect()
}
