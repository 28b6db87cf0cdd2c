//! `accuracy --unions COUNT`: are the boundaries of unions those that depth counting finds?
//!
//! For sets of balls and rounded cones that overlap, nest, touch, repeat and share balls, and for
//! the points and lines of scenes, the boundaries of the union along random rays are compared with
//! those of intervals in 106 bits, and points with the distance from every element in 106 bits. The
//! command fails if a decision is wrong.
//!
//! A *tie* is a decision that hangs on less than 2⁻⁹⁰ of the numbers compared. Truth cannot make
//! it, so either answer counts as right: whether two bodies are one, or whether a boundary on
//! which a ray starts counts. In the latter case the other boundaries of the ray are checked
//! all the same.

use std::ops::ControlFlow;

use anyhow::{Result, ensure};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rotund_bvh::{ConeTree, Packed, SphereTree, Start};
use rotund_geometry::{Ray, RoundedCone, Sphere};
use rotund_report::console::{Table, say};
use rotund_scene::{Elements, Scene, Shape};

use crate::random::Random;
use crate::truth::Exact;
use crate::wide::{Wide, Wide3};

/// Rays of a batch, which share the set.
const BATCH: u64 = 500;

/// The share of the numbers compared below which a decision is a tie: 2⁻⁹⁰.
const TIE: f64 = 1.0 / (1_u128 << 90) as f64;

/// A set of elements of one kind.
enum Set {
    Balls(Vec<Sphere>),
    Cones(Vec<RoundedCone>),
}

/// Counts of one family.
#[derive(Clone, Copy, Default)]
struct Tally {
    rays: u64,
    boundaries: u64,
    wrong: u64,
    ties: u64,
    points: u64,
    wrong_points: u64,
}

impl Tally {
    fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            boundaries: self.boundaries + other.boundaries,
            wrong: self.wrong + other.wrong,
            ties: self.ties + other.ties,
            points: self.points + other.points,
            wrong_points: self.wrong_points + other.wrong_points,
        }
    }
}

/// Checks at least `count` rays and as many points, over the families and the elements of `scenes`.
pub(crate) fn run(count: u64, seed: u64, scenes: &[(String, Scene)]) -> Result<()> {
    let mut families = families(seed);
    for (name, scene) in scenes {
        let sets: Vec<Set> = scene.shapes.iter().filter_map(set_of_shape).collect();
        ensure!(!sets.is_empty(), "{name} has no points or lines");
        families.extend(sets.into_iter().map(|set| (name.clone(), set)));
    }
    let each = count.div_ceil(families.len() as u64).next_multiple_of(BATCH);
    let mut table =
        Table::new(&["set", "elements", "rays", "boundaries", "wrong", "ties", "points", "wrong"]);
    let mut sum = Tally::default();
    for (name, set) in &families {
        let (elements, tally) = match set {
            Set::Balls(balls) => {
                (balls.len(), check(&SphereTree::build(balls), balls, name, each, seed))
            }
            Set::Cones(cones) => {
                (cones.len(), check(&ConeTree::build(cones), cones, name, each, seed))
            }
        };
        sum = sum.plus(tally);
        table.row(row(name, &elements.to_string(), &tally));
    }
    table.row(row("all", "", &sum));
    say(format!("{table}"))?;
    say("\nBoundaries of the union along random rays, and points in it, against depth counting\n\
         in 106 bits over all elements. A tie hangs on less than 2^-90 of what is compared.")?;
    ensure!(sum.wrong + sum.wrong_points == 0, "a boundary or a point is wrong");
    Ok(())
}

fn row(name: &str, elements: &str, tally: &Tally) -> Vec<String> {
    let Tally { rays, boundaries, wrong, ties, points, wrong_points } = *tally;
    let mut row = vec![name.to_owned(), elements.to_owned()];
    row.extend([rays, boundaries, wrong, ties, points, wrong_points].map(|n| n.to_string()));
    row
}

