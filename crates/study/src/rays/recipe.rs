//! The benchmark scenes and rays, bit for bit.
//!
//! They need only `+ - * /` and square roots of `f32` and `f64`, so any program can generate the
//! same bits; the hashes verify that.

use crate::random::Random;
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Sphere, Triangle, glam::Vec3};

/// A vector of `f64` whose products are summed from left to right.
#[derive(Clone, Copy)]
struct Vector([f64; 3]);

impl Vector {
    /// Returns a random unit vector, by rejection.
    fn random_unit(random: &mut Random) -> Self {
        loop {
            let [x, y, z] = [(); 3].map(|()| 2.0 * random.unit() - 1.0);
            let square = x * x + y * y + z * z;
            if square > 1e-4 && square <= 1.0 {
                let length = square.sqrt();
                return Self([x / length, y / length, z / length]);
            }
        }
    }

    fn from_single(v: Vec3) -> Self {
        Self(v.to_array().map(f64::from))
    }

    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self([0, 1, 2].map(|i| f(self.0[i], other.0[i])))
    }

    fn plus(self, other: Self) -> Self {
        self.map2(other, |a, b| a + b)
    }

    fn minus(self, other: Self) -> Self {
        self.map2(other, |a, b| a - b)
    }

    fn times(self, k: f64) -> Self {
        Self(self.0.map(|a| k * a))
    }

    fn dot(self, other: Self) -> f64 {
        let [x, y, z] = self.map2(other, |a, b| a * b).0;
        x + y + z
    }

    fn cross(self, b: Self) -> Self {
        let (a, b) = (self.0, b.0);
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    fn unit(self) -> Self {
        let length = self.length();
        Self(self.0.map(|a| a / length))
    }

    fn single(self) -> Vec3 {
        Vec3::from_array(self.0.map(|a| a as f32))
    }
}

/// A FNV-1a hash of 64 bits over the bytes of `f32`s.
pub(super) struct Fnv(pub(super) u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, values: &[f32]) {
        for byte in values.iter().flat_map(|value| value.to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

/// Generates `count` spheres in the unit cube with radii of `base * (0.5..1.5)`, and their hash.
pub(super) fn spheres(count: usize, seed: u64, base: f32) -> (Vec<Sphere>, u64) {
    let (mut random, mut hash) = (Random::from_state(seed), Fnv::new());
    let spheres = (0..count)
        .map(|_| {
            let center = [(); 3].map(|()| random.unit_f32());
            let radius = base * (0.5 + random.unit_f32());
            hash.add(&center);
            hash.add(&[radius]);
            Sphere { center: center.into(), radius }
        })
        .collect();
    (spheres, hash.0)
}

/// Generates `fibres` tapering, curling fibres of 20 segments each, and their hash.
pub(super) fn cones(fibres: usize) -> (Vec<RoundedCone>, u64) {
    const SEGMENTS: usize = 20;
    let (mut random, mut hash) = (Random::from_state(2), Fnv::new());
    let mut cones = Vec::with_capacity(fibres * SEGMENTS);
    for _ in 0..fibres {
        let mut p = Vector([(); 3].map(|()| random.unit()));
        let mut direction = Vector::random_unit(&mut random);
        let mut last: Option<(Vec3, f32)> = None;
        for k in 0..=SEGMENTS {
            let r = 0.0015 + (0.0003 - 0.0015) * (k as f64 / SEGMENTS as f64);
            let (p1, r1) = (p.single(), r as f32);
            hash.add(&p1.to_array());
            hash.add(&[r1]);
            if let Some((p0, r0)) = last {
                cones.push(RoundedCone { p0, r0, p1, r1 });
            }
            last = Some((p1, r1));
            let turn = Vector::random_unit(&mut random);
            direction = direction.plus(turn.times(0.5)).unit();
            p = p.plus(direction.times(0.01));
        }
    }
    (cones, hash.0)
}

/// The vertices of a wavy, noisy sheet of square cells, one unit wide, row by row.
struct Grid {
    columns: usize,
    rows: usize,
    vertices: Vec<Vec3>,
    hash: u64,
}

impl Grid {
    fn new(columns: usize, rows: usize, seed: u64) -> Self {
        let wave = |t: f64| {
            let a = t - t.floor();
            8.0 * a * (1.0 - a) - 1.0
        };
        let (mut random, mut hash) = (Random::from_state(seed), Fnv::new());
        let cell = 1.0 / columns as f64;
        let mut vertices = Vec::with_capacity((columns + 1) * (rows + 1));
        for j in 0..=rows {
            for i in 0..=columns {
                let (x, y) = (i as f64 * cell, j as f64 * cell);
                let noise = 0.5 * cell * (2.0 * random.unit() - 1.0);
                let z = 0.03 * (wave(3.0 * x) * wave(3.0 * y)) + noise;
                let vertex = Vector([x, y, z]).single();
                hash.add(&vertex.to_array());
                vertices.push(vertex);
            }
        }
        Self { columns, rows, vertices, hash: hash.0 }
    }

    /// Returns the corners of each cell, counterclockwise from the lower left one.
    fn cells(&self) -> impl Iterator<Item = [Vec3; 4]> {
        let stride = self.columns + 1;
        (0..self.rows).flat_map(move |j| {
            (0..self.columns).map(move |i| {
                let a = j * stride + i;
                [a, a + 1, a + stride + 1, a + stride].map(|v| self.vertices[v])
            })
        })
    }
}

/// Generates a sheet of `n * n` quads, and its hash.
pub(super) fn patches(n: usize) -> (Vec<BilinearPatch>, u64) {
    let grid = Grid::new(n, n, 3);
    let patch = |[p00, p10, p11, p01]: [Vec3; 4]| BilinearPatch { p00, p10, p01, p11 };
    (grid.cells().map(patch).collect(), grid.hash)
}

/// Generates a sheet of `n * n / 2` cells, each cut into two triangles from its lower left to its
/// upper right corner, and its hash.
pub(super) fn triangles(n: usize) -> (Vec<Triangle>, u64) {
    let grid = Grid::new(n, n / 2, 4);
    let halves = |[a, b, c, d]: [Vec3; 4]| {
        [[a, b, c], [a, c, d]].map(|[p0, p1, p2]| Triangle { p0, p1, p2 })
    };
    (grid.cells().flat_map(halves).collect(), grid.hash)
}

/// The box that rays are aimed at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    min: [f64; 3],
    max: [f64; 3],
}

impl Target {
    pub(super) const UNIT: Self = Self { min: [0.0; 3], max: [1.0; 3] };

