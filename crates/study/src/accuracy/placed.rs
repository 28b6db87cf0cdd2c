//! Hits of instances: do the bounds of hits hold in world space, in frames of every kind?
//!
//! Elements are placed by frames that rotate, scale, flatten, shear, mirror and translate far, down
//! to sizes of few roundings of the translation. The frame, as stored, is inverted in 106 bits. The
//! surface must lie within [`SceneHit::error`] of the position along the normal, and rays spawned
//! there must start on their side of it: those into a solid inside, others outside.

use glam::{Affine3A, Mat3, Vec3};
use rayon::prelude::*;
use rotund_geometry::{BilinearPatch, Ray, RoundedCone, Sphere};
use rotund_scene::{Material, Scene, SceneHit, Shape, Trees};

use super::round_trip::{flattening, frames};
use super::targets::{Verdict, short};
use crate::random::Random;
use crate::truth::Exact;
use crate::wide::{Wide, Wide3};

/// Rays aimed at each element.
const BATCH: u64 = 50;

/// Radii of curvature are at least this many roundings of the coordinates: with fewer, no number is
/// inside of a sphere for certain. Products with a rotated frame have more roundings, and where a
/// frame stretches, a step along the normal of the world moves across that of the object.
const LEAST: [f64; 2] = [10.0, 40.0];

/// An element that can be the only one of a scene.
trait Element: Exact {
    /// Returns a random element whose radii of curvature are about `size` or more.
    fn random(random: &mut Random, size: f64) -> Self;
    fn shape(self) -> Shape;
}

impl Element for Sphere {
    fn random(random: &mut Random, size: f64) -> Self {
        Self { center: random.ball().as_vec3(), radius: size as f32 }
    }

    fn shape(self) -> Shape {
        Shape::points([self.center], self.radius)
    }
}

impl Element for RoundedCone {
    fn random(random: &mut Random, size: f64) -> Self {
        let p0 = random.ball();
        let p1 = p0 + random.direction() * size * random.range(0.0, 9.0);
        let [r0, r1] = [0; 2].map(|_| (size * random.range(1.0, 2.0)) as f32);
        Self { p0: p0.as_vec3(), r0, p1: p1.as_vec3(), r1 }
    }

    fn shape(self) -> Shape {
        Shape::lines([self.p0, self.p1], vec![self.r0, self.r1], [[0, 1]])
    }
}

impl Element for BilinearPatch {
    fn random(random: &mut Random, size: f64) -> Self {
        let (middle, x) = (random.ball(), random.direction());
        let y = random.perpendicular(x);
        let mut corner =
            |a: f64, b: f64| (middle + size * (a * x + b * y + 0.5 * random.ball())).as_vec3();
        let (p00, p10) = (corner(-1.0, -1.0), corner(1.0, -1.0));
        Self { p00, p10, p01: corner(-1.0, 1.0), p11: corner(1.0, 1.0) }
    }

    fn shape(self) -> Shape {
        Shape::quads([self.p00, self.p10, self.p11, self.p01], [[0, 1, 2, 3]])
    }
}

/// Counts of one frame.
#[derive(Clone, Copy, Default)]
struct Tally {
    hits: u64,
    /// The largest distance of a surface from a hit, as a share of the bound.
    share: f64,
    outside_of_bound: u64,
    spawned: u64,
    wrong_side: u64,
}

/// Measures the elements of these names in all frames, with `rays` rays for each.
pub(crate) fn verdicts(rays: u64, seed: u64, is_wanted: impl Fn(&str) -> bool) -> Vec<Verdict> {
    type Measure = fn(u64, u64) -> Vec<Verdict>;
    let kinds: [(&str, Measure); 3] = [
        (Sphere::NAME, of_element::<Sphere>),
        (RoundedCone::NAME, of_element::<RoundedCone>),
        (BilinearPatch::NAME, of_element::<BilinearPatch>),
    ];
    let wanted = kinds.into_iter().filter(|(name, _)| is_wanted(name));
    wanted.flat_map(|(_, measure)| measure(rays, seed)).collect()
}

