//! Sampling triangles uniformly by solid angle.
//!
//! Source: J. Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995; the solid angle by
//! A. van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle", IEEE Transactions on
//! Biomedical Engineering 30(2), 1983.

use glam::{DVec3, Vec2, Vec3};

/// A triangle in coordinates about an eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalTriangle {
    /// Corners relative to the eye.
    corners: [DVec3; 3],
    directions: [DVec3; 3],
    pub(super) solid_angle: f64,
}

/// Solid angle of all triangles below which they are sampled by area, which is cheaper and nearly
/// uniform by solid angle there.
const LEAST: f64 = 1e-3;

impl SphericalTriangle {
    /// One triangle, or two; the second of one has no solid angle. None if they are seen too small,
    /// or from within their plane.
    pub(super) fn seen(triangles: &[[Vec3; 3]], from: Vec3) -> Option<[Self; 2]> {
        let eye = from.as_dvec3();
        let of = |index: usize| match triangles.get(index) {
            Some(triangle) => Self::new(triangle.map(|corner| corner.as_dvec3() - eye)),
            None => Self { corners: [DVec3::X; 3], directions: [DVec3::X; 3], solid_angle: 0.0 },
        };
        let seen = [of(0), of(1)];
        (seen[0].solid_angle + seen[1].solid_angle > LEAST).then_some(seen)
    }

    fn new(corners: [DVec3; 3]) -> Self {
        let directions = corners.map(DVec3::normalize_or_zero);
        let [a, b, c] = directions;
        let volume = a.dot(b.cross(c)).abs();
        let angle = 2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        // From a corner the triangle has no well-defined solid angle.
        let solid_angle = if directions.contains(&DVec3::ZERO) { 0.0 } else { angle };
        Self { corners, directions, solid_angle }
    }

    /// Samples a point. Returns the weights of the second and third corner; the density is one over
    /// the solid angle.
    pub(super) fn sample(&self, u: Vec2) -> Vec2 {
        let [a, b, c] = self.directions;
        // The angle alpha of the spherical triangle at the first corner.
        let (ab, ac) = (a.cross(b), a.cross(c));
        let (sine, cosine) = (ab.cross(ac).length(), ab.dot(ac));
        let scale = (sine * sine + cosine * cosine).sqrt();
        let (sine, cosine) = (sine / scale, cosine / scale);
        // A point c' on the side from a to c is chosen so that the triangle a b c' has a fraction
        // u.x of the solid angle. In Arvo's notation, s and t are sine and cosine of that area
        // minus alpha.
        let (sine_share, cosine_share) = (f64::from(u.x) * self.solid_angle).sin_cos();
        let s = sine_share * cosine - cosine_share * sine;
        let t = cosine_share * cosine + sine_share * sine;
        let (p, v) = (t - cosine, s + sine * a.dot(b));
        let q = ((v * t - p * s) * cosine - v) / ((v * s + p * t) * sine);
        // The quotient is 0 / 0 for an area of zero.
        let q = if q.is_nan() { 1.0 } else { q.clamp(-1.0, 1.0) };
        let third = q * a + ((1.0 - q) * (1.0 + q)).sqrt() * (c - c.dot(a) * a).normalize_or_zero();
        // A direction on the arc from b to c', uniform in its cosine to b.
        let down = f64::from(u.y) * (1.0 - third.dot(b));
        let around = (third - third.dot(b) * b).normalize_or_zero();
        self.weights((1.0 - down) * b + (down * (2.0 - down)).max(0.0).sqrt() * around)
    }

    /// Returns the weights of the second and third corner at the point in a direction.
    fn weights(&self, direction: DVec3) -> Vec2 {
        let [p0, p1, p2] = self.corners;
        // Volumes spanned by the direction and each side.
        let volumes = [p1.cross(p2), p2.cross(p0), p0.cross(p1)].map(|n| n.dot(direction));
        let sum: f64 = volumes.iter().sum();
        // Rounding may lead slightly outside of the triangle.
        let weight = |index: usize| (volumes[index] / sum).clamp(0.0, 1.0);
        let (second, third) = (weight(1), weight(2));
        Vec2::new(second as f32, third.min(1.0 - second) as f32)
    }
}
