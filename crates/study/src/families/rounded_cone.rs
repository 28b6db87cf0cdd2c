//! Hard cases of a ray and a rounded cone.

use glam::DVec3;
use rotund_geometry::{Ray, RoundedCone};

use super::{Curve, Families, Family, near_origin, toward, with_interval, with_length};
use crate::random::Random;

impl Families for RoundedCone {
    const FAMILIES: &'static [Family<Self>] = &[
        Family {
            name: "distance",
            why: "squares of the distance cancel",
            curve: Some(Curve::Distance),
            levels: &[4.0, 4e1, 4e2, 4e3, 4e4, 4e5, 4e6, 4e7],
            make: |r, d| {
                let b = usual(r);
                (b.shape(), aimed(r, &b, d))
            },
        },
        Family {
            name: "equal radii",
            why: "a cylinder has no apex",
            curve: None,
            levels: &[1.0],
            make: |r, _| of_radii(r, 3.0, 0.7, 0.7, 4.0),
        },
        Family {
            name: "nearly equal radii",
            why: "the apex is far away",
            curve: None,
            levels: &[1e-2, 1e-4, 1e-6, 1e-7],
            make: |r, gap| of_radii(r, 3.0, 0.7, 0.7 * (1.0 - gap), 4.0),
        },
        Family {
            name: "contained",
            why: "one ball holds the other",
            curve: None,
            levels: &[1.0],
            make: |r, _| of_radii(r, 0.4, 1.0, 0.5, 4.0),
        },
        Family {
            name: "nearly contained",
            why: "the body is a sliver",
            curve: None,
            levels: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
            make: |r, gap| of_radii(r, 0.5 * (1.0 + gap), 1.0, 0.5, 4.0),
        },
        Family {
            name: "coincident ends",
            why: "there is no axis",
            curve: None,
            levels: &[1.0],
            make: |r, _| {
                let r1 = if r.sign() > 0.0 { 1.0 } else { 0.5 };
                of_radii(r, 0.0, 1.0, r1, 4.0)
            },
        },
        Family {
            name: "long and thin",
            why: "radius and length differ",
            curve: None,
            levels: &[1e3, 1e4, 1e5],
            make: |r, l| of_radii(r, l * 0.01, 0.01, 0.005, l * 0.01),
        },
        Family {
            name: "short",
            why: "the balls nearly coincide",
            curve: None,
            levels: &[1e-1, 1e-3, 1e-5],
            make: |r, l| of_radii(r, l, 1.0, 1.0 - 0.5 * l, 4.0),
        },
        Family {
            name: "pointed",
            why: "one radius is zero",
            curve: None,
            levels: &[1.0],
            make: |r, _| of_radii(r, 3.0, 1.0, 0.0, 4.0),
        },
        Family {
            name: "parallel to the axis",
            why: "no quadratic part, or little",
            curve: None,
            levels: &[0.0, 1e-5, 1e-3],
            make: parallel,
        },
        Family {
            name: "along a generator",
            why: "the quadratic part vanishes",
            curve: None,
            levels: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
            make: generator,
        },
        Family {
            name: "grazing",
            why: "the discriminant is nearly zero",
            curve: Some(Curve::Grazing),
            levels: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
            make: |r, gap| grazing(r, gap, 10.0),
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
            name: "inside",
            why: "only the last crossing counts",
            curve: None,
            levels: &[1.0],
            make: inside,
        },
        Family {
            name: "on the surface",
            why: "t_min = 1e-4 hides the near crossing",
            curve: None,
            levels: &[1.0],
            make: |r, _| on_surface(r, 1e-4),
        },
        Family {
            name: "on the surface, t_min 0",
            why: "rounding decides the side",
            curve: None,
            levels: &[1.0],
            make: |r, _| on_surface(r, 0.0),
        },
        Family { name: "seam", why: "body and cap meet", curve: None, levels: &[1.0], make: seam },
        Family {
            name: "in front of a cap",
            why: "inside of the infinite cone",
            curve: None,
            levels: &[1.0],
            make: in_front,
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
            make: near_origin::cone,
        },
        Family {
            name: "slender, near the origin",
            why: "coordinates of the ends cancel, and nothing hides it",
            curve: None,
            levels: near_origin::SLENDER,
            make: near_origin::slender,
        },
        Family {
            name: "scale",
            why: "an absolute epsilon shows",
            curve: None,
            levels: &[1e-6, 1e-3, 1e3, 1e6],
            make: |r, s| of_radii(r, 3.0 * s, s, 0.5 * s, 4.0 * s),
        },
        Family {
            name: "direction length",
            why: "t counts in directions",
            curve: None,
            levels: &[3.0, 30.0],
            make: lengths,
        },
        Family {
            name: "denormal direction",
            why: "its square underflows",
            curve: None,
            levels: &[1.0],
            make: denormal,
        },
        Family {
            name: "interval",
            why: "its ends lie about the crossings",
            curve: None,
            levels: &[1.0],
            make: |r, _| {
                let b = usual(r);
                let ray = aimed(r, &b, 4.0);
                (b.shape(), with_interval(r, &b.shape(), ray))
            },
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

/// A cone before rounding, along a unit axis.
struct Body {
    p0: DVec3,
    axis: DVec3,
    length: f64,
    r0: f64,
    r1: f64,
}

impl Body {
    fn shape(&self) -> RoundedCone {
        let p1 = self.p0 + self.axis * self.length;
        RoundedCone {
            p0: self.p0.as_vec3(),
            r0: self.r0 as f32,
            p1: p1.as_vec3(),
            r1: self.r1 as f32,
        }
    }

    fn radius(&self) -> f64 {
        self.r0.max(self.r1)
    }

    /// Returns center and radius of the ball at `s`.
    fn ball(&self, s: f64) -> (DVec3, f64) {
        (self.p0 + self.axis * (s * self.length), self.r0 + s * (self.r1 - self.r0))
    }

    /// Returns a normal of the body between the caps, and the direction of its generator.
    fn generator(&self, random: &mut Random) -> (DVec3, DVec3) {
        let out = random.perpendicular(self.axis);
        let sine = ((self.r0 - self.r1) / self.length).clamp(-1.0, 1.0);
        let cosine = (1.0 - sine * sine).sqrt();
        (out * cosine + self.axis * sine, self.axis * cosine - out * sine)
    }

    /// Returns a point of the surface, on a cap or the body, and its normal.
    fn surface(&self, random: &mut Random) -> (DVec3, DVec3) {
        let sine = (self.r0 - self.r1) / self.length;
        let (s, normal) = match random.index(2) {
            0 => (random.unit(), self.generator(random).0),
            _ => {
                let normal = random.direction();
                (if normal.dot(self.axis) > sine { 1.0 } else { 0.0 }, normal)
            }
        };
        let (center, radius) = self.ball(s);
        (center + normal * radius, normal)
    }
}

fn body(random: &mut Random, length: f64, r0: f64, r1: f64) -> Body {
    let axis = random.direction();
    let center = random.direction() * random.range(0.0, 2.0) * (r0.max(r1) + length / 3.0) / 2.0;
    Body { p0: center - axis * (0.5 * length), axis, length, r0, r1 }
}

/// Returns a cone of length 3 with radii 1 and 0.5.
fn usual(random: &mut Random) -> Body {
    body(random, 3.0, 1.0, 0.5)
}

/// Returns a ray from `distance` away at a point up to 1.25 radii beside the axis.
fn aimed(random: &mut Random, body: &Body, distance: f64) -> Ray {
    let direction = random.direction();
    let along = body.p0 + body.axis * (body.length * random.range(-0.15, 1.15));
    let aside = random.perpendicular(direction) * (1.25 * body.radius() * random.unit().sqrt());
    toward(along + aside, direction, distance)
}

fn of_radii(
    random: &mut Random,
    length: f64,
    r0: f64,
    r1: f64,
    distance: f64,
) -> (RoundedCone, Ray) {
    let body = body(random, length, r0, r1);
    let ray = aimed(random, &body, distance);
    (body.shape(), ray)
}

/// Returns a cone along a coordinate axis, a third of them cylinders, and a ray along that axis,
/// tilted by `tilt`.
fn parallel(random: &mut Random, tilt: f64) -> (RoundedCone, Ray) {
    let axis = [DVec3::X, DVec3::Y, DVec3::Z][random.index(3)] * random.sign();
    let r1 = [0.5, 1.0, 1.0 - 1e-5][random.index(3)];
    let body = Body { p0: axis * -1.5, axis, length: 3.0, r0: 1.0, r1 };
    let aside = random.perpendicular(axis) * (1.25 * random.unit().sqrt());
    let direction = (axis + random.perpendicular(axis) * tilt).normalize() * random.sign();
    let target = aside + axis * random.range(-1.5, 1.5);
    (body.shape(), toward(target, direction, 5.0))
}

fn generator(random: &mut Random, gap: f64) -> (RoundedCone, Ray) {
    let body = if random.sign() > 0.0 { usual(random) } else { body(random, 3.0, 0.7, 0.7) };
    let (normal, along) = body.generator(random);
    let point = body.p0 + normal * (body.r0 + random.sign() * gap);
    (body.shape(), toward(point, along * random.sign(), 10.0))
}

fn grazing(random: &mut Random, gap: f64, distance: f64) -> (RoundedCone, Ray) {
    let body = usual(random);
    let (normal, along) = body.generator(random);
    let angle = random.range(0.0, std::f64::consts::TAU);
    let direction = along * angle.cos() + normal.cross(along) * angle.sin();
    let (center, radius) = body.ball(random.unit());
    let point = center + normal * (radius + random.sign() * gap);
    (body.shape(), toward(point, direction, distance))
}

fn inside(random: &mut Random, _: f64) -> (RoundedCone, Ray) {
    let body = usual(random);
    let (center, radius) = body.ball(random.unit());
    let origin = center + random.ball() * (0.999 * radius);
    (body.shape(), Ray::new(origin.as_vec3(), random.direction().as_vec3()))
}

fn on_surface(random: &mut Random, t_min: f32) -> (RoundedCone, Ray) {
    let body = usual(random);
    let (point, normal) = body.surface(random);
    let direction = random.direction();
    let direction = if direction.dot(normal) > 0.0 { -direction } else { direction };
    (body.shape(), Ray { t_min, ..Ray::new(point.as_vec3(), direction.as_vec3()) })
}

fn seam(random: &mut Random, _: f64) -> (RoundedCone, Ray) {
    let body = usual(random);
    let (normal, _) = body.generator(random);
    let (center, radius) = body.ball(random.index(2) as f64);
    (body.shape(), toward(center + normal * radius, random.direction(), 10.0))
}

fn in_front(random: &mut Random, _: f64) -> (RoundedCone, Ray) {
    let body = usual(random);
    let beyond = body.p0 - body.axis * random.range(1.05, 3.0);
    let origin = beyond + random.perpendicular(body.axis) * random.range(0.0, 0.9);
    let (center, radius) = body.ball(random.unit());
    let direction = (center + random.ball() * (1.2 * radius) - origin).normalize();
    (body.shape(), Ray::new(origin.as_vec3(), direction.as_vec3()))
}

fn offset(random: &mut Random, offset: f64) -> (RoundedCone, Ray) {
    let by = random.direction() * offset;
    let mut body = usual(random);
    body.p0 += by;
    let ray = aimed(random, &body, 10.0);
    (body.shape(), ray)
}

/// Returns rays whose directions are 10^-level to 10^level long.
fn lengths(random: &mut Random, level: f64) -> (RoundedCone, Ray) {
    let (cone, ray) = of_radii(random, 3.0, 1.0, 0.5, 4.0);
    (cone, with_length(ray, 10f64.powf(random.range(-level, level))))
}

fn denormal(random: &mut Random, _: f64) -> (RoundedCone, Ray) {
    let (cone, ray) = of_radii(random, 3e-6, 1e-6, 5e-7, 1e-5);
    (cone, with_length(ray, 10f64.powf(random.range(-41.0, -38.0))))
}

fn mixed(random: &mut Random, _: f64) -> (RoundedCone, Ray) {
    let r0 = random.range(-40.0, 40.0).exp2();
    let r1 = r0 * random.range(-10.0, 0.0).exp2();
    let (r0, r1) = if random.sign() > 0.0 { (r0, r1) } else { (r1, r0) };
    let length = r0.max(r1) * random.range(-10.0, 10.0).exp2();
    let mut body = body(random, length, r0, r1);
    body.p0 += random.direction() * length * random.range(-10.0, 10.0).exp2();
    let distance = (length + r0.max(r1)) * random.range(0.5, 10.0).exp2();
    let ray = aimed(random, &body, distance);
    (body.shape(), with_length(ray, random.range(-20.0, 20.0).exp2()))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::truth::Truth;

    #[test]
    fn rays_in_front_of_a_cap_start_outside() {
        for i in 0..200 {
            let (cone, ray) = in_front(&mut Random::new(i), 1.0);
            let truth = Truth::of(&cone, &ray);
            let first = truth.crossings.first().map(|c| c.t.to_f64());
            assert!(first.is_none_or(|t| t > 0.0), "{cone:?} {ray:?}");
        }
    }

    #[test]
    fn shapes_are_what_they_say() {
        let random = &mut Random::new(5);
        let length = |c: RoundedCone| (c.p1 - c.p0).length();
        let (contained, _) = of_radii(random, 0.4, 1.0, 0.5, 4.0);
        assert!(length(contained) < contained.r0 - contained.r1);
        let (thin, ray) = of_radii(random, 1e3, 0.01, 0.005, 1e3);
        assert!((length(thin) / thin.r0 / 1e5 - 1.0).abs() < 1e-3, "{thin:?}");
        assert!((ray.direction.length() - 1.0).abs() < 1e-6);
        let (_, along) = parallel(random, 0.0);
        assert_eq!(along.direction.abs().max_element(), 1.0);
        assert_eq!(along.direction, along.direction.round());
        assert_ne!(along.direction, Vec3::ZERO);
    }
}
