//! Hard cases of a ray and a bilinear patch.

use glam::{DMat3, DVec3};
use rotund_geometry::{BilinearPatch, Ray};

use super::{Curve, Families, Family, near_origin, toward, with_interval, with_length};
use crate::random::Random;
use crate::truth::Truth;

/// The corners p00, p10, p01, p11.
type Corners = [DVec3; 4];

impl Families for BilinearPatch {
    const FAMILIES: &'static [Family<Self>] = &[
        Family {
            name: "distance",
            why: "coordinates of the ray cancel",
            curve: Some(Curve::Distance),
            levels: &[1.5, 1.5e1, 1.5e2, 1.5e3, 1.5e4, 1.5e5, 1.5e6, 1.5e7],
            make: |r, d| {
                let c = bent(r, 0.2);
                (patch(c), aimed(r, c, d))
            },
        },
        Family {
            name: "planar, z = 0",
            why: "no quadratic part, exactly",
            curve: None,
            levels: &[1.0],
            make: |r, _| {
                let c = jittered(r, 0.0);
                (patch(c), aimed(r, c, 3.0))
            },
        },
        Family {
            name: "planar, turned",
            why: "no quadratic part but rounding",
            curve: None,
            levels: &[1.0],
            make: |r, _| shown(r, |r| bent(r, 0.0)),
        },
        Family {
            name: "nearly planar",
            why: "the quadratic part is small",
            curve: None,
            levels: &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
            make: |r, h| {
                let c = bent(r, h);
                (patch(c), aimed(r, c, 3.0))
            },
        },
        Family {
            name: "in its plane",
            why: "the ray meets a planar patch nowhere, by definition",
            curve: None,
            levels: &[1.0],
            make: in_plane,
        },
        Family {
            name: "saddle",
            why: "bends as much as it is wide",
            curve: None,
            levels: &[1.0],
            make: |r, _| shown(r, |r| bent(r, 0.5)),
        },
        Family {
            name: "twisted by 150 degrees",
            why: "two crossings, folds",
            curve: None,
            levels: &[1.0],
            make: |r, _| shown(r, twisted),
        },
        Family {
            name: "parallelogram",
            why: "the quadratic part is exactly zero",
            curve: None,
            levels: &[1.0],
            make: |r, _| {
                exact(r, |r| {
                    let (q, e, f) = (grid(r), grid(r), grid(r));
                    [q, q + e, q + f, q + e + f]
                })
            },
        },
        Family {
            name: "trapezoid",
            why: "two edges are exactly parallel",
            curve: None,
            levels: &[1.0],
            make: |r, _| {
                exact(r, |r| {
                    let (q, e, f) = (grid(r), grid(r), grid(r));
                    [q, q + e, q + f, q + f + e * 0.5]
                })
            },
        },
        Family {
            name: "nearly a trapezoid",
            why: "two edges are nearly parallel",
            curve: None,
            levels: &[1e-3, 1e-5, 1e-7],
            make: near_trapezoid,
        },
        Family {
            name: "collapsed edge",
            why: "a triangle: the normal vanishes at a corner",
            curve: None,
            levels: &[0.0, 1.0, 2.0, 3.0],
            make: |r, edge| collapsed(r, edge),
        },
        Family {
            name: "bow tie",
            why: "the patch crosses itself",
            curve: None,
            levels: &[0.0, 0.2],
            make: |r, h| {
                shown(r, |r| {
                    let [a, b, c, d] = bent(r, h);
                    [a, b, d, c]
                })
            },
        },
        Family {
            name: "parallel to a ruling",
            why: "one segment of the patch lies along the ray",
            curve: None,
            levels: &[0.0, 1e-5, 1e-3],
            make: ruling,
        },
        Family {
            name: "grazing",
            why: "the ray passes a fold",
            curve: Some(Curve::Grazing),
            levels: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9],
            make: |r, gap| grazing(r, gap, 3.0),
        },
        Family {
            name: "far and grazing",
            why: "distance takes the digits that grazing needs",
            curve: None,
            levels: &[1e2, 1e4, 1e6, 1e7],
            make: |r, d| {
                let gap = 10f64.powf(r.range(-7.0, -1.0));
                grazing(r, gap, d)
            },
        },
        Family {
            name: "world offset",
            why: "coordinates have few digits left",
            curve: None,
            levels: &[1e3, 1e4, 1e5, 1e6],
            make: offset,
        },
        Family {
            name: "near the origin",
            why: "the position has no rounding that hides that of f64",
            curve: None,
            levels: near_origin::LEVELS,
            make: |r, level| {
                let corners = bent(r, 0.3);
                near_origin::patch(r, level, corners)
            },
        },
        Family {
            name: "sliver",
            why: "one side is 1e-4 of the other",
            curve: None,
            levels: &[1e-4],
            make: |r, w| {
                shown(r, |r| turned(r, jittered_by(0.2).map(|p| p * DVec3::new(1.0, w, 1.0))))
            },
        },
        Family {
            name: "near a corner",
            why: "both parameters are at their ends",
            curve: None,
            levels: &[1e-6],
            make: near_corner,
        },
        Family {
            name: "interval",
            why: "its ends lie about the crossings",
            curve: None,
            levels: &[1.0],
            make: |r, _| {
                let c = twisted(r);
                let ray = aimed(r, c, 3.0);
                (patch(c), with_interval(r, &patch(c), ray))
            },
        },
        Family {
            name: "from the surface",
            why: "t_min = 1e-4 hides a crossing",
            curve: None,
            levels: &[1.0],
            make: from_surface,
        },
        Family {
            name: "scale",
            why: "an absolute epsilon shows",
            curve: None,
            levels: &[1e-6, 1e-3, 1e3, 1e6],
            make: |r, s| {
                let c = bent(r, 0.3).map(|p| p * s);
                (patch(c), aimed(r, c, 3.0 * s))
            },
        },
        Family {
            name: "direction length",
            why: "t counts in directions",
            curve: None,
            levels: &[3.0, 30.0],
            make: |r, l| {
                let (p, ray) = shown(r, |r| bent(r, 0.3));
                (p, with_length(ray, 10f64.powf(r.range(-l, l))))
            },
        },
        Family {
            name: "denormal direction",
            why: "its square underflows",
            curve: None,
            levels: &[1.0],
            make: denormal,
        },
        Family {
            name: "mixed exponents",
            why: "no scale is preferred",
            curve: None,
            levels: &[1.0],
            make: mixed,
        },
    ];
}

