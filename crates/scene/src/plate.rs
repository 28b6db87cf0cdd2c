//! Two parallel planes around a flat shape, such as a floor, a wall or a lamp.
//!
//! Most shadow rays start next to the surface that they leave and end next to a lamp, so that they
//! meet the boxes of both without a hit. A box of a flat shape that is not parallel to the axes is
//! thick, and rays that leave a floor start in its box. The planes tell for certain that such a ray
//! misses, at a tenth of the cost of a tree.

use crate::{Elements, Shape};
use glam::{DVec3, Vec3};
use rotund_geometry::{Ray, UNIT_ROUNDOFF};

/// The space between two parallel planes that contains a shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plate {
    /// Normal of the planes, of unit length.
    normal: DVec3,
    /// The product of the normal and a point in the middle.
    middle: f64,
    /// Half of the distance of the planes.
    half: f64,
    /// Sum of the largest absolute coordinates of the shape.
    extent: f64,
}

/// Largest thickness of a shape that counts as flat, as a share of its longest distance. With
/// thicker ones, more rays start or end between the planes.
const THIN: f64 = 1.0 / 64.0;
/// Bound on the error of a height, as a share of the coordinates that it is computed from: at most
/// ten roundings of an `f64`, and the errors of the exact tests, which are smaller.
const ROUNDING: f64 = 1.0 / (1_u64 << 46) as f64;
/// Sine of the angle to the planes below which a ray grazes. The exact test of a triangle then
/// loses the digits of `t`.
const GRAZING: f64 = 1.0 / (1_u64 << 20) as f64;
/// Bound on the relative error of a `t`, which is rounded to `f32`.
const T_ROUNDING: f64 = 4.0 * UNIT_ROUNDOFF as f64;

impl Plate {
    /// Returns the planes around a shape of triangles or quads if it is flat. Triangles and
    /// patches lie in the hull of their corners.
    pub(crate) fn around(shape: &Shape) -> Option<Self> {
        if !matches!(shape.elements, Elements::Triangles(_) | Elements::Quads(_)) {
            return None;
        }
        Self::around_points(&shape.positions)
    }

    fn around_points(points: &[Vec3]) -> Option<Self> {
        let first = points.first()?.as_dvec3();
        let from_first = || points.iter().map(|p| p.as_dvec3() - first);
        // The corners of a large triangle, whose normal has more digits than that of a small one.
        let farthest = |of: &dyn Fn(DVec3) -> DVec3| {
            let vectors = from_first().map(of);
            vectors.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
        };
        let edge = farthest(&|p| p)?;
        let normal = farthest(&|p| edge.cross(p))?.try_normalize()?;
        let (mut low, mut high) = (0_f64, 0_f64);
        let thin = THIN * edge.length();
        for height in from_first().map(|p| normal.dot(p)) {
            (low, high) = (low.min(height), high.max(height));
            // False for a NaN.
            let is_thin = high - low <= thin;
            if !is_thin {
                return None;
            }
        }
        let largest = points.iter().fold(Vec3::ZERO, |max, p| max.max(p.abs()));
        Some(Self {
            normal,
            middle: normal.dot(first) + 0.5 * (low + high),
            half: 0.5 * (high - low),
            extent: largest.as_dvec3().element_sum(),
        })
    }

