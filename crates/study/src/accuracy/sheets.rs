//! Joints between shapes: sheets of patches that share edges and vertices, and chains of cones that
//! share a ball. A ray aimed at a joint must meet exactly one first surface.

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use rotund_geometry::{BilinearPatch, Ray, RoundedCone};
use serde::Serialize;

use super::methods::{Measured, Method};
use crate::random::Random;
use crate::truth::{Truth, unit_of};

/// Results of rays aimed at one kind of joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Joints {
    /// The kind of joint, and the distance of the origin.
    pub(crate) place: &'static str,
    pub(crate) method: &'static str,
    pub(crate) rays: usize,
    /// Rays that meet nothing.
    pub(crate) leaks: usize,
    /// Rays that meet two patches of a sheet that they cross once; for cones, rays whose hit is not
    /// on the first surface.
    pub(crate) doubles: usize,
}

/// How many rays one sheet or chain gets.
const RAYS_EACH: u64 = 16;

/// Measures all kinds of joints between patches.
pub(crate) fn sheets(methods: &[&Method<BilinearPatch>], rays: u64, seed: u64) -> Vec<Joints> {
    let places = [
        ("edge, distance 3", false, 3.0),
        ("vertex, distance 3", true, 3.0),
        ("edge, distance 1000", false, 1000.0),
        ("vertex, distance 1000", true, 1000.0),
    ];
    let shoot = |(place, vertex, distance)| {
        together(methods, place, rays, |sheet, count| {
            let random = &mut Random::of(seed, place, sheet);
            let vertices = sheet_of(random);
            let patches = patches_of(random, &vertices);
            for _ in 0..RAYS_EACH {
                let ray = aim(random, &vertices, vertex, distance);
                for (method, joints) in methods.iter().zip(&mut *count) {
                    let met =
                        patches.iter().filter(|p| (method.closest)(p, &ray).is_some()).count();
                    joints.leaks += usize::from(met == 0);
                    joints.doubles += usize::from(met > 1);
                }
            }
        })
    };
    places.into_iter().flat_map(shoot).collect()
}

/// Measures all kinds of joints between cones.
pub(crate) fn chains(methods: &[&Method<RoundedCone>], rays: u64, seed: u64) -> Vec<Joints> {
    let places = [("shared ball", false), ("touching circle", true)];
    let shoot = |(place, circle)| {
        together(methods, place, rays, |chain, count| {
            let random = &mut Random::of(seed, place, chain);
            let cones = chain_of(random);
            for _ in 0..RAYS_EACH {
                let ray = aim_at_joint(random, &cones, circle);
                let truths = cones.map(|cone| Truth::of(&cone, &ray));
                let first = truths
                    .iter()
                    .filter_map(|truth| truth.first().map(|c| c.t.to_f64()))
                    .reduce(f64::min);
                for (method, joints) in methods.iter().zip(&mut *count) {
                    let met = cones
                        .iter()
                        .filter_map(|cone| (method.closest)(cone, &ray).map(|h| f64::from(h.t)))
                        .reduce(f64::min);
                    let Some(t) = first else {
                        joints.doubles += usize::from(met.is_some());
                        continue;
                    };
                    let other = met.is_some_and(|found| (t - found).abs() > 8.0 * unit_of(t));
                    joints.leaks += usize::from(met.is_none());
                    joints.doubles += usize::from(other);
                }
            }
        })
    };
    places.into_iter().flat_map(shoot).collect()
}

/// Adds the counts of all sheets or chains, on all threads.
fn together<S: Measured>(
    methods: &[&Method<S>],
    place: &'static str,
    rays: u64,
    shoot: impl Fn(u64, &mut [Joints]) + Sync,
) -> Vec<Joints> {
    let nothing = || -> Vec<Joints> {
        methods.iter().map(|m| Joints { place, method: m.name, ..Joints::default() }).collect()
    };
    let add = |mut a: Vec<Joints>, b: Vec<Joints>| {
        for (a, b) in a.iter_mut().zip(b) {
            a.rays += b.rays;
            a.leaks += b.leaks;
            a.doubles += b.doubles;
        }
        a
    };
    (0..rays.div_ceil(RAYS_EACH))
        .into_par_iter()
        .map(|index| {
            let mut count = nothing();
            shoot(index, &mut count);
            count.iter_mut().for_each(|joints| joints.rays += RAYS_EACH as usize);
            count
        })
        .reduce(nothing, add)
}