fn of_element<E: Element>(rays: u64, seed: u64) -> Vec<Verdict> {
    let moved = |by: f32| Affine3A::from_translation(Vec3::new(0.3 * by, by, -0.02 * by));
    let mut frames = frames();
    let turned = frames.iter().find(|(name, _)| *name == "turned").map(|(_, frame)| *frame);
    let turned = turned.unwrap_or_default();
    frames.extend([
        ("moved by 1e4", moved(1e4)),
        ("moved by 1e5", moved(1e5)),
        ("moved along y", Affine3A::from_translation(9_610.0 * Vec3::Y)),
        ("turned, at 1e4", moved(1e4) * turned),
        ("turned, at 1e5", moved(1e5) * turned),
    ]);
    let tallies: Vec<(&str, Tally)> = frames
        .par_iter()
        .map(|&(name, frame)| {
            let batch = |index: u64| {
                let name = format!("placed {} {name}", E::NAME);
                tally::<E>(&frame, &mut Random::of(seed, &name, index))
            };
            let tallies = (0..rays.div_ceil(BATCH)).into_par_iter().map(batch);
            (name, tallies.reduce(Tally::default, Tally::plus))
        })
        .collect();
    let verdict = |what, value: fn(&Tally) -> u64, of: fn(&Tally) -> u64| {
        let worst = tallies.iter().map(|(_, tally)| value(tally)).max().unwrap_or(0);
        let wrong = tallies.iter().filter(|(_, tally)| value(tally) > 0);
        let misses: Vec<String> = wrong
            .map(|(name, tally)| {
                let (value, of, share) = (value(tally), of(tally), short(tally.share));
                format!("{name}: {value} of {of}; the farthest is at {share} of its bound")
            })
            .collect();
        let (limit, met) = ("0".to_owned(), misses.is_empty());
        Verdict { shape: E::NAME, what, limit, worst: worst as f64, met, misses }
    };
    vec![
        verdict("hits of instances outside of their bound", |t| t.outside_of_bound, |t| t.hits),
        verdict("rays that leave instances on the wrong side", |t| t.wrong_side, |t| t.spawned),
    ]
}

impl Tally {
    fn plus(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            share: self.share.max(other.share),
            outside_of_bound: self.outside_of_bound + other.outside_of_bound,
            spawned: self.spawned + other.spawned,
            wrong_side: self.wrong_side + other.wrong_side,
        }
    }
}

/// Shoots rays at one random element.
fn tally<E: Element>(frame: &Affine3A, random: &mut Random) -> Tally {
    let object = ObjectSpace::of(frame);
    // What is one unit of the last place of the world, in object space.
    let stretch = flattening(frame);
    let far = frame.inverse().matrix3 * frame.translation;
    let far = (f64::from(far.length()) + stretch * stretch) * stretch;
    let is_moved = frame.matrix3 == glam::Mat3A::IDENTITY;
    let least = LEAST[usize::from(!is_moved)] * far * 2f64.powi(-24);
    let size = least * (1.0f64.max(0.7 / least)).powf(random.unit());
    let element = E::random(random, size);
    let mut scene = Scene::default();
    scene.add(element.shape(), Material::default());
    scene.instances[0].world_from_object = *frame;
    let trees = Trees::build(&scene).expect("the scene is valid");
    let mut tally = Tally::default();
    for _ in 0..BATCH {
        let size = element.size();
        let target = element.center().as_dvec3() + random.ball() * size;
        let origin = element.center().as_dvec3() + random.direction() * (10.0 * size + 1.0);
        let origin = frame.transform_point3(origin.as_vec3());
        let ray = Ray::new(origin, frame.transform_point3(target.as_vec3()) - origin);
        let Some(hit) = trees.closest(&scene, &ray) else { continue };
        tally.hits += 1;
        let along = object.crossings(&element, hit.position, hit.normal);
        let from_edge = hit.uv.min(1.0 - hit.uv).min_element();
        if !E::CONVEX && along.is_empty() && from_edge < 0.1 {
            // The line along the normal passes beside the edge.
            continue;
        }
        let apart = along.iter().map(|t| t.abs()).fold(f64::INFINITY, f64::min);
        tally.share = tally.share.max(apart / f64::from(hit.error));
        tally.outside_of_bound += u64::from(apart > f64::from(hit.error));
        for _ in 0..4 {
            let tangent = random.perpendicular(hit.normal.as_dvec3().normalize());
            let direction = [random.direction(), tangent + 1e-3 * random.direction()];
            let direction = direction[random.index(2)].as_vec3();
            tally.spawned += 1;
            let right = starts_right(&object, &element, &hit, direction)
                && (!E::CONVEX || finds_right(&scene, &trees, &hit, direction));
            tally.wrong_side += u64::from(!right);
        }
    }
    tally
}

