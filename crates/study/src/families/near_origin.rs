//! Hits next to the origin of coordinates, on shapes that pass through it. There the rounding to
//! `f32` vanishes, and a bound on it alone does not cover what `f64` has lost.
//!
//! Shapes and rays need no rounding: the surface contains the origin, or nearly does, and the line
//! of the ray passes it at a given distance.

use glam::{DVec3, Vec3};
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Sphere};

use crate::random::Random;

/// The distances at which lines pass the origin, in sizes of the shape.
pub(super) const LEVELS: &[f64] = &[0.0, 1e-12, 1e-9, 1e-6, 1e-3];

/// The lengths of slender cones, in radii.
pub(super) const SLENDER: &[f64] = &[1e2, 1e4, 1e5, 1e6, 1e7];

/// Integer vectors of integer length, so that a sphere about them contains the origin exactly.
const TRIPLES: [([f32; 3], f32); 8] = [
    ([0.0, 0.0, 1.0], 1.0),
    ([0.0, 3.0, 4.0], 5.0),
    ([1.0, 2.0, 2.0], 3.0),
    ([2.0, 3.0, 6.0], 7.0),
    ([1.0, 4.0, 8.0], 9.0),
    ([6.0, 6.0, 7.0], 11.0),
    ([2.0, 10.0, 11.0], 15.0),
    ([8.0, 9.0, 12.0], 17.0),
];

pub(super) fn sphere(random: &mut Random, level: f64) -> (Sphere, Ray) {
    let (out, center, radius) = ball(random);
    let ray = through(random, out, level * f64::from(radius), f64::from(radius));
    (Sphere { center, radius }, ray)
}

/// Returns a cylinder along the tangent plane of the origin, or a cone whose cap contains it.
pub(super) fn cone(random: &mut Random, level: f64) -> (RoundedCone, Ray) {
    if random.sign() > 0.0 {
        let (length, share) = (random.range(1.0, 16.0), random.range(0.02, 1.0));
        let turn = Turn::new(random);
        let (mut cone, out) = along_tangent(random, length, share * length);
        cone.r1 = cone.r0;
        let ray = through(random, turn.of(out), level * length, length);
        return (turn.cone(cone), ray);
    }
    let (out, p0, r0) = ball(random);
    let axis = random.direction();
    let axis = if axis.dot(out.as_dvec3()) > 0.0 { -axis } else { axis };
    let length = f64::from(r0) * random.range(0.5, 10.0);
    let p1 = p0 + (axis * length).as_vec3();
    // A cone as wide as its first ball or narrower, so that the cap is half of the ball.
    let cone = RoundedCone { p0, r0, p1, r1: r0 * random.range(0.0, 1.0) as f32 };
    (cone, through(random, out, level * length, length))
}

/// Returns a cone of this length in radii, and a ray at a point within a radius of the origin.
pub(super) fn slender(random: &mut Random, level: f64) -> (RoundedCone, Ray) {
    let length = random.range(1.0, 16.0);
    let turn = Turn::new(random);
    let (mut cone, out) = along_tangent(random, length, length / level);
    if random.index(2) == 0 {
        // Tapered: the distance of the axis follows from the radii, and is rounded.
        cone.r1 = cone.r0 * random.range(0.2, 1.0) as f32;
        let (a, from) = ((cone.p1 - cone.p0).as_dvec3(), cone.p0.as_dvec3());
        let (square, delta) = (a.length_squared(), f64::from(cone.r0) - f64::from(cone.r1));
        let along = from.truncate().length() * a.length();
        let apart = (f64::from(cone.r0) * square - along * delta)
            / (a.length() * (square - delta * delta).sqrt());
        (cone.p0.z, cone.p1.z) = (-apart as f32, -apart as f32);
    }
    let aside = f64::from(cone.r0) * 10f64.powf(random.range(-12.0, 0.0));
    (turn.cone(cone), through(random, turn.of(out), aside, length))
}

/// Returns a patch whose corners have the sum zero, so that its middle is the origin.
pub(super) fn patch(random: &mut Random, level: f64, corners: [DVec3; 4]) -> (BilinearPatch, Ray) {
    let scale = scale(random);
    let middle = corners.iter().sum::<DVec3>() / 4.0;
    let grid = |p: DVec3| ((p - middle) * 65_536.0).round().as_vec3() / 65_536.0;
    let [p00, p10, p01] = [0, 1, 2].map(|i| scale * grid(corners[i]));
    let p11 = -(p00 + p10 + p01);
    let normal = ((p10 - p00) + (p11 - p01)).cross((p01 - p00) + (p11 - p10));
    let size = f64::from(scale);
    let out = normal * random.sign() as f32;
    let ray = through(random, out, level * size, size);
    (BilinearPatch { p00, p10, p01, p11 }, ray)
}