/// Returns 3 x 3 vertices, jittered by up to 0.2 in the plane and 0.15 out of it, in a random
/// frame.
fn sheet_of(random: &mut Random) -> [Vec3; 9] {
    let z = random.direction();
    let x = random.perpendicular(z);
    let frame = DMat3::from_cols(x, z.cross(x), z);
    let center = random.direction() * random.range(0.0, 2.0);
    std::array::from_fn(|i| {
        let jitter =
            DVec3::new(random.range(-0.2, 0.2), random.range(-0.2, 0.2), random.range(-0.15, 0.15));
        let place = DVec3::new((i % 3) as f64 - 1.0, (i / 3) as f64 - 1.0, 0.0);
        (center + frame * (place + jitter)).as_vec3()
    })
}

/// Returns the four patches, each with one of the eight orders of its corners.
fn patches_of(random: &mut Random, vertices: &[Vec3; 9]) -> [BilinearPatch; 4] {
    [0, 1, 3, 4].map(|i| {
        let around = [i, i + 1, i + 4, i + 3].map(|j| vertices[j]);
        let (start, step) = (random.index(4), if random.sign() > 0.0 { 1 } else { 3 });
        let corner = |j: usize| around[(start + j * step) % 4];
        BilinearPatch { p00: corner(0), p10: corner(1), p11: corner(2), p01: corner(3) }
    })
}

/// Returns a ray at the middle vertex or an inner edge, in a direction along which no patch folds
/// over, so that it crosses the sheet exactly once.
fn aim(random: &mut Random, vertices: &[Vec3; 9], vertex: bool, distance: f64) -> Ray {
    let middle = vertices[4].as_dvec3();
    let target = if vertex {
        middle
    } else {
        let end = vertices[[1, 3, 5, 7][random.index(4)]].as_dvec3();
        middle.lerp(end, random.range(0.0, 0.99))
    };
    loop {
        let direction = random.direction();
        if !folds(vertices, direction) {
            return Ray::new((target - direction * distance).as_vec3(), direction.as_vec3());
        }
    }
}

/// Returns whether the sheet, projected along `direction`, folds over anywhere. The Jacobian of the
/// projection is linear in each parameter, so its signs at the corners of each patch decide.
fn folds(vertices: &[Vec3; 9], direction: DVec3) -> bool {
    let turn = |at: usize, right: usize, left: usize| {
        let [at, right, left] = [at, right, left].map(|i| vertices[i].as_dvec3());
        (right - at).cross(left - at).dot(direction)
    };
    let turns = [0usize, 1, 3, 4].map(|i| {
        [
            turn(i, i + 1, i + 3),
            turn(i + 1, i + 4, i),
            turn(i + 4, i + 3, i + 1),
            turn(i + 3, i, i + 4),
        ]
    });
    // The margin covers the rounding of the ray, which is 10⁻⁴ at the larger distance.
    let turns = turns.as_flattened();
    !(turns.iter().all(|&t| t > 0.05) || turns.iter().all(|&t| t < -0.05))
}

/// Returns two cones that share a ball and make any angle.
fn chain_of(random: &mut Random) -> [RoundedCone; 2] {
    let joint = (random.direction() * random.range(0.0, 2.0)).as_vec3();
    let radius = random.range(0.2, 0.6) as f32;
    let mut arm = || {
        let p1 = joint.as_dvec3() + random.direction() * random.range(0.5, 3.0);
        let r1 = random.range(0.1, 0.6) as f32;
        RoundedCone { p0: joint, r0: radius, p1: p1.as_vec3(), r1 }
    };
    let (mut first, second) = (arm(), arm());
    // The shared ball is p1 of the first cone and p0 of the second.
    (first.p0, first.p1, first.r0, first.r1) = (first.p1, first.p0, first.r1, first.r0);
    [first, second]
}

