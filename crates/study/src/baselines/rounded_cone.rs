//! A ray and a rounded cone, as published.

use glam::Vec3;
use rotund_geometry::{Hit, Ray, RoundedCone};

use super::{hit, inside};

/// I. Quilez, "intersectors", rounded cone: for unit directions; it returns only the entry.
pub(crate) fn quilez(cone: &RoundedCone, ray: &Ray) -> Option<Hit> {
    let (t, normal) = quilez_entry(cone, ray)?;
    inside(ray, t).then(|| hit(t, ray.at(t), normal))
}

/// The same with the texture coordinates that a renderer needs: the angle of the normal from the
/// axis, and the angle about it.
pub(crate) fn quilez_with_uv(cone: &RoundedCone, ray: &Ray) -> Option<Hit> {
    let (t, normal) = quilez_entry(cone, ray)?;
    if !inside(ray, t) {
        return None;
    }
    let axis = (cone.p1 - cone.p0).normalize();
    let x = axis.any_orthonormal_vector();
    let u = normal.dot(x).atan2(normal.dot(axis.cross(x))) / std::f32::consts::TAU;
    let v = normal.dot(axis).clamp(-1.0, 1.0).acos() / std::f32::consts::PI;
    Some(Hit { parameters: glam::Vec2::new(u, v), ..hit(t, ray.at(t), normal) })
}

fn quilez_entry(cone: &RoundedCone, ray: &Ray) -> Option<(f32, Vec3)> {
    let d = ray.direction;
    let axis = cone.p1 - cone.p0;
    let (from0, from1) = (ray.origin - cone.p0, ray.origin - cone.p1);
    let taper = cone.r0 - cone.r1;
    let (aa, af, ad) = (axis.dot(axis), axis.dot(from0), axis.dot(d));
    let (df, ff) = (d.dot(from0), from0.dot(from0));
    let (d1, f1) = (d.dot(from1), from1.dot(from1));
    let g = aa - taper * taper;

    // k2 t² + 2 k1 t + k0 = 0 on the infinite cone.
    let k2 = g - ad * ad;
    let k1 = g * df - af * ad + ad * taper * cone.r0;
    let k0 = g * ff - af * af + af * taper * cone.r0 * 2.0 - aa * cone.r0 * cone.r0;
    let h = k1 * k1 - k0 * k2;
    if h < 0.0 {
        return None;
    }
    let t = (-h.sqrt() - k1) / k2;
    if t < 0.0 {
        return None;
    }
    let y = af - cone.r0 * taper + t * ad;
    if y > 0.0 && y < g {
        return Some((t, ((from0 + d * t) * g - axis * y).normalize()));
    }
    let h0 = df * df - ff + cone.r0 * cone.r0;
    let h1 = d1 * d1 - f1 + cone.r1 * cone.r1;
    let mut found = None;
    if h0 > 0.0 {
        let t = -df - h0.sqrt();
        found = Some((t, (from0 + d * t) / cone.r0));
    }
    if h1 > 0.0 {
        let t = -d1 - h1.sqrt();
        if found.is_none_or(|(first, _)| t < first) {
            found = Some((t, (from1 + d * t) / cone.r1));
        }
    }
    found
}

/// The scalar form of Embree's round linear curve: the origin moved next to the middle, the cone
/// that touches both balls clipped between the touching circles, the end balls outside of them.
///
/// With `y = (x - p0)·a - r0 (r0 - r1)` and `g = a·a - (r0 - r1)²` the cone is
/// `g |x - p0|² - y² = g r0²`, for `y` in `0..g`, and its normal `g (x - p0) - y a`.
pub(crate) fn embree(cone: &RoundedCone, ray: &Ray) -> Option<Hit> {
    let d = ray.direction;
    let dd = d.dot(d);
    let axis = cone.p1 - cone.p0;
    let taper = cone.r0 - cone.r1;
    let near = (0.5 * (cone.p0 + cone.p1) - ray.origin).dot(d) / dd;
    let from0 = ray.origin + d * near - cone.p0;
    let from1 = from0 - axis;
    let g = axis.dot(axis) - taper * taper;
    let (y, dy) = (from0.dot(axis) - cone.r0 * taper, d.dot(axis));

    let a = g * dd - dy * dy;
    let b = g * from0.dot(d) - y * dy;
    let c = g * (from0.dot(from0) - cone.r0 * cone.r0) - y * y;
    let discriminant = b * b - a * c;
    if discriminant < 0.0 || a.abs() < 1e-18 {
        return None;
    }
    let root = discriminant.sqrt();
    let mut best: Option<(f32, Vec3)> = None;
    let mut offer = |t: f32, normal: Vec3| {
        if inside(ray, near + t) && best.is_none_or(|(first, _)| t < first) {
            best = Some((t, normal));
        }
    };
    for t in [(-b - root) / a, (-b + root) / a] {
        let y = y + t * dy;
        if (0.0..=g).contains(&y) {
            offer(t, (from0 + d * t) * g - axis * y);
        }
    }
    for (from, radius, second) in [(from0, cone.r0, false), (from1, cone.r1, true)] {
        let foot = -from.dot(d) / dd;
        let perpendicular = from + d * foot;
        let rest = radius * radius - perpendicular.dot(perpendicular);
        if rest < 0.0 {
            continue;
        }
        let half = (rest / dd).sqrt();
        for (t, side) in [(foot - half, -half), (foot + half, half)] {
            let y = y + t * dy;
            if if second { y > g } else { y < 0.0 } {
                offer(t, perpendicular + d * side);
            }
        }
    }
    let (t, normal) = best?;
    let t = near + t;
    Some(hit(t, ray.at(t), normal.normalize()))
}
