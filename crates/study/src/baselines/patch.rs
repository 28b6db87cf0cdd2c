//! A ray and a bilinear patch or a quadrilateral, as published.

use glam::{DVec3, Vec2, Vec3};
use rotund_geometry::{BilinearPatch, Hit, Ray};

use super::inside;

/// Returns the hit with point, normal and parameters of the patch at `u`, `v`.
fn at(p: &BilinearPatch, t: f32, u: f32, v: f32) -> Hit {
    let along_u = (p.p10 - p.p00).lerp(p.p11 - p.p01, v);
    let along_v = (p.p01 - p.p00).lerp(p.p11 - p.p10, u);
    Hit {
        t,
        position: p.p00.lerp(p.p10, u).lerp(p.p01.lerp(p.p11, u), v),
        error: 0.0,
        normal: along_u.cross(along_v).normalize(),
        parameters: Vec2::new(u, v),
    }
}

/// A. Reshetov, "Cool patches: a geometric approach to ray/bilinear patch intersections", Ray
/// Tracing Gems, chapter 8, 2019. The published code leaves the interval to its caller; here each
/// root is tested as it is found.
pub(crate) fn cool(p: &BilinearPatch, ray: &Ray) -> Option<Hit> {
    let d = ray.direction;
    let (e10, e11, e00) = (p.p10 - p.p00, p.p11 - p.p10, p.p01 - p.p00);
    let normal = e10.cross(p.p01 - p.p11);
    let (q00, q10) = (p.p00 - ray.origin, p.p10 - ray.origin);
    let a = q00.cross(d).dot(e00);
    let c = normal.dot(d);
    let b = q10.cross(d).dot(e11) - (a + c);
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let (u1, u2) = if c == 0.0 {
        (-a / b, -1.0)
    } else {
        let q = (-b - root.copysign(b)) * 0.5;
        (q / c, a / q)
    };
    let mut best: Option<(f32, f32, f32)> = None;
    for u in [u1, u2] {
        if !(0.0..=1.0).contains(&u) {
            continue;
        }
        let (from, along) = (q00.lerp(q10, u), e00.lerp(e11, u));
        let across = d.cross(along);
        let square = across.dot(across);
        let turned = across.cross(from);
        let (t, v) = (turned.dot(along) / square, turned.dot(d));
        if 0.0 <= v && v <= square && inside(ray, t) && best.is_none_or(|(first, ..)| t < first) {
            best = Some((t, u, v / square));
        }
    }
    best.map(|(t, u, v)| at(p, t, u, v))
}

/// Returns `a b - c d` with one rounding: the products of two `f32` are exact in `f64`.
fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    (f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d)) as f32
}

fn accurate_cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        difference_of_products(a.y, b.z, a.z, b.y),
        difference_of_products(a.z, b.x, a.x, b.z),
        difference_of_products(a.x, b.y, a.y, b.x),
    )
}

/// M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering", 4th edition, 2023, section
/// 6.6.1: differences of products without cancellation, and an epsilon from the size of the
/// coordinates.
pub(crate) fn pbrt(p: &BilinearPatch, ray: &Ray) -> Option<Hit> {
    const U: f32 = 0.5 * f32::EPSILON;
    let (o, d) = (ray.origin, ray.direction);
    let a = accurate_cross(p.p10 - p.p00, p.p01 - p.p11).dot(d);
    let c = accurate_cross(p.p00 - o, d).dot(p.p01 - p.p00);
    let b = accurate_cross(p.p10 - o, d).dot(p.p11 - p.p10) - (a + c);
    let (u1, u2) = quadratic(a, b, c)?;
    let size =
        [o, d, p.p00, p.p10, p.p01, p.p11].iter().map(|x| x.abs().max_element()).sum::<f32>();
    let eps = 10.0 * U / (1.0 - 10.0 * U) * size;
    let mut best: Option<(f32, f32, f32)> = None;
    for u in [u1, u2] {
        if !(0.0..=1.0).contains(&u) {
            continue;
        }
        let from = p.p00.lerp(p.p10, u);
        let along = p.p01.lerp(p.p11, u) - from;
        let to_from = from - o;
        let perpendicular = accurate_cross(d, along);
        let square = perpendicular.length_squared();
        let v = accurate_cross(to_from, d).dot(perpendicular);
        let t = accurate_cross(to_from, along).dot(perpendicular);
        if t > square * eps && 0.0 <= v && v <= square {
            let t = t / square;
            if inside(ray, t) && best.is_none_or(|(first, ..)| t < first) {
                best = Some((t, u, v / square));
            }
        }
    }
    best.map(|(t, u, v)| at(p, t, u, v))
}