/// Returns a ray at the shared ball, or at the circle where it touches one of the cones.
fn aim_at_joint(random: &mut Random, cones: &[RoundedCone; 2], circle: bool) -> Ray {
    let (joint, radius) = (cones[1].p0.as_dvec3(), f64::from(cones[1].r0));
    let target = if circle {
        let [first, second] = cones;
        let (end, other) = if random.sign() > 0.0 {
            (first.p0.as_dvec3(), f64::from(first.r0))
        } else {
            (second.p1.as_dvec3(), f64::from(second.r1))
        };
        let axis = end - joint;
        let sine = ((radius - other) / axis.length()).clamp(-1.0, 1.0);
        let out = random.perpendicular(axis.normalize());
        joint + (out * (1.0 - sine * sine).sqrt() + axis.normalize() * sine) * radius
    } else {
        joint + random.ball() * radius
    };
    let direction = random.direction();
    let distance = [3.0, 30.0, 300.0][random.index(3)];
    Ray::new((target - direction * distance).as_vec3(), direction.as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::Exact;

    fn method<S>(closest: fn(&S, &Ray) -> Option<rotund_geometry::Hit>) -> Method<S> {
        Method::published("planted", closest)
    }

    #[test]
    fn a_sheet_is_crossed_once_and_truly_met() {
        for i in 0..200 {
            let random = &mut Random::new(i);
            let vertices = sheet_of(random);
            let patches = patches_of(random, &vertices);
            let ray = aim(random, &vertices, i % 2 == 0, 3.0);
            let crossings: usize = patches.iter().map(|p| Truth::of(p, &ray).crossings.len()).sum();
            assert_eq!(crossings, 1, "{i}");
        }
    }

    #[test]
    fn a_planted_gap_leaks_and_a_planted_overlap_doubles() {
        let smaller = method(|p: &BilinearPatch, ray| scaled(p, 0.99).closest(ray));
        let larger = method(|p: &BilinearPatch, ray| scaled(p, 1.01).closest(ray));
        let exact = method(BilinearPatch::closest);
        let found = sheets(&[&smaller, &larger, &exact], 320, 1);
        for three in found.chunks(3) {
            assert_eq!(three[0].rays, 320);
            assert_eq!((three[0].leaks, three[0].doubles), (320, 0), "{}", three[0].place);
            assert_eq!((three[1].leaks, three[1].doubles), (0, 320), "{}", three[1].place);
            assert_eq!((three[2].leaks, three[2].doubles), (0, 0), "{}", three[2].place);
        }
    }

    fn scaled(p: &BilinearPatch, by: f32) -> BilinearPatch {
        let center = p.center();
        let [p00, p10, p01, p11] = [p.p00, p.p10, p.p01, p.p11].map(|q| center + (q - center) * by);
        BilinearPatch { p00, p10, p01, p11 }
    }

    #[test]
    fn a_cone_without_its_cap_flashes_and_a_blind_one_leaks() {
        let blind = method(|_: &RoundedCone, _: &Ray| None);
        let last = method(|cone: &RoundedCone, ray: &Ray| {
            let near = cone.closest(ray)?;
            cone.closest(&Ray { t_min: near.t + 0.01, ..*ray })
        });
        let exact = method(RoundedCone::closest);
        for three in chains(&[&blind, &last, &exact], 320, 1).chunks(3) {
            assert!(three[0].leaks > 200 && three[0].doubles == 0, "{three:?}");
            assert!(three[1].doubles > 150, "{three:?}");
            assert_eq!((three[2].leaks, three[2].doubles), (0, 0), "{}", three[2].place);
        }
    }
}
