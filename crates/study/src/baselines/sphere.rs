//! A ray and a sphere, as published.

use glam::Vec3;
use rotund_geometry::{Hit, Ray, Sphere};

use super::{first, hit, inside, interval::Interval};

/// Returns the hit at `t` as most programs compute it: the point on the ray, the normal from the
/// point.
fn at(sphere: &Sphere, ray: &Ray, t: f32) -> Hit {
    let position = ray.at(t);
    hit(t, position, (position - sphere.center) / sphere.radius)
}

/// `a t² + b t + c = 0` and `(-b ± √(b² - 4ac)) / 2a`.
pub(crate) fn textbook(sphere: &Sphere, ray: &Ray) -> Option<Hit> {
    let f = ray.origin - sphere.center;
    let a = ray.direction.dot(ray.direction);
    let b = 2.0 * f.dot(ray.direction);
    let c = f.dot(f) - sphere.radius * sphere.radius;
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let t = first(ray, (-b - root) / (2.0 * a), (-b + root) / (2.0 * a))?;
    Some(at(sphere, ray, t))
}

/// I. Quilez, "intersectors": for unit directions; it returns only the near root.
pub(crate) fn quilez(sphere: &Sphere, ray: &Ray) -> Option<Hit> {
    let f = ray.origin - sphere.center;
    let b = f.dot(ray.direction);
    let c = f.dot(f) - sphere.radius * sphere.radius;
    let h = b * b - c;
    if h < 0.0 {
        return None;
    }
    let t = -b - h.sqrt();
    inside(ray, t).then(|| at(sphere, ray, t))
}

/// E. Haines, J. Günther, T. Akenine-Möller, "Precision improvements for ray/sphere intersection",
/// Ray Tracing Gems, chapter 7, 2019: the discriminant from the perpendicular, no cancelling root.
pub(crate) fn haines(sphere: &Sphere, ray: &Ray) -> Option<Hit> {
    let (d, r2) = (ray.direction, sphere.radius * sphere.radius);
    let f = ray.origin - sphere.center;
    let a = d.dot(d);
    let b = -f.dot(d);
    let perpendicular = f + d * (b / a);
    let discriminant = r2 - perpendicular.dot(perpendicular);
    if discriminant < 0.0 {
        return None;
    }
    let c = f.dot(f) - r2;
    let q = b + (a * discriminant).sqrt().copysign(b);
    let t = first(ray, c / q, q / a)?;
    Some(at(sphere, ray, t))
}

/// The geometric form that Embree uses: the normal comes from the perpendicular and half the chord,
/// not from the point.
pub(crate) fn projected(sphere: &Sphere, ray: &Ray) -> Option<Hit> {
    let d = ray.direction;
    let over = 1.0 / d.dot(d);
    let to_center = sphere.center - ray.origin;
    let foot = to_center.dot(d) * over;
    let perpendicular = to_center - d * foot;
    let (apart, r2) = (perpendicular.dot(perpendicular), sphere.radius * sphere.radius);
    if apart > r2 {
        return None;
    }
    let half = ((r2 - apart) * over).sqrt();
    let (t, normal) = if inside(ray, foot - half) {
        (foot - half, d * -half - perpendicular)
    } else if inside(ray, foot + half) {
        (foot + half, d * half - perpendicular)
    } else {
        return None;
    };
    Some(hit(t, ray.at(t), normal / sphere.radius))
}

/// M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering", 4th edition, 2023, section
/// 6.2.2: interval arithmetic, which rejects what it cannot decide; the point is projected onto the
/// sphere.
pub(crate) fn interval(sphere: &Sphere, ray: &Ray) -> Option<Hit> {
    let o = [0, 1, 2].map(|i| Interval::exact(ray.origin[i]) - Interval::exact(sphere.center[i]));
    let d = [ray.direction.x, ray.direction.y, ray.direction.z].map(Interval::exact);
    let dot = |x: [Interval; 3], y: [Interval; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    let radius = Interval::exact(sphere.radius);
    let two = Interval::exact(2.0);
    let a = dot(d, d);
    let b = two * dot(d, o);
    let c = dot(o, o) - radius * radius;
    let foot = b / (two * a);
    let v = [o[0] - foot * d[0], o[1] - foot * d[1], o[2] - foot * d[2]];
    let length = dot(v, v).sqrt();
    let discriminant = Interval::exact(4.0) * a * (radius + length) * (radius - length);
    if discriminant.low < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let half = Interval::exact(-0.5);
    let q = if b.low < 0.0 { half * (b - root) } else { half * (b + root) };
    let (mut t0, mut t1) = (q / a, c / q);
    if t0.low > t1.low {
        (t0, t1) = (t1, t0);
    }
    if t0.high > ray.t_max || t1.low <= ray.t_min {
        return None;
    }
    let t = if t0.low > ray.t_min {
        t0
    } else if t1.high <= ray.t_max {
        t1
    } else {
        return None;
    };
    let t = t.middle();
    let center = Vec3::new(o[0].middle(), o[1].middle(), o[2].middle());
    let from_center = center + ray.direction * t;
    let from_center = from_center * (sphere.radius / from_center.length());
    Some(hit(t, sphere.center + from_center, from_center / sphere.radius))
}