fn patch([p00, p10, p01, p11]: Corners) -> BilinearPatch {
    let [p00, p10, p01, p11] = [p00, p10, p01, p11].map(|p| p.as_vec3());
    BilinearPatch { p00, p10, p01, p11 }
}

fn at([p00, p10, p01, p11]: Corners, u: f64, v: f64) -> DVec3 {
    (p00 * (1.0 - u) + p10 * u) * (1.0 - v) + (p01 * (1.0 - u) + p11 * u) * v
}

/// Returns a ray from `distance` away at a point in or somewhat beside the patch.
fn aimed(random: &mut Random, corners: Corners, distance: f64) -> Ray {
    let target = at(corners, random.range(-0.12, 1.12), random.range(-0.12, 1.12));
    toward(target, random.direction(), distance)
}

fn shown(random: &mut Random, make: impl Fn(&mut Random) -> Corners) -> (BilinearPatch, Ray) {
    let corners = make(random);
    (patch(corners), aimed(random, corners, 3.0))
}

/// Returns the unit square with two opposite corners raised by `height` and the others lowered.
fn jittered_by(height: f64) -> Corners {
    [(0.0, 0.0, -1.0), (1.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, -1.0)]
        .map(|(x, y, z)| DVec3::new(x - 0.5, y - 0.5, z * height))
}

