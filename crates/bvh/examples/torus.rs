//! A primitive of your own: tori in a [`Bvh`], picked by ray.
//!
//! A type that implements [`Primitive`] is all that [`Bvh::build_of`], [`Bvh::closest_of`] and
//! [`Bvh::any_of`] need.

use rotund_bvh::Bvh;
use rotund_bvh::geometry::glam::{DVec3, Vec2, Vec3};
use rotund_bvh::geometry::{Aabb, Hit, Primitive, Ray, rounding_error};
use std::f64::consts::TAU;

/// The points at the distance `minor` from a circle of radius `major` about `center`, across
/// `axis`, with `0 < minor < major`.
///
/// `uv.x` turns about the axis and `uv.y` about the tube. The normal points out of the tube.
struct Torus {
    center: Vec3,
    /// Of any length but zero.
    axis: Vec3,
    major: f32,
    minor: f32,
}

impl Torus {
    /// Two unit vectors across the axis, and the axis as a unit vector.
    fn frame(&self) -> [DVec3; 3] {
        let axis = self.axis.as_dvec3().normalize();
        let (x, y) = axis.any_orthonormal_pair();
        [x, y, axis]
    }

    /// The directions from the center to the circle, and from the circle to the surface.
    fn directions(&self, uv: Vec2) -> [DVec3; 2] {
        let [x, y, axis] = self.frame();
        let [u, v] = [uv.x, uv.y].map(|turn| (TAU * f64::from(turn)).sin_cos());
        let outwards = u.1 * x + u.0 * y;
        [outwards, v.1 * outwards + v.0 * axis]
    }

    /// The point of the surface in the given directions, rounded once.
    fn point(&self, [outwards, normal]: [DVec3; 2]) -> Vec3 {
        let [major, minor] = [self.major, self.minor].map(f64::from);
        (self.center.as_dvec3() + major * outwards + minor * normal).as_vec3()
    }
}

impl Primitive for Torus {
    fn bounds(&self) -> Aabb {
        let [.., axis] = self.frame();
        let across = (1.0 - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
        let extent = f64::from(self.major) * across + f64::from(self.minor);
        let center = self.center.as_dvec3();
        Aabb {
            min: (center - extent).as_vec3().map(f32::next_down),
            max: (center + extent).as_vec3().map(f32::next_up),
        }
    }

    /// Solves the quartic in `f64`, for the point of the ray closest to the center as its origin,
    /// so that the distance of the ray costs no digits.
    ///
    /// The reported point lies on the surface up to its rounding to `f32`.
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let [x, y, axis] = self.frame();
        // Lengths are in units of the outer radius.
        let unit = f64::from(self.major) + f64::from(self.minor);
        let [major, minor] = [self.major, self.minor].map(|radius| f64::from(radius) / unit);
        let length = ray.direction.as_dvec3().length();
        let d = ray.direction.as_dvec3() / length;
        let start = (ray.origin.as_dvec3() - self.center.as_dvec3()) / unit;
        let shift = -start.dot(d);
        let o = start + shift * d;

        // A point p = o + s d of the surface satisfies (p·p + R² - r²)² = 4 R² (p·p - (p·axis)²).
        let (b, c) = (o.dot(d), o.length_squared());
        let (h0, h1) = (o.dot(axis), d.dot(axis));
        let k = c + major * major - minor * minor;
        let four = 4.0 * major * major;
        let quartic = [
            k * k - four * (c - h0 * h0),
            4.0 * b * k - 2.0 * four * (b - h0 * h1),
            4.0 * b * b + 2.0 * k - four * (1.0 - h1 * h1),
            4.0 * b,
            1.0,
        ];
        // The ray inside a ball around the torus, slightly larger than needed. Outside, and for a
        // NaN in the ray or the torus, this is NaN, and there are no roots.
        let reach = (1.001 - c).sqrt();
        let first = |s: &f64| Some((*s, ray.accept((shift + s) * unit / length)?));
        let (s, t) = roots(quartic, [-reach, reach]).iter().find_map(first)?;

        let p = o + s * d;
        let outwards = (p - p.dot(axis) * axis).normalize();
        let normal = (p - major * outwards).normalize();
        let position = self.point([outwards, normal]);
        let turn = |sin: f64, cos: f64| (sin.atan2(cos) / TAU).rem_euclid(1.0) as f32;
        Some(Hit {
            t,
            position,
            error: rounding_error(position),
            normal: normal.as_vec3(),
            parameters: Vec2::new(
                turn(outwards.dot(y), outwards.dot(x)),
                turn(normal.dot(axis), normal.dot(outwards)),
            ),
        })
    }

    fn position(&self, uv: Vec2) -> Vec3 {
        self.point(self.directions(uv))
    }

    fn normal(&self, uv: Vec2) -> Vec3 {
        self.directions(uv)[1].as_vec3()
    }
}