/// Returns whether a spawned ray starts on its side of the surface.
fn starts_right<E: Element>(
    object: &ObjectSpace,
    element: &E,
    hit: &SceneHit,
    direction: Vec3,
) -> bool {
    let origin = hit.spawn(direction).origin;
    let outwards = hit.normal.as_dvec3().dot(direction.as_dvec3()) >= 0.0;
    let along = object.crossings(element, origin, hit.normal);
    if E::CONVEX {
        // Outwards, the solid lies behind the origin, or the line along the normal misses it.
        return if outwards {
            along.iter().all(|&t| t < 0.0)
        } else {
            along.len() == 2 && along[0] < 0.0 && along[1] > 0.0
        };
    }
    let nearest = along.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs()));
    // The line may pass beside the edge of a patch.
    nearest.is_none_or(|t| if outwards { t < 0.0 } else { t > 0.0 })
}

/// Returns whether the trees find a spawned ray on its side of a convex element.
fn finds_right(scene: &Scene, trees: &Trees, hit: &SceneHit, direction: Vec3) -> bool {
    let outwards = hit.normal.as_dvec3().dot(direction.as_dvec3()) >= 0.0;
    let next = trees.closest(scene, &hit.spawn(direction));
    next.is_some() != outwards
}

/// The inverse of a frame with 106 bits.
struct ObjectSpace {
    translation: Vec3,
    rows: [Wide3; 3],
    determinant: Wide,
}

impl ObjectSpace {
    fn of(frame: &Affine3A) -> Self {
        let matrix = Mat3::from(frame.matrix3);
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Wide3::from);
        let rows = [y.cross(z), z.cross(x), x.cross(y)];
        Self { translation: frame.translation.into(), rows, determinant: x.dot(rows[0]) }
    }

    fn vector(&self, v: Wide3) -> Wide3 {
        let [x, y, z] = self.rows.map(|row| row.dot(v) / self.determinant);
        Wide3 { x, y, z }
    }

    /// Returns where the line through a point of the world meets the element.
    fn crossings<E: Element>(&self, element: &E, point: Vec3, direction: Vec3) -> Vec<f64> {
        let origin = self.vector(Wide3::from(point) - Wide3::from(self.translation));
        let crossings = element.crossings(origin, self.vector(direction.into()));
        crossings.iter().map(|crossing| crossing.t.to_f64()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bounds_of_hits_hold_in_frames_of_every_kind() {
        for verdict in verdicts(2_000, 3, |_| true) {
            assert!(verdict.met, "{}, {}: {:#?}", verdict.shape, verdict.what, verdict.misses);
        }
    }

    #[test]
    fn the_inverse_leads_back() {
        for (name, frame) in frames() {
            let object = ObjectSpace::of(&frame);
            let p = Vec3::new(0.3, -0.7, 0.9);
            let there = Wide3::from(Mat3::from(frame.matrix3).as_dmat3() * p.as_dvec3());
            assert!(object.vector(there).to_f64().distance(p.as_dvec3()) < 1e-12, "{name}");
        }
    }
}