/// Returns the same with each corner jittered by up to a tenth in the plane.
fn jittered(random: &mut Random, height: f64) -> Corners {
    jittered_by(height)
        .map(|p| p + DVec3::new(random.range(-0.1, 0.1), random.range(-0.1, 0.1), 0.0))
}

/// Transforms corners into a random frame about a random center.
fn turned(random: &mut Random, corners: Corners) -> Corners {
    let z = random.direction();
    let x = random.perpendicular(z);
    let frame = DMat3::from_cols(x, z.cross(x), z);
    let center = random.direction() * random.range(0.0, 2.0);
    corners.map(|p| center + frame * p)
}

fn bent(random: &mut Random, height: f64) -> Corners {
    let corners = jittered(random, height);
    turned(random, corners)
}

fn twisted(random: &mut Random) -> Corners {
    let half = 75f64.to_radians();
    let [a, b, c, d] = jittered(random, 0.0);
    let (back, forth) = (DMat3::from_rotation_y(-half), DMat3::from_rotation_y(half));
    turned(random, [back * a, back * b, forth * c, forth * d])
}

/// Returns a point of multiples of 1/32, so that sums of three need no rounding.
fn grid(random: &mut Random) -> DVec3 {
    random.ball().map(|x| (x * 32.0).round() / 32.0)
}

/// Returns a patch whose corners are not transformed, so that they stay exact.
fn exact(random: &mut Random, make: fn(&mut Random) -> Corners) -> (BilinearPatch, Ray) {
    let corners = make(random);
    (patch(corners), aimed(random, corners, 3.0))
}

fn near_trapezoid(random: &mut Random, gap: f64) -> (BilinearPatch, Ray) {
    let [a, b, c, _] = bent(random, 0.3);
    let corners = [a, b, c, c + (b - a) * 0.6 + random.direction() * gap];
    (patch(corners), aimed(random, corners, 3.0))
}

fn collapsed(random: &mut Random, edge: f64) -> (BilinearPatch, Ray) {
    let mut c = bent(random, 0.3);
    let (from, to) = [(0, 1), (2, 3), (0, 2), (1, 3)][edge as usize];
    c[to] = c[from];
    (patch(c), aimed(random, c, 3.0))
}

fn in_plane(random: &mut Random, _: f64) -> (BilinearPatch, Ray) {
    let corners = jittered(random, 0.0);
    let mut ray = aimed(random, corners, 3.0);
    (ray.origin.z, ray.direction.z) = (0.0, 0.0);
    (patch(corners), ray)
}

/// Returns a ray along the segment of one `u` or one `v`, tilted by `tilt`.
fn ruling(random: &mut Random, tilt: f64) -> (BilinearPatch, Ray) {
    let corners = bent(random, 0.5);
    let s = random.unit();
    let (from, to) = if random.sign() > 0.0 {
        (at(corners, s, 0.0), at(corners, s, 1.0))
    } else {
        (at(corners, 0.0, s), at(corners, 1.0, s))
    };
    let direction = (to - from).normalize();
    let direction = (direction + random.perpendicular(direction) * tilt).normalize();
    let target = at(corners, random.range(-0.12, 1.12), random.range(-0.12, 1.12));
    (patch(corners), toward(target, direction * random.sign(), 3.0))
}

/// Returns a ray in the tangent plane of a point, moved along the normal.
fn grazing(random: &mut Random, gap: f64, distance: f64) -> (BilinearPatch, Ray) {
    let corners = bent(random, 0.4);
    let (u, v) = (random.unit(), random.unit());
    let along_u = at(corners, 1.0, v) - at(corners, 0.0, v);
    let along_v = at(corners, u, 1.0) - at(corners, u, 0.0);
    let normal = along_u.cross(along_v).normalize();
    let direction = random.perpendicular(normal);
    let target = at(corners, u, v) + normal * (random.sign() * 0.3 * gap);
    (patch(corners), toward(target, direction, distance))
}

