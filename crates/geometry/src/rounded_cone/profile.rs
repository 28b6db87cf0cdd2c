//! The parametrization of the rounded cone by its profile and the angle around its axis.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec2};

use crate::basis::across;
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;

use super::RoundedCone;

/// The profile, whose rotation about the axis sweeps the surface, and the frame of the rotation.
///
/// The profile is an arc of radius `r0` from the pole to the tangent circle, the straight body, and
/// an arc of radius `r1`.
pub(crate) struct Profile {
    p0: DVec3,
    p1: DVec3,
    r0: f64,
    r1: f64,
    /// The unit vector from `p0` to `p1`.
    axis: DVec3,
    /// With `y`, the plane perpendicular to the axis.
    x: DVec3,
    y: DVec3,
    /// The angle between the normal of the body and the plane perpendicular to the axis: its sine
    /// is `(r0 - r1) / L`.
    tilt: f64,
    /// The length of the first arc, then of the body, then of the whole profile.
    arc0: f64,
    body: f64,
    length: f64,
}

/// A point of the profile: its ball `s`, and the angle of its normal from `-axis`.
struct Place {
    s: f64,
    angle: f64,
}

impl Profile {
    pub(crate) fn new(cone: &RoundedCone) -> Self {
        let (p0, p1) = (cone.p0.as_dvec3(), cone.p1.as_dvec3());
        let (r0, r1) = (f64::from(cone.r0), f64::from(cone.r1));
        let e = p1 - p0;
        let distance = e.length();
        let axis = if distance > 0.0 { e / distance } else { DVec3::Y };
        let (x, y) = across(axis);
        let rho = r0 - r1;
        let body = (e.dot(e) - rho * rho).max(0.0).sqrt();
        // If one ball contains the other, the profile is half a turn about the larger ball.
        let tilt = if body > 0.0 { rho.atan2(body) } else { FRAC_PI_2.copysign(rho) };
        let arc0 = r0 * (FRAC_PI_2 + tilt);
        let arc1 = r1 * (FRAC_PI_2 - tilt);
        Self { p0, p1, r0, r1, axis, x, y, tilt, arc0, body, length: arc0 + body + arc1 }
    }

    fn place(&self, u: f64) -> Place {
        let along = u * self.length;
        let from_end = (1.0 - u) * self.length;
        if along < self.arc0 {
            Place { s: 0.0, angle: along / self.r0 }
        } else if from_end < self.length - self.arc0 - self.body && self.r1 > 0.0 {
            // At a tip the arc has no length, and the difference above may still round to more.
            Place { s: 1.0, angle: PI - from_end / self.r1 }
        } else {
            let s = if self.body > 0.0 {
                ((along - self.arc0) / self.body).clamp(0.0, 1.0)
            } else {
                // One ball contains the other, and this is a pole of the larger one.
                if self.r1 > self.r0 { 1.0 } else { 0.0 }
            };
            Place { s, angle: FRAC_PI_2 + self.tilt }
        }
    }

    fn normal_at(&self, place: &Place, v: f64) -> DVec3 {
        let (sin, cos) = place.angle.sin_cos();
        let (sin_v, cos_v) = (TAU * v).sin_cos();
        sin * (cos_v * self.x + sin_v * self.y) - cos * self.axis
    }

    pub(crate) fn normal(&self, uv: Vec2) -> DVec3 {
        self.normal_at(&self.place(f64::from(uv.x)), f64::from(uv.y))
    }

    pub(crate) fn ball(&self, uv: Vec2) -> f64 {
        self.place(f64::from(uv.x)).s
    }

    pub(crate) fn position(&self, uv: Vec2) -> DVec3 {
        let place = self.place(f64::from(uv.x));
        let center = self.p0 + place.s * (self.p1 - self.p0);
        let radius = self.r0 + place.s * (self.r1 - self.r0);
        center + radius * self.normal_at(&place, f64::from(uv.y))
    }

    /// Returns the derivatives of the position by `u` and `v`.
    pub(crate) fn tangents(&self, uv: Vec2) -> (DVec3, DVec3) {
        let place = self.place(f64::from(uv.x));
        let (sin, cos) = place.angle.sin_cos();
        let (sin_v, cos_v) = (TAU * f64::from(uv.y)).sin_cos();
        let radius = self.r0 + place.s * (self.r1 - self.r0);
        let outward = cos_v * self.x + sin_v * self.y;
        // On caps and body the unit tangent along the profile is the normal rotated by a right
        // angle.
        let du = self.length * (cos * outward + sin * self.axis);
        let dv = TAU * radius * sin * (cos_v * self.y - sin_v * self.x);
        (du, dv)
    }

    /// Computes the parameters from the ball of a hit and its normal.
    pub(crate) fn uv(&self, s: f64, normal: DVec3) -> Vec2 {
        let (nx, ny, nz) = (normal.dot(self.x), normal.dot(self.y), normal.dot(self.axis));
        let across = nx.hypot(ny);
        let along = if s <= 0.0 {
            self.r0 * across.atan2(-nz)
        } else if s >= 1.0 {
            self.length - self.r1 * across.atan2(nz)
        } else {
            self.arc0 + s * self.body
        };
        let v = ny.atan2(nx) / TAU;
        let v = (if v < 0.0 { v + 1.0 } else { v }) as f32;
        Vec2::new((along / self.length).clamp(0.0, 1.0) as f32, if v < 1.0 { v } else { 0.0 })
    }
}
