//! Sampling a rectangle uniformly by solid angle.
//!
//! Source: C. Ureña, M. Fajardo, A. King, "An Area-Preserving Parametrization for Spherical
//! Rectangles", Computer Graphics Forum 32(4), 2013.

use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::TAU;

/// A corner and the two perpendicular edges at it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    pub(super) corner: Vec3,
    pub(super) edges: [Vec3; 2],
    pub(super) normal: Vec3,
    /// Distance of the fourth corner of the element from that of the rectangle, and so a bound on
    /// that of any other point.
    pub(super) off: f32,
    area: f32,
    /// Unit vectors along both edges and along the normal.
    axes: [DVec3; 3],
    /// Lengths of the edges.
    lengths: [f64; 2],
}

/// A rectangle in coordinates about an eye, along its axes.
struct Seen {
    x: [f64; 2],
    y: [f64; 2],
    /// Minus the distance of the plane from the eye.
    z: f64,
    /// z components of the normals of the planes through the eye and the edges along x.
    slopes: [f64; 2],
    /// Cosine and sine of the sum of the angles at two corners of the spherical rectangle.
    offset: DVec2,
    solid_angle: f64,
}

/// Solid angle below which the rectangle is sampled by area, which is nearly uniform by solid angle
/// there. The solid angle, computed as the angle of a complex product, has an error of some
/// roundoffs, 1e-15.
const LEAST: f64 = 1e-4;

impl Rectangle {
    /// Returns the rectangle of four corners in order, or `None` if they are not one up to the
    /// rounding of decimal numbers in files.
    pub(super) fn try_new([p0, p1, p2, p3]: [Vec3; 4]) -> Option<Self> {
        let edges = [p1 - p0, p3 - p0];
        let size = edges[0].length() * edges[1].length();
        let off = (p0 + edges[0] + edges[1]).distance(p2);
        let closes = off * off <= 1e-10 * size;
        let right = edges[0].dot(edges[1]).abs() <= 1e-5 * size;
        (closes && right && size > 0.0).then(|| {
            let [ex, ey] = edges.map(Vec3::as_dvec3);
            let (x, y) = (ex.normalize(), ey.normalize());
            Self {
                corner: p0,
                edges,
                normal: edges[0].cross(edges[1]).normalize(),
                off,
                area: size,
                axes: [x, y, x.cross(y)],
                lengths: [ex.length(), ey.length()],
            }
        })
    }

    pub(super) fn area(&self) -> f32 {
        self.area
    }

    fn seen(&self, from: Vec3) -> Option<Seen> {
        let to = self.corner.as_dvec3() - from.as_dvec3();
        let [x, y, z] = self.axes;
        let depth = -to.dot(z).abs();
        let (x0, y0) = (to.dot(x), to.dot(y));
        let (x1, y1) = (x0 + self.lengths[0], y0 + self.lengths[1]);
        // The planes through the eye and an edge have normals (0, z, -y0), (-z, 0, x1), (0, -z, y1)
        // and (z, 0, -x0). The dot product of two neighbours of unit length is the product of their
        // z.
        let depth2 = depth * depth;
        let slope = |edge: f64| {
            let rest2 = 1.0 / (edge * edge + depth2);
            // The component, and 1 minus its square.
            (edge * rest2.sqrt(), depth2 * rest2)
        };
        let slopes = [slope(-y0), slope(x1), slope(y1), slope(-x0)];
        // The angle between two planes as a complex number of length 1; 1 - (1 - p)(1 - q) is
        // expanded so that it does not cancel.
        let angle = |a: usize, b: usize| {
            let ((sa, p), (sb, q)) = (slopes[a], slopes[b]);
            DVec2::new(-sa * sb, (p + q - p * q).sqrt())
        };
        // Products add angles. The sum of all four is the solid angle plus 2 pi.
        let offset = angle(2, 3).rotate(angle(3, 0));
        let whole = angle(0, 1).rotate(angle(1, 2)).rotate(offset);
        let angle = whole.y.atan2(whole.x);
        // A solid angle above pi wraps to a negative angle; it occurs only near above the
        // rectangle.
        let above = x0 <= 0.0 && x1 >= 0.0 && y0 <= 0.0 && y1 >= 0.0;
        let near = above && -depth < self.lengths[0].max(self.lengths[1]);
        let solid_angle = if angle < 0.0 && near { angle + TAU } else { angle };
        // The comparison is false for NaN, which an eye in the plane of the rectangle causes.
        (solid_angle > LEAST).then_some(Seen {
            x: [x0, x1],
            y: [y0, y1],
            z: depth,
            slopes: [slopes[0].0, slopes[2].0],
            offset,
            solid_angle,
        })
    }

    /// Returns the density of [`Self::sample`] per solid angle, or `None` if the rectangle is
    /// sampled by area.
    pub(super) fn pdf(&self, from: Vec3) -> Option<f32> {
        Some((1.0 / self.seen(from)?.solid_angle) as f32)
    }

    /// Samples a point. Returns its coordinates in units of the edges and its density per solid
    /// angle, or `None` if the solid angle is too small.
    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<(Vec2, f32)> {
        let seen = self.seen(from)?;
        let [b0, b1] = seen.slopes;
        // 2 pi minus the sum of the last two angles is the angle of their conjugate.
        let share = DVec2::from_angle(f64::from(u.x) * seen.solid_angle);
        let DVec2 { x: cosine, y: sine } = share.rotate(DVec2::new(seen.offset.x, -seen.offset.y));
        let f = (cosine * b0 - b1) / sine;
        let c = (1.0_f64.copysign(f) / (f * f + b0 * b0).sqrt()).clamp(-1.0, 1.0);
        let x =
            (-c * seen.z / (1.0 - c * c).max(f64::MIN_POSITIVE).sqrt()).clamp(seen.x[0], seen.x[1]);
        let d2 = x * x + seen.z * seen.z;
        let height = seen.y.map(|y| y / (d2 + y * y).sqrt());
        let h = height[0] + f64::from(u.y) * (height[1] - height[0]);
        let y =
            (h * (d2 / (1.0 - h * h).max(f64::MIN_POSITIVE)).sqrt()).clamp(seen.y[0], seen.y[1]);
        let place = Vec2::new(
            ((x - seen.x[0]) / (seen.x[1] - seen.x[0])) as f32,
            ((y - seen.y[0]) / (seen.y[1] - seen.y[0])) as f32,
        );
        Some((place, (1.0 / seen.solid_angle) as f32))
    }
}