    /// Returns the box of points, which are vertices or centers: radii do not count.
    pub(super) fn around(points: impl Iterator<Item = Vec3>) -> Self {
        points.fold(Self { min: [1e30; 3], max: [-1e30; 3] }, |sum, p| {
            let p = Vector::from_single(p).0;
            Self {
                min: [0, 1, 2].map(|i| sum.min[i].min(p[i])),
                max: [0, 1, 2].map(|i| sum.max[i].max(p[i])),
            }
        })
    }

    /// Returns whether rays can be aimed: points differ, and all are finite.
    pub(super) fn has_volume(&self) -> bool {
        let diagonal = self.diagonal();
        diagonal > 0.0 && diagonal.is_finite()
    }

    fn center(&self) -> Vector {
        Vector(self.min).plus(Vector(self.max)).times(0.5)
    }

    fn diagonal(&self) -> f64 {
        Vector(self.max).minus(Vector(self.min)).length()
    }
}

/// Pixels along a side of a picture.
pub(super) const SIDE: usize = 1024;

/// Returns a ray through the center of each pixel of [`SIDE`] rows.
pub(super) fn primary(target: &Target) -> Vec<Ray> {
    pinhole(target, SIDE)
}

/// Returns a ray through the center of each pixel of a square picture, row by row.
pub(super) fn pinhole(target: &Target, side: usize) -> Vec<Ray> {
    let center = target.center();
    let eye = center.plus(Vector([0.6, 0.5, 0.7]).unit().times(0.8 * target.diagonal()));
    let forward = center.minus(eye).unit();
    let right = forward.cross(Vector([0.0, 0.0, 1.0])).unit();
    let up = right.cross(forward);
    let pixels = side as f64;
    (0..side * side)
        .map(|pixel| {
            let (x, y) = ((pixel % side) as f64, (pixel / side) as f64);
            let sx = 0.5 * (2.0 * (x + 0.5) / pixels - 1.0);
            let sy = 0.5 * (1.0 - 2.0 * (y + 0.5) / pixels);
            let direction = forward.plus(right.times(sx)).plus(up.times(sy)).unit();
            Ray::new(eye.single(), direction.single())
        })
        .collect()
}

/// Returns rays from random points of the box towards others.
pub(super) fn random(target: &Target, count: usize) -> Vec<Ray> {
    let mut random = Random::from_state(103);
    let size = Vector(target.max).minus(Vector(target.min));
    let mut point = || {
        let at = Vector([(); 3].map(|()| random.unit()));
        Vector(target.min).plus(at.map2(size, |a, b| a * b))
    };
    (0..count)
        .map(|_| {
            let (p, q) = (point(), point());
            Ray::new(p.single(), q.minus(p).unit().single())
        })
        .collect()
}

/// Returns rays that leave the primary hits: diffuse bounces, and shadow rays to a light above.
pub(super) fn secondary(
    target: &Target,
    primary: &[Ray],
    closest: impl Fn(&Ray) -> Option<rotund_geometry::Hit>,
) -> (Vec<Ray>, Vec<Ray>) {
    let (mut bounce, mut lamp) = (Random::from_state(101), Random::from_state(102));
    let (center, diagonal) = (target.center().0, target.diagonal());
    let (mut diffuse, mut shadow) = (Vec::new(), Vec::new());
    for ray in primary {
        let Some(hit) = closest(ray) else { continue };
        let (o, d) = (Vector::from_single(ray.origin), Vector::from_single(ray.direction));
        let mut n = Vector::from_single(hit.normal).unit();
        if n.dot(d) > 0.0 {
            n = n.times(-1.0);
        }
        let p = o.plus(d.times(f64::from(hit.t))).plus(n.times(1e-5 * diagonal));
        let mut w = n.plus(Vector::random_unit(&mut bounce));
        if w.dot(w) < 1e-12 {
            w = n;
        }
        diffuse.push(Ray::new(p.single(), w.unit().single()));
        let x = center[0] + (lamp.unit() - 0.5) * 0.5 * diagonal;
        let y = center[1] + (lamp.unit() - 0.5) * 0.5 * diagonal;
        let light = Vector([x, y, target.max[2] + 0.5 * diagonal]);
        let towards = Ray::new(p.single(), light.minus(p).single());
        shadow.push(Ray { t_max: 0.999, ..towards });
    }
    (diffuse, shadow)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_the_published_ones_to_the_bit() {
        assert_eq!(spheres(1_000_000, 1, 0.002).1, 0x0915_ef57_9e5f_da21);
        assert_eq!(cones(50_000).1, 0x8990_b660_83f1_cf0c);
        assert_eq!(patches(1000).1, 0x1613_fb93_455e_a7e8);
        assert_eq!(triangles(1000).1, 0xe700_bba1_7a89_c000);
    }
}