    /// Returns true only if the exact tests of all elements miss: the interval of the ray lies on
    /// one side of the planes, by more than the rounding of `t` and of both computations.
    #[inline(always)]
    pub(crate) fn is_missed(&self, ray: &Ray) -> bool {
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (height, rise) = (self.normal.dot(o) - self.middle, self.normal.dot(d));
        let (side, rise) = (height.abs(), rise * 1_f64.copysign(height));
        let length = d.abs().element_sum();
        let margin = self.half + ROUNDING * (o.abs().element_sum() + self.extent);
        // A `t` behind the origin must not be rounded to zero.
        let least = f64::from(f32::MIN_POSITIVE) * length;
        // Comparisons with a NaN are false.
        let outside = ray.t_min >= 0.0 && side > margin + least && rise.abs() > GRAZING * length;
        if !outside || rise >= 0.0 {
            return outside;
        }
        let end = f64::from(ray.t_max);
        side + rise * end > margin + T_ROUNDING * (side + margin) + ROUNDING * length * end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rotund_geometry::{BilinearPatch, Triangle, vanilla};

    /// A linear congruential generator.
    struct Random(u64);

    impl Random {
        /// In `-1.0..1.0`.
        fn signed(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
        }

        fn in_cube(&mut self) -> Vec3 {
            Vec3::new(self.signed(), self.signed(), self.signed())
        }

        /// A number of any magnitude within this power of ten.
        fn power(&mut self, power: f32) -> f32 {
            10_f32.powf(power * self.signed())
        }
    }

    /// Rays that start on or next to an element, end there, pass it, and graze it.
    fn rays(random: &mut Random, point: Vec3, normal: Vec3, size: f32) -> [Ray; 4] {
        let away = size * random.power(7.0);
        let step = normal * 1e-7 * random.power(3.0) * (point.abs().max_element() + size);
        let direction = away * random.in_cube();
        let grazing = away * (normal.cross(random.in_cube()) + 1e-5 * random.power(5.0) * normal);
        let margin = 1e-7 * random.power(2.0);
        [
            Ray::new(point + step, direction),
            Ray::new(point + step, -direction),
            Ray { t_max: 1.0 + margin * random.signed(), ..Ray::new(point - direction, direction) },
            Ray { t_max: 1.0 - margin, ..Ray::new(point + step - grazing, grazing) },
        ]
    }

    #[test]
    fn a_ray_that_misses_the_planes_misses_every_element_between_them() {
        let mut random = Random(7);
        let mut missed = [0; 4];
        for _ in 0..200_000 {
            let size = random.power(4.0);
            let center = size * random.power(4.0) * random.in_cube();
            let (x, y) = (size * random.in_cube(), size * random.in_cube());
            let bend = 1e-4 * random.power(4.0);
            let corners = [-x - y, x - y, x + y, y - x]
                .map(|corner| center + corner + bend * size * random.in_cube());
            let Some(plate) = Plate::around_points(&corners) else { continue };
            let [p0, p1, p2, p3] = corners;
            let place = 0.5 * random.signed() * x + 0.5 * random.signed() * y;
            let normal = x.cross(y).normalize_or(Vec3::Z);
            let found = rays(&mut random, center + place, normal, size);
            for (kind, ray) in found.iter().enumerate() {
                if !plate.is_missed(ray) {
                    continue;
                }
                missed[kind] += 1;
                let hits = [
                    BilinearPatch { p00: p0, p10: p1, p01: p3, p11: p2 }.closest_t(ray),
                    vanilla::Quad { p0, p1, p2, p3 }.closest_t(ray),
                    Triangle { p0, p1, p2 }.closest_t(ray),
                    Triangle { p0, p1: p2, p2: p3 }.closest_t(ray),
                ];
                assert_eq!(hits, [None; 4], "{corners:?} {ray:?} {plate:?}");
            }
        }
        assert!(missed.iter().all(|&missed| missed > 20_000), "{missed:?}");
    }

    #[test]
    fn shadow_rays_from_a_floor_to_a_tilted_lamp_miss_both() {
        let corner = |x: f32, z: f32| Vec3::new(x, 1.0 + 0.3 * x - 0.2 * z, z);
        let lamp = [corner(0.0, 0.0), corner(0.4, 0.0), corner(0.4, 0.3), corner(0.0, 0.3)];
        let floor = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Z, Vec3::Z];
        let [lamp, floor] = [lamp, floor].map(|points| Plate::around_points(&points));
        let (lamp, floor) = (lamp.expect("it is flat"), floor.expect("it is flat"));
        let start = Vec3::new(0.3, 1e-7, 0.4);
        let segment =
            Ray { t_max: 1.0 - 32.0 * UNIT_ROUNDOFF, ..Ray::new(start, corner(0.2, 0.2) - start) };
        assert!(floor.is_missed(&segment), "it leaves the floor");
        assert!(lamp.is_missed(&segment), "it ends before the lamp");
        let longer = Ray { t_max: 1.0 + 32.0 * UNIT_ROUNDOFF, ..segment };
        assert!(!lamp.is_missed(&longer), "it passes the lamp");
        let behind = Ray { t_min: -1.0, ..segment };
        assert!(!floor.is_missed(&behind), "its interval starts behind the floor");
    }

    #[test]
    fn shapes_that_are_not_flat_have_no_planes() {
        let tent = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        assert!(Plate::around_points(&tent).is_none(), "a tetrahedron");
        assert!(Plate::around_points(&[]).is_none(), "no points");
        assert!(Plate::around_points(&[Vec3::ONE; 4]).is_none(), "one point");
        let line = [0.0, 1.0, 2.0].map(Vec3::splat);
        assert!(Plate::around_points(&line).is_none(), "a line");
        let broken = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN];
        assert!(Plate::around_points(&broken).is_none(), "a corner that is not a number");
    }
}