/// Returns a power of two.
fn scale(random: &mut Random) -> f32 {
    2f32.powi(random.index(41) as i32 - 20)
}

/// Returns the normal at the origin, the center and the radius of a ball that touches it.
fn ball(random: &mut Random) -> (Vec3, Vec3, f32) {
    let (out, radius) = TRIPLES[random.index(TRIPLES.len())];
    let (out, scale) = (Turn::new(random).of(out.into()), scale(random));
    (out, -scale * out, scale * radius)
}

/// Returns a cylinder parallel to the plane `z = 0`, which touches the origin from below, and the
/// normal there. The ends are multiples of one vector by powers of two, so that none is rounded.
fn along_tangent(random: &mut Random, length: f64, radius: f64) -> (RoundedCone, Vec3) {
    let angle = random.range(0.0, std::f64::consts::TAU);
    let along = (DVec3::new(angle.cos(), angle.sin(), 0.0) * (0.5 * length)).as_vec3();
    let r = radius as f32;
    let below = Vec3::new(0.0, 0.0, -r);
    let share = |random: &mut Random| 2f32.powi(-(random.index(4) as i32));
    let (p0, p1) = (below - along * share(random), below + along * share(random));
    (RoundedCone { p0, r0: r, p1, r1: r }, Vec3::Z)
}

/// Returns a ray from the side of `out` whose line passes the origin at the distance `aside`.
fn through(random: &mut Random, out: Vec3, aside: f64, size: f64) -> Ray {
    let mut direction = random.direction().as_vec3();
    let across = random.index(3);
    direction[across] = 0.0;
    if direction.dot(out) > 0.0 {
        direction = -direction;
    }
    // The direction times a power of two.
    let back = (size.log2().ceil() + random.range(0.0, 12.0)).floor().exp2() as f32;
    let mut origin = -back * direction;
    origin[across] = (random.sign() * aside) as f32;
    Ray::new(origin, direction)
}

/// A permutation of the axes, some of them mirrored.
#[derive(Clone, Copy)]
struct Turn {
    axes: [usize; 3],
    signs: Vec3,
}

impl Turn {
    fn new(random: &mut Random) -> Self {
        let first = random.index(3);
        let (second, third) = ((first + 1) % 3, (first + 2) % 3);
        let axes =
            if random.sign() > 0.0 { [first, second, third] } else { [first, third, second] };
        let signs = [0; 3].map(|_| random.sign() as f32).into();
        Self { axes, signs }
    }

    fn of(self, p: Vec3) -> Vec3 {
        self.signs * Vec3::from_array(self.axes.map(|axis| p[axis]))
    }

    fn cone(self, cone: RoundedCone) -> RoundedCone {
        RoundedCone { p0: self.of(cone.p0), p1: self.of(cone.p1), ..cone }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::{Exact, Truth};

    /// Returns the distances of hits from the origin in sizes, in order.
    fn distances<S: Exact>(make: impl Fn(&mut Random) -> (S, Ray)) -> Vec<f64> {
        let mut distances = Vec::new();
        for i in 0..500 {
            let (shape, ray) = make(&mut Random::new(i));
            // A ray along the tangent plane may hit far away, or not at all.
            if let Some(hit) = Truth::of(&shape, &ray).first()
                && hit.normal.dot(ray.direction.as_dvec3().normalize()).abs() > 0.01
            {
                distances.push(hit.point.to_f64().length() / shape.size());
            }
        }
        assert!(distances.len() > 300, "{} rays hit", distances.len());
        distances.sort_by(f64::total_cmp);
        distances
    }

    fn farthest<S: Exact>(make: impl Fn(&mut Random) -> (S, Ray)) -> f64 {
        distances(make).last().copied().expect("rays hit")
    }

    #[test]
    fn rays_hit_where_they_say() {
        for level in [1e-12, 1e-6] {
            let corners = |random: &mut Random| {
                [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
                    .map(|[x, y]| DVec3::new(x, y, 0.0) + 0.2 * random.ball())
            };
            let far = [
                farthest(|random| sphere(random, level)),
                farthest(|random| cone(random, level)),
                {
                    // Some rays meet a bent patch elsewhere first.
                    let distances = distances(|random| {
                        let corners = corners(random);
                        patch(random, level, corners)
                    });
                    distances[distances.len() * 19 / 20]
                },
            ];
            assert!(far.iter().all(|far| *far < 1e3 * level), "{far:?} at {level}");
        }
        let far = farthest(|random| slender(random, 1e6));
        assert!(far < 1e-3, "{far}");
    }
}
