//! Shapes of random numbers.

use glam::{Vec2, Vec3};
use rotund_scene::{Elements, Overlap, Shape};
use std::f32::consts::{PI, TAU};

/// A generator of random numbers.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In `0.0..1.0`.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let bits = (self.0 ^ self.0 >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd);
        (bits >> 40) as f32 / (1 << 24) as f32
    }

    pub(crate) fn pair(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }

    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + self.unit() * (high - low)
    }

    pub(super) fn chance(&mut self, share: f32) -> bool {
        self.unit() < share
    }

    pub(super) fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f32) as usize).min(count - 1)
    }

    pub(super) fn vector(&mut self, low: f32, high: f32) -> Vec3 {
        Vec3::new(self.between(low, high), self.between(low, high), self.between(low, high))
    }

    pub(super) fn place(&mut self) -> Vec3 {
        self.vector(-1.0, 1.0).with_y(self.between(0.1, 1.4))
    }
}

/// A box whose faces point outwards.
pub(crate) fn solid_box(center: Vec3, half: Vec3) -> Shape {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        center + half * Vec3::new(side(0), side(1), side(2))
    };
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Shape::quads((0..8).map(corner).collect::<Vec<_>>(), faces)
}

/// A rectangle that is turned in any direction.
pub(super) fn rectangle(random: &mut Random, center: Vec3, size: f32) -> Shape {
    let along = random.vector(-1.0, 1.0).normalize_or(Vec3::X);
    let across = size * along.any_orthonormal_vector();
    let along = random.between(0.3, 1.0) * size * along;
    let corners = [-along - across, along - across, along + across, across - along];
    Shape::quads(corners.map(|corner| center + corner), [[0, 1, 2, 3]])
}

/// A band around an axis, open at both ends.
fn ring(random: &mut Random, center: Vec3, size: f32) -> Shape {
    const PARTS: u32 = 12;
    let height = random.between(0.2, 0.6) * size;
    let at = |i: u32, y: f32| {
        let around = size * Vec2::from_angle(TAU * i as f32 / PARTS as f32);
        center + Vec3::new(around.x, y, around.y)
    };
    let positions: Vec<Vec3> = (0..PARTS).flat_map(|i| [at(i, -height), at(i, height)]).collect();
    let face = |i: u32| {
        let next = (i + 1) % PARTS;
        [2 * i, 2 * next, 2 * next + 1, 2 * i + 1]
    };
    Shape::quads(positions, (0..PARTS).map(face).collect::<Vec<_>>())
}

/// A closed mesh like a globe, with quads that are triangles at the poles.
fn globe(center: Vec3, radii: Vec3) -> Shape {
    const PARTS: [u32; 2] = [10, 6];
    let at = |i: u32| {
        let (around, down) = (i % PARTS[0], i / PARTS[0]);
        let (sin, cos) = (PI * down as f32 / PARTS[1] as f32).sin_cos();
        let flat = sin * Vec2::from_angle(TAU * around as f32 / PARTS[0] as f32);
        center + radii * Vec3::new(flat.x, cos, flat.y)
    };
    let face = |i: u32| {
        let (around, down) = (i % PARTS[0], i / PARTS[0] * PARTS[0]);
        let next = (around + 1) % PARTS[0];
        [down + around, down + next, down + next + PARTS[0], down + around + PARTS[0]]
    };
    let positions: Vec<Vec3> = (0..PARTS[0] * (PARTS[1] + 1)).map(at).collect();
    Shape::quads(positions, (0..PARTS[0] * PARTS[1]).map(face).collect::<Vec<_>>())
}

/// Rounds to six significant digits, as many files do.
pub(super) fn round_to_decimals(positions: &mut [Vec3]) {
    let round = |x: f32| format!("{x:.5e}").parse::<f32>().expect("it was a number");
    for position in positions {
        *position = position.to_array().map(round).into();
    }
}

/// Returns a ball, balls, tubes, a mesh or a face, some with texture coordinates or colors.
pub(super) fn shape(random: &mut Random) -> Shape {
    let (center, size) = (random.place(), random.between(0.15, 0.6));
    let mut shape = match random.index(8) {
        0 => Shape::points([center], size),
        1 => {
            let other = center + size * random.vector(-1.0, 1.0);
            Shape::points([center, other], vec![size, random.between(0.1, 0.5)])
        }
        2 => {
            let ends = [random.place(), center, random.place()];
            let radii: Vec<f32> = (0..3).map(|_| random.between(0.05, 0.3)).collect();
            Shape::lines(ends, radii, [[0, 1], [1, 2]])
        }
        3 => solid_box(center, random.vector(0.1, 0.5)),
        4 => rectangle(random, center, size),
        5 => ring(random, center, size),
        6 => globe(center, Vec3::splat(size).with_y(0.7 * size)),
        _ => {
            let [a, b] = [0, 1].map(|_| size * random.vector(-1.0, 1.0));
            let opposite = center + a + b + 0.2 * random.vector(-1.0, 1.0);
            Shape::quads([center, center + a, opposite, center + b], [[0, 1, 2, 3]])
        }
    };
    let count = shape.positions.len();
    if random.chance(0.5) {
        round_to_decimals(&mut shape.positions);
    }
    if random.chance(0.3) {
        shape.overlap = Overlap::Separate;
    }
    if let (Elements::Quads(quads), true) = (&shape.elements, random.chance(0.3)) {
        shape.texcoords = (0..count).map(|_| 2.0 * random.pair()).collect();
        if count >= 8 && random.chance(0.5) {
            shape.normals = shape.positions.iter().map(|&p| p - center).collect();
        }
        if random.chance(0.5) {
            let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            shape.elements = Elements::Triangles(halves.collect());
        }
    }
    if random.chance(0.15) {
        let mut color = |_| {
            let opacity = if random.chance(0.5) { 1.0 } else { 0.6 };
            random.vector(0.3, 1.0).extend(opacity)
        };
        shape.colors = (0..count).map(&mut color).collect();
    }
    shape
}