fn set_of_shape(shape: &Shape) -> Option<Set> {
    let ball = |vertex: u32| (shape.positions[vertex as usize], shape.radii[vertex as usize]);
    match &shape.elements {
        Elements::Points(count) => {
            let sphere = |(center, radius)| Sphere { center, radius };
            Some(Set::Balls((0..*count).map(ball).map(sphere).collect()))
        }
        Elements::Lines(lines) => {
            let cone = |[(p0, r0), (p1, r1)]: [(Vec3, f32); 2]| RoundedCone { p0, r0, p1, r1 };
            Some(Set::Cones(lines.iter().map(|line| cone(line.map(ball))).collect()))
        }
        Elements::Triangles(_) | Elements::Quads(_) => None,
    }
}

/// The sets of elements that are hard for a known reason.
fn families(seed: u64) -> Vec<(String, Set)> {
    let mut families = Vec::new();
    for (place, offset) in [("", 0.0), (", far", 1e4)] {
        let mut random = Random::of(seed, "unions", 0);
        let at = |p: DVec3| (p + DVec3::splat(offset)).as_vec3();
        let ball = |p: DVec3, radius: f64| Sphere { center: at(p), radius: radius as f32 };
        let overlapping: Vec<Sphere> =
            (0..300).map(|_| ball(random.ball(), random.range(0.05, 0.3))).collect();
        let nested = overlapping
            .iter()
            .flat_map(|&outer| {
                let inner = |share: f32| Sphere { radius: share * outer.radius, ..outer };
                // Inside, touching from inside, and larger by a rounding.
                let moved = outer.center + Vec3::X * (0.5 * outer.radius);
                let touching = Sphere { center: moved, radius: 0.5 * outer.radius };
                let larger = Sphere { radius: outer.radius.next_up(), ..outer };
                [outer, inner(0.5), inner(0.999), touching, larger]
            })
            .collect();
        // A grid whose neighbours touch, overlap by a rounding, or miss by one.
        let touching = (0..512)
            .map(|i| {
                let cell = DVec3::new((i % 8).into(), (i / 8 % 8).into(), (i / 64).into());
                let radius =
                    [0.125_f32, 0.125_f32.next_up(), 0.125_f32.next_down()][i as usize % 3];
                Sphere { center: at(0.25 * cell - 1.0), radius }
            })
            .collect();
        let cone = |p0: DVec3, r0: f64, p1: DVec3, r1: f64| RoundedCone {
            p0: at(p0),
            r0: r0 as f32,
            p1: at(p1),
            r1: r1 as f32,
        };
        let cones = (0..300)
            .map(|_| {
                let p0 = random.ball();
                let p1 = p0 + random.range(0.0, 0.6) * random.direction();
                cone(p0, random.range(0.0, 0.15), p1, random.range(0.01, 0.15))
            })
            .collect();
        let mut chains = Vec::new();
        for _ in 0..30 {
            let (mut p0, mut r0) = (random.ball(), random.range(0.02, 0.1));
            for _ in 0..16 {
                let p1 = p0 + random.range(0.02, 0.2) * random.direction();
                let r1 = if random.index(2) == 0 { r0 } else { random.range(0.02, 0.1) };
                chains.push(cone(p0, r0, p1, r1));
                (p0, r0) = (p1, r1);
            }
        }
        for (name, set) in [
            ("balls", Set::Balls(overlapping)),
            ("nested balls", Set::Balls(nested)),
            ("touching balls", Set::Balls(touching)),
            ("cones", Set::Cones(cones)),
            ("chains", Set::Cones(chains)),
        ] {
            families.push((format!("{name}{place}"), set));
        }
    }
    families
}

/// An element with what the truth needs.
trait Element: Exact {
    /// Returns the distance of a point from the solid, negative inside.
    fn outside(&self, point: Wide3) -> Wide;
    /// Returns whether a line or point may meet the element, with room for rounding in `f64`.
    fn may_meet(&self, from: DVec3, direction: DVec3) -> bool;
}

fn passes(center: DVec3, radius: f64, from: DVec3, direction: DVec3) -> bool {
    let x = center - from;
    let length = direction.length_squared();
    let distance = if length > 0.0 {
        x.cross(direction).length_squared() / length
    } else {
        x.length_squared()
    };
    let reach = radius * (1.0 + 1e-9) + 1e-9 * x.length();
    distance <= reach * reach
}

impl Element for Sphere {
    fn outside(&self, point: Wide3) -> Wide {
        (point - Wide3::from(self.center)).length() - Wide::from(self.radius)
    }