/// Returns the real roots of `q[0] + q[1] s + ... + q[4] s⁴` between `low` and `high`, in
/// increasing order.
///
/// Between two neighboring roots of its derivative a polynomial is monotone and has at most one
/// root. So the roots of each derivative bracket those of the next lower one, down to the quartic.
/// A double root is found twice or not at all.
fn roots(q: [f64; 5], [low, high]: [f64; 2]) -> Vec<f64> {
    let polynomials = [
        [6.0 * q[3], 24.0 * q[4], 0.0, 0.0, 0.0],
        [2.0 * q[2], 6.0 * q[3], 12.0 * q[4], 0.0, 0.0],
        [q[1], 2.0 * q[2], 3.0 * q[3], 4.0 * q[4], 0.0],
        q,
    ];
    polynomials.iter().fold(Vec::new(), |stops, polynomial| {
        let (mut found, mut from) = (Vec::with_capacity(4), low);
        for to in stops.into_iter().chain([high]) {
            found.extend(root(polynomial, [from, to]));
            from = to;
        }
        found
    })
}

/// Returns the root of a polynomial that is monotone between `low` and `high`, by Newton's method
/// with bisection where that does not converge.
fn root(polynomial: &[f64; 5], [mut low, mut high]: [f64; 2]) -> Option<f64> {
    let evaluate = |s: f64| {
        let horner = |(value, slope), c| (value * s + c, slope * s + value);
        polynomial.iter().rev().copied().fold((0.0, 0.0), horner)
    };
    let low_is_negative = evaluate(low).0 < 0.0;
    if low_is_negative == (evaluate(high).0 < 0.0) {
        return None;
    }
    let (mut s, mut step) = (0.5 * (low + high), high - low);
    while step.abs() > 1e-15 {
        let (value, slope) = evaluate(s);
        let bound = if (value < 0.0) == low_is_negative { &mut low } else { &mut high };
        *bound = s;
        let newton = value / slope;
        let converges = low < s - newton && s - newton < high && newton.abs() < 0.5 * step.abs();
        step = if converges { newton } else { s - 0.5 * (low + high) };
        s -= step;
    }
    Some(s)
}

/// Builds a chain of links and picks some of them.
pub(crate) fn main() {
    let ring = Torus { center: Vec3::ZERO, axis: Vec3::Z, major: 2.0, minor: 0.5 };
    let known_hits = [
        ("from outside, in the plane", [5.0, 0.0, 0.0], [-1.0, 0.0, 0.0], Some(2.5)),
        ("onto the crest, direction of length 2", [2.0, 0.0, 5.0], [0.0, 0.0, -2.0], Some(2.25)),
        ("through the hole", [0.1, 0.0, 5.0], [0.0, 0.0, -1.0], None),
        ("from the middle of the hole", [0.0, 0.0, 0.0], [0.0, -1.0, 0.0], Some(1.5)),
        ("from inside the tube", [2.0, 0.0, 0.0], [1.0, 0.0, 0.0], Some(0.5)),
        ("past the rim", [-5.0, 2.5001, 0.0], [1.0, 0.0, 0.0], None),
        ("from a million radii away", [3e6, 0.0, 0.0], [-1.0, 0.0, 0.0], Some(2_999_997.5)),
        ("not finite", [5.0, 0.0, f32::NAN], [-1.0, 0.0, 0.0], None),
    ];
    for (why, origin, direction, t) in known_hits {
        let hit = ring.closest(&Ray::new(origin.into(), direction.into()));
        assert_eq!(hit.map(|hit| hit.t), t, "{why}");
    }

    let chain: Vec<Torus> = (0..1000)
        .map(|i| Torus {
            center: Vec3::X * 1.4 * i as f32,
            axis: if i % 2 == 0 { Vec3::Z } else { Vec3::Y },
            major: 1.0,
            minor: 0.25,
        })
        .collect();
    let tree = Bvh::build_of(&chain);

    let down = Ray::new(Vec3::new(14.0, 1.0, 5.0), Vec3::NEG_Z);
    let picked = tree.closest_of(&chain, &down).expect("the ray is aimed at the side of link 10");
    assert_eq!((picked.id, picked.hit.t, picked.hit.normal), (10, 4.75, Vec3::Z));
    let to_the_light = picked.hit.spawn_to(Vec3::new(14.0, 1.0, 100.0));
    assert!(!tree.any_of(&chain, &to_the_light), "nothing is between the link and the light");

    // The answer is that of a loop, and uv leads back to the point.
    for i in 0..200 {
        let target = Vec3::new(7.0 * i as f32, (0.1 * i as f32).sin(), (0.07 * i as f32).cos());
        let origin = Vec3::new(700.0, 300.0, -200.0);
        let ray = Ray::new(origin, target - origin);
        let hits =
            chain.iter().enumerate().filter_map(|(id, link)| Some((link.closest(&ray)?, id)));
        let nearest = hits.min_by(|(a, _), (b, _)| a.t.partial_cmp(&b.t).expect("no t is NaN"));
        let found = tree.closest_of(&chain, &ray);
        assert_eq!(found.map(|found| (found.hit, found.id as usize)), nearest, "{ray:?}");
        assert_eq!(tree.any_of(&chain, &ray), nearest.is_some(), "{ray:?}");
        if let Some((hit, id)) = nearest {
            let again = chain[id].position(chain[id].uv(&hit));
            assert!(again.distance(hit.position) < 2e-6 + 2.0 * hit.error, "{hit:?}: {again}");
        }
    }
}