fn offset(random: &mut Random, offset: f64) -> (BilinearPatch, Ray) {
    let by = random.direction() * offset;
    let corners = bent(random, 0.3).map(|p| p + by);
    (patch(corners), aimed(random, corners, 3.0))
}

fn near_corner(random: &mut Random, gap: f64) -> (BilinearPatch, Ray) {
    let corners = bent(random, 0.3);
    let end = |random: &mut Random| random.index(2) as f64 + random.range(-gap, gap);
    let (u, v) = (end(random), end(random));
    (patch(corners), toward(at(corners, u, v), random.direction(), 3.0))
}

/// Returns a ray from one point of the patch to another.
fn from_surface(random: &mut Random, _: f64) -> (BilinearPatch, Ray) {
    let corners = twisted(random);
    let patch = patch(corners);
    let ray = aimed(random, corners, 3.0);
    let origin = Truth::of(&patch, &ray).first().map(|c| c.point.to_f64().as_vec3());
    let Some(origin) = origin else { return (patch, ray) };
    let again = at(corners, random.unit(), random.unit());
    let direction = (again - origin.as_dvec3()).normalize();
    (patch, Ray { t_min: 1e-4, ..Ray::new(origin, direction.as_vec3()) })
}

fn denormal(random: &mut Random, _: f64) -> (BilinearPatch, Ray) {
    let corners = bent(random, 0.3).map(|p| p * 1e-6);
    let ray = aimed(random, corners, 3e-6);
    (patch(corners), with_length(ray, 10f64.powf(random.range(-41.0, -38.0))))
}

fn mixed(random: &mut Random, _: f64) -> (BilinearPatch, Ray) {
    let size = random.range(-40.0, 40.0).exp2();
    let by = random.direction() * size * random.range(-10.0, 10.0).exp2();
    let stretch = DVec3::new(1.0, random.range(-6.0, 0.0).exp2(), 1.0);
    let corners = jittered_by(random.range(-10.0, 0.0).exp2());
    let corners = turned(random, corners.map(|p| p * stretch)).map(|p| p * size + by);
    let distance = size * random.range(0.5, 10.0).exp2();
    let ray = aimed(random, corners, distance);
    (patch(corners), with_length(ray, random.range(-20.0, 20.0).exp2()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parallelogram_has_no_bilinear_part_at_all() {
        let row =
            BilinearPatch::FAMILIES.iter().find(|f| f.name == "parallelogram").expect("family");
        for i in 0..100 {
            let (p, _) = (row.make)(&mut Random::new(i), 1.0);
            assert_eq!((p.p11 - p.p10) - (p.p01 - p.p00), glam::Vec3::ZERO, "{p:?}");
        }
    }

    #[test]
    fn each_collapsed_edge_is_another_one() {
        for (edge, same) in [(0.0, (0, 1)), (1.0, (2, 3)), (2.0, (0, 2)), (3.0, (1, 3))] {
            let (p, _) = collapsed(&mut Random::new(1), edge);
            let corners = [p.p00, p.p10, p.p01, p.p11];
            let equal: Vec<_> = (0..4)
                .flat_map(|i| (i + 1..4).map(move |j| (i, j)))
                .filter(|&(i, j)| corners[i] == corners[j])
                .collect();
            assert_eq!(equal, [same]);
        }
    }

    #[test]
    fn twisted_patches_are_met_twice_by_some_rays() {
        let mut twice = 0;
        for i in 0..500 {
            let random = &mut Random::new(i);
            let corners = twisted(random);
            let ray = aimed(random, corners, 3.0);
            twice += usize::from(Truth::of(&patch(corners), &ray).crossings.len() == 2);
        }
        assert!(twice > 10, "{twice}");
    }
}
