//! Hard cases of a ray and a sphere.

use glam::{DVec3, Vec3};
use rotund_geometry::{Ray, Sphere};

use super::{Curve, Families, Family, near_origin, toward, with_interval, with_length};
use crate::random::Random;

impl Families for Sphere {
    const FAMILIES: &'static [Family<Self>] = &[
        Family {
            name: "distance",
            why: "squares of the distance cancel",
            curve: Some(Curve::Distance),
            levels: &[1.5, 1.5e1, 1.5e2, 1.5e3, 1.5e4, 1.5e5, 1.5e6, 1.5e7],
            make: |r, d| from(r, 1.0, d),
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
            name: "tangent to the last bit",
            why: "passes by -3 to 3 roundings",
            curve: None,
            levels: &[1.0],
            make: tangent,
        },
        Family {
            name: "inside",
            why: "one root on each side",
            curve: None,
            levels: &[1.0],
            make: inside,
        },
        Family {
            name: "on the surface",
            why: "t_min = 1e-4 hides the near root",
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
            make: near_origin::sphere,
        },
        Family {
            name: "radius",
            why: "an absolute epsilon shows",
            curve: None,
            levels: &[1e-6, 1e-3, 1e3, 1e6],
            make: |r, radius| from(r, radius, 10.0),
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
            why: "its ends lie about the roots",
            curve: None,
            levels: &[1.0],
            make: |r, _| {
                let (s, ray) = from(r, 1.0, 3.0);
                (s, with_interval(r, &s, ray))
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

/// Returns a sphere, and a ray from `distance` radii away at a disc of 1.2 radii.
fn from(random: &mut Random, radius: f64, distance: f64) -> (Sphere, Ray) {
    let center = random.direction() * random.range(0.0, 2.0) * radius;
    let direction = random.direction();
    let aside = random.perpendicular(direction) * (1.2 * radius * random.unit().sqrt());
    let sphere = Sphere { center: center.as_vec3(), radius: radius as f32 };
    (sphere, toward(center + aside, direction, distance * radius))
}

fn grazing(random: &mut Random, gap: f64, distance: f64) -> (Sphere, Ray) {
    let center = random.direction() * random.range(0.0, 2.0);
    let direction = random.direction();
    let aside = random.perpendicular(direction) * (1.0 + random.sign() * gap);
    (Sphere { center: center.as_vec3(), radius: 1.0 }, toward(center + aside, direction, distance))
}

/// Returns a case whose coordinates need no rounding, so that the ray passes the sphere at exactly
/// -3 to 3 units in the last place of the radius.
fn tangent(random: &mut Random, _: f64) -> (Sphere, Ray) {
    let radius = random.range(1.0, 2.0) as f32;
    let steps = random.index(7) as i32 - 3;
    let apart = f32::from_bits(radius.to_bits().wrapping_add_signed(steps));
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let along = random.index(3);
    let across = (along + 1 + random.index(2)) % 3;
    let scale = 2f32.powi(random.index(21) as i32 - 10);
    let origin = axes[along] * -(random.range(3.0, 100.0) as f32) + axes[across] * apart;
    let sphere = Sphere { center: Vec3::ZERO, radius: radius * scale };
    (sphere, Ray::new(origin * scale, axes[along] * random.range(0.5, 2.0) as f32))
}

fn inside(random: &mut Random, _: f64) -> (Sphere, Ray) {
    let center = random.direction() * random.range(0.0, 2.0);
    let origin = center + random.ball() * 0.999;
    let sphere = Sphere { center: center.as_vec3(), radius: 1.0 };
    (sphere, Ray::new(origin.as_vec3(), random.direction().as_vec3()))
}

/// Returns a ray from a rounded point of the surface inwards.
fn on_surface(random: &mut Random, t_min: f32) -> (Sphere, Ray) {
    let center = random.direction() * random.range(0.0, 2.0);
    let normal = random.direction();
    let direction = random.direction();
    let direction = if direction.dot(normal) > 0.0 { -direction } else { direction };
    let sphere = Sphere { center: center.as_vec3(), radius: 1.0 };
    (sphere, Ray { t_min, ..Ray::new((center + normal).as_vec3(), direction.as_vec3()) })
}

fn offset(random: &mut Random, offset: f64) -> (Sphere, Ray) {
    moved(random.direction() * offset, from(random, 1.0, 10.0))
}

/// Translates sphere and ray, and rounds them again.
fn moved(by: DVec3, (sphere, ray): (Sphere, Ray)) -> (Sphere, Ray) {
    let place = |p: Vec3| (p.as_dvec3() + by).as_vec3();
    let origin = place(ray.origin);
    (Sphere { center: place(sphere.center), ..sphere }, Ray { origin, ..ray })
}

/// Returns rays whose directions are 10^-level to 10^level long.
fn lengths(random: &mut Random, level: f64) -> (Sphere, Ray) {
    let (sphere, ray) = from(random, 1.0, 10.0);
    (sphere, with_length(ray, 10f64.powf(random.range(-level, level))))
}

fn denormal(random: &mut Random, _: f64) -> (Sphere, Ray) {
    let (sphere, ray) = from(random, 1e-6, 10.0);
    (sphere, with_length(ray, 10f64.powf(random.range(-41.0, -38.0))))
}

fn mixed(random: &mut Random, _: f64) -> (Sphere, Ray) {
    let radius = random.range(-40.0, 40.0).exp2();
    let distance = random.range(0.5, 12.0).exp2();
    let by = random.direction() * radius * random.range(-10.0, 20.0).exp2();
    let (sphere, ray) = moved(by, from(random, radius, distance));
    (sphere, with_length(ray, random.range(-20.0, 20.0).exp2()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grazing_rays_pass_by_what_they_say() {
        for gap in [1e-1, 1e-3] {
            for i in 0..100 {
                let (sphere, ray) = grazing(&mut Random::new(i), gap, 10.0);
                let to_center = (sphere.center - ray.origin).as_dvec3();
                let apart = to_center.cross(ray.direction.as_dvec3()).length();
                assert!(((apart - 1.0).abs() / gap - 1.0).abs() < 0.01, "{apart} for {gap}");
            }
        }
    }

    #[test]
    fn distances_are_what_they_say() {
        for distance in [1.5, 1.5e4] {
            let (sphere, ray) = from(&mut Random::new(1), 2.0, distance);
            let found = sphere.center.distance(ray.origin) / 2.0;
            assert!(found >= distance as f32 * 0.999 && found < distance as f32 + 1.3, "{found}");
        }
    }
}