    fn may_meet(&self, from: DVec3, direction: DVec3) -> bool {
        passes(self.center.as_dvec3(), self.radius.into(), from, direction)
    }
}

impl Element for RoundedCone {
    fn outside(&self, point: Wide3) -> Wide {
        let (center, radius) = crate::truth::nearest_ball(self, point);
        (point - center).length() - radius
    }

    fn may_meet(&self, from: DVec3, direction: DVec3) -> bool {
        let (p0, p1) = (self.p0.as_dvec3(), self.p1.as_dvec3());
        let radius = 0.5 * p0.distance(p1) + f64::from(self.r0.max(self.r1));
        passes(0.5 * (p0 + p1), radius, from, direction)
    }
}

/// A tree over elements of the set, as far as the check needs it.
trait Union {
    fn boundaries(&self, ray: &Ray) -> Vec<(f32, bool)>;
    fn next(&self, ray: &Ray) -> Option<(f32, bool)>;
    fn contains(&self, point: Vec3) -> bool;
}

macro_rules! union_of {
    ($tree:ty) => {
        impl Union for $tree {
            fn boundaries(&self, ray: &Ray) -> Vec<(f32, bool)> {
                let mut found = Vec::new();
                _ = Packed::boundaries(self, ray, |crossing| {
                    found.push((crossing.hit.t, crossing.enters));
                    ControlFlow::Continue(())
                });
                found
            }

            fn next(&self, ray: &Ray) -> Option<(f32, bool)> {
                self.boundary(ray, Start::ByPosition).map(|next| (next.hit.t, next.enters))
            }

            fn contains(&self, point: Vec3) -> bool {
                Packed::contains(self, point)
            }
        }
    };
}

union_of!(SphereTree);
union_of!(ConeTree);

fn check<E: Element>(
    tree: &(impl Union + Sync),
    elements: &[E],
    name: &str,
    count: u64,
    seed: u64,
) -> Tally {
    let batch = |index: u64| {
        let mut random = Random::of(seed, name, index);
        let mut tally = Tally::default();
        for _ in 0..BATCH {
            let element = &elements[random.index(elements.len())];
            let (ray, point) = ray_and_point(element, &mut random);
            check_ray(tree, elements, &ray, &mut tally);
            tally.points += 1;
            let inside = elements.iter().any(|element| {
                element.may_meet(point.as_dvec3(), DVec3::ZERO)
                    && element.outside(point.into()) <= Wide::ZERO
            });
            tally.wrong_points += u64::from(tree.contains(point) != inside);
        }
        tally
    };
    (0..count / BATCH).into_par_iter().map(batch).reduce(Tally::default, Tally::plus)
}

/// Returns a ray through or past an element, from outside, from inside or from a surface, and a
/// point on or next to the element.
fn ray_and_point(element: &impl Element, random: &mut Random) -> (Ray, Vec3) {
    let (center, size) = (element.center().as_dvec3(), element.size());
    let direction = random.direction();
    let back = size * [0.0, 1.5, 30.0, 1e4][random.index(4)];
    let past = size * [random.unit(), 1.0 + 1e-7 * random.range(-1.0, 1.0)][random.index(2)];
    let origin = center + past * random.perpendicular(direction) - back * direction;
    let line = Ray::new(origin.as_vec3(), (direction * random.range(0.1, 10.0)).as_vec3());
    let on_surface = element
        .crossings(line.origin.into(), line.direction.into())
        .first()
        .map(|crossing| crossing.point.to_f64().as_vec3());
    let point = on_surface
        .filter(|_| random.index(2) == 0)
        .unwrap_or_else(|| (center + 1.2 * size * random.ball()).as_vec3());
    let from_surface = on_surface.filter(|_| random.index(3) == 0);
    let ray = match from_surface {
        Some(origin) => Ray::new(origin, random.direction().as_vec3()),
        None => line,
    };
    (ray, point)
}