/// Returns the roots of `a x² + b x + c`, by a discriminant of one rounding.
fn quadratic(a: f32, b: f32, c: f32) -> Option<(f32, f32)> {
    if a == 0.0 {
        return (b != 0.0).then(|| (-c / b, -c / b));
    }
    let discriminant = difference_of_products(b, b, 4.0 * a, c);
    if discriminant < 0.0 {
        return None;
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    Some((q / a, c / q))
}

/// S. Ramsey, K. Potter, C. Hansen, "Ray bilinear patch intersections", Journal of Graphics Tools
/// 9(3), 2004, in the precision `$T`. The coordinate that is eliminated is the largest of the
/// direction.
macro_rules! ramsey {
    ($(#[$doc:meta])* $name:ident, $T:ty, $V:ty, $from:expr) => {
        $(#[$doc])*
        pub(crate) fn $name(patch: &BilinearPatch, ray: &Ray) -> Option<Hit> {
            let wide: fn(Vec3) -> $V = $from;
            let (o, d) = (wide(ray.origin), wide(ray.direction));
            let [p00, p10, p01, p11] =
                [wide(patch.p00), wide(patch.p10), wide(patch.p01), wide(patch.p11)];
            let z = d.abs().max_position();
            let (x, y) = ((z + 1) % 3, (z + 2) % 3);
            let (a, b, c, f) = (p11 - p10 - p01 + p00, p10 - p00, p01 - p00, p00 - o);
            let first = |p: $V| p[x] * d[z] - p[z] * d[x];
            let second = |p: $V| p[y] * d[z] - p[z] * d[y];
            let (a1, b1, c1, d1) = (first(a), first(b), first(c), first(f));
            let (a2, b2, c2, d2) = (second(a), second(b), second(c), second(f));

            // q2 v² + q1 v + q0 = 0
            let q2 = a2 * c1 - a1 * c2;
            let q1 = a2 * d1 - a1 * d2 + b2 * c1 - b1 * c2;
            let q0 = b2 * d1 - b1 * d2;
            let discriminant = q1 * q1 - 4.0 * q2 * q0;
            if discriminant < 0.0 {
                return None;
            }
            let q = -0.5 * (q1 + discriminant.sqrt().copysign(q1));
            let mut best: Option<($T, $T, $T)> = None;
            for v in [q / q2, q0 / q] {
                if !(0.0..=1.0).contains(&v) {
                    continue;
                }
                let (one, other) = (v * a2 + b2, v * (a2 - a1) + b2 - b1);
                let u = if other.abs() >= one.abs() {
                    (v * (c1 - c2) + d1 - d2) / other
                } else {
                    (-v * c2 - d2) / one
                };
                if !(0.0..=1.0).contains(&u) {
                    continue;
                }
                let point = f + b * u + c * v + a * (u * v);
                let t = point[z] / d[z];
                let inside = <$T>::from(ray.t_min) <= t && t <= <$T>::from(ray.t_max);
                if inside && best.is_none_or(|(first, ..)| t < first) {
                    best = Some((t, u, v));
                }
            }
            let (t, u, v) = best?;
            let point = p00 + b * u + c * v + a * (u * v);
            let normal = (b + a * v).cross(c + a * u).normalize();
            let narrow = |p: $V| Vec3::new(p.x as f32, p.y as f32, p.z as f32);
            Some(Hit {
                t: t as f32,
                position: narrow(point),
                error: 0.0,
                normal: narrow(normal),
                parameters: Vec2::new(u as f32, v as f32),
            })
        }
    };
}

ramsey! {
    /// Ramsey's equations in `f32`, as published.
    ramsey_f32, f32, Vec3, |p| p
}
ramsey! {
    /// Ramsey's equations in `f64`.
    ramsey_f64, f64, DVec3, |p| p.as_dvec3()
}

/// T. Möller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", Journal of Graphics
/// Tools 2(1), 1997, on both triangles of the quadrilateral, split between p10 and p01.
pub(crate) fn two_triangles(p: &BilinearPatch, ray: &Ray) -> Option<Hit> {
    let one = moeller_trumbore(p.p00, p.p10, p.p01, ray);
    let other = moeller_trumbore(p.p11, p.p01, p.p10, ray)
        .map(|hit| Hit { parameters: Vec2::ONE - hit.parameters, ..hit });
    match (one, other) {
        (Some(a), Some(b)) => Some(if a.t <= b.t { a } else { b }),
        (a, b) => a.or(b),
    }
}

fn moeller_trumbore(p0: Vec3, p1: Vec3, p2: Vec3, ray: &Ray) -> Option<Hit> {
    let (e1, e2) = (p1 - p0, p2 - p0);
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let over = 1.0 / determinant;
    let s = ray.origin - p0;
    let u = s.dot(p) * over;
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let q = s.cross(e1);
    let v = ray.direction.dot(q) * over;
    if v < 0.0 || u + v > 1.0 {
        return None;
    }
    let t = e2.dot(q) * over;
    inside(ray, t).then(|| Hit {
        t,
        position: p0 + e1 * u + e2 * v,
        error: 0.0,
        normal: e1.cross(e2).normalize(),
        parameters: Vec2::new(u, v),
    })
}