/// Compares the boundaries along a ray with those of depth counting.
fn check_ray<E: Element>(tree: &impl Union, elements: &[E], ray: &Ray, tally: &mut Tally) {
    let (from, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let mut intervals: Vec<[Wide; 2]> = elements
        .iter()
        .filter(|element| element.may_meet(from, direction))
        .filter_map(|element| {
            let crossings = element.crossings(ray.origin.into(), ray.direction.into());
            Some([crossings.first()?.t, crossings.last()?.t])
        })
        .collect();
    intervals.sort_by(|a, b| a[0].partial_cmp(&b[0]).expect("no NaN"));
    let mut tie = false;
    let mut close = |x: Wide, y: Wide| {
        let scale = x.abs().max(y.abs()).to_f64();
        let equal = (x - y).abs().to_f64() <= TIE * scale;
        tie |= equal;
    };
    let mut bodies: Vec<[Wide; 2]> = Vec::new();
    for interval in intervals {
        match bodies.last_mut() {
            Some(body) if interval[0] <= body[1] => {
                close(interval[0], body[1]);
                body[1] = body[1].max(interval[1]);
            }
            last => {
                if let Some(body) = last {
                    close(interval[0], body[1]);
                }
                bodies.push(interval);
            }
        }
    }
    let mut expected = Vec::new();
    for [enter, leave] in bodies {
        let chord = (leave - enter).to_f64();
        for (t, enters) in [(enter, true), (leave, false)] {
            // The ray starts on this boundary: truth finds a `t` of some 2⁻¹⁰⁶ of the chord instead
            // of zero.
            let at_start = t.abs().to_f64() <= TIE * chord;
            if at_start || t >= Wide::ZERO {
                expected.push(Boundary { t, enters, at_start });
            }
        }
    }
    let found = tree.boundaries(ray);
    let all = agree(&found, &expected) && tree.next(ray) == found.first().copied();
    tally.rays += 1;
    tally.boundaries += expected.len() as u64;
    tally.ties += u64::from(tie || expected.iter().any(|boundary| boundary.at_start));
    tally.wrong += u64::from(!all && !tie);
}

/// A boundary of the union that depth counting finds.
struct Boundary {
    t: Wide,
    enters: bool,
    /// Whether the ray starts on it, so that it may count or not.
    at_start: bool,
}

/// Returns whether the boundaries found are those expected, but for those at the start of the ray.
fn agree(found: &[(f32, bool)], expected: &[Boundary]) -> bool {
    let mut found = found.iter().peekable();
    for boundary in expected {
        let is_it = |&&(t, enters): &&(f32, bool)| {
            let exact = boundary.t;
            let unit = (2f64.powi(-24) * exact.abs().to_f64()).max(2f64.powi(-149));
            let off = (Wide::from(t) - exact).abs().to_f64();
            let at_start = boundary.at_start && t == 0.0;
            enters == boundary.enters && (off <= 1.001 * unit || at_start)
        };
        if found.next_if(is_it).is_none() && !boundary.at_start {
            return false;
        }
    }
    found.next().is_none()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_boundary_of_any_family_is_wrong() {
        run(20_000, 3, &[]).expect("all decisions are right");
    }

    #[test]
    fn a_tree_that_lacks_an_element_is_found_out() {
        let balls: Vec<Sphere> =
            [0.0, 1.0].map(|x| Sphere { center: Vec3::X * x, radius: 0.75 }).to_vec();
        let tally = check(&SphereTree::build(&balls[..1]), &balls, "two", 10 * BATCH, 1);
        assert!(tally.wrong > 100 && tally.wrong_points > 100);
    }

    #[test]
    fn a_boundary_at_the_start_may_count_or_not_and_the_others_must() {
        let at = |t: f32, enters: bool, at_start: bool| Boundary { t: t.into(), enters, at_start };
        let on_entry = [at(1e-33, true, true), at(2.0, false, false), at(3.0, true, false)];
        assert!(agree(&[(0.0, true), (2.0, false), (3.0, true)], &on_entry));
        assert!(agree(&[(2.0, false), (3.0, true)], &on_entry));
        for wrong in [
            &[(0.0, true), (3.0, true)][..],
            &[(0.0, false), (2.0, false), (3.0, true)],
            &[(2.0, false)],
            &[(2.0, false), (3.0, true), (4.0, false)],
        ] {
            assert!(!agree(wrong, &on_entry), "{wrong:?}");
        }
    }
}
