//! A ball of smooth glass as a lens: the paths that it refracts from one point to another.
//!
//! A ray that enters a ball and leaves it again stays in the plane of the ray and the center. It
//! meets the surface twice at the same angle `t` to the normal, outside, with `sin t = b / radius`
//! for a ray that passes the center at the distance `b`. Seen from the center, in units of the
//! radius, its ends at the distances `near` and `far` are apart by the angle
//!
//! ```text
//! turn(t) = pi + 2 t - 2 asin(sin t / ior) - asin(sin t / near) - asin(sin t / far)
//! ```
//!
//! The rays between two ends are the solutions of `turn(t) = angle` on the side of the center where
//! the ends are apart by `angle`, and of `turn(t) = 2 pi - angle` on the other. For an index above
//! 1, each of the terms `cos t / sqrt(a² - sin² t)` in the derivative falls with `t`, so `turn` is
//! convex: there are at most two solutions of the first equation and one of the second, and
//! Newton's method finds them from the ends of the range without passing one.
//!
//! J. Hanika, M. Droske, L. Fascione, "Manifold Next Event Estimation", EGSR 2015, find one such
//! path through any surfaces, by iterations in more dimensions.

use super::round::Ball;
use crate::bsdf::fresnel;
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A ball of smooth glass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    pub(super) ball: Ball,
    /// Index of refraction, above 1.
    pub(super) ior: f32,
}

/// Where a path ends.
#[derive(Clone, Copy, Debug)]
pub(crate) enum End {
    Point(Vec3),
    /// In the environments, in this direction.
    Sky(Vec3),
}

/// A path through a lens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Unit direction in which it starts.
    pub(crate) direction: Vec3,
    /// Point where it leaves the lens.
    pub(crate) exit: Vec3,
    pub(crate) beam: Beam,
}

/// The paths next to one through a lens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    /// Solid angle that they fill at the start, per area across the path at the end, or per solid
    /// angle of the sky.
    pub(crate) spread: f32,
    /// Share of the light that the two boundaries transmit.
    pub(crate) transmitted: f32,
}

/// The plane of a path through a lens. Lengths are in units of the radius.
struct Meridian {
    ior: f64,
    radius: f64,
    /// Distance of the start from the center, and unit direction to it.
    near: f64,
    to_start: DVec3,
    /// Distance of the end; infinite for the sky.
    far: f64,
    /// Angle between both ends, from the center.
    angle: f64,
    sine: f64,
    /// Unit vector across `to_start`, on the side of the end.
    across: DVec3,
}

/// Newton's method converges quadratically, but on the edge of a caustic, where two solutions meet,
/// each step only halves the distance.
const STEPS: usize = 40;
/// Largest error of an angle that is found.
const PRECISION: f64 = 1e-9;

impl Lens {
    /// Returns all paths from a point outside of the lens through it.
    pub(crate) fn crossings(&self, from: Vec3, end: End) -> impl Iterator<Item = Crossing> {
        let meridian = Meridian::new(self, from, end);
        let places = meridian.map_or([None; 3], |meridian| meridian.solve(self));
        places.into_iter().flatten()
    }

    /// Returns the beam about a path that starts in `direction`.
    pub(crate) fn beam(&self, from: Vec3, direction: Vec3, end: End) -> Option<Beam> {
        let meridian = Meridian::new(self, from, end)?;
        let to_center = (self.ball.center - from).as_dvec3();
        let sine = to_center.cross(direction.as_dvec3()).length() / meridian.radius;
        Some(meridian.beam(self, sine.min(1.0).asin()))
    }
}

impl Meridian {
    fn new(lens: &Lens, from: Vec3, end: End) -> Option<Self> {
        let Lens { ball: Ball { center, radius }, ior } = *lens;
        let (center, radius) = (center.as_dvec3(), f64::from(radius));
        let start = (from.as_dvec3() - center) / radius;
        let near = start.length();
        let to_start = start / near;
        let (far, to_end) = match end {
            End::Point(point) => {
                let end = (point.as_dvec3() - center) / radius;
                (end.length(), end.normalize())
            }
            End::Sky(direction) => (f64::INFINITY, direction.as_dvec3().normalize()),
        };
        let (sine, cosine) = (to_start.cross(to_end).length(), to_start.dot(to_end));
        let across = (to_end - cosine * to_start).try_normalize()?;
        let angle = sine.atan2(cosine);
        let ior = f64::from(ior);
        let outside = near > 1.0 && far > 1.0;
        outside.then_some(Self { ior, radius, near, to_start, far, angle, sine, across })
    }

    /// Returns the angle between the ends of the ray that meets the surface at this angle, and its
    /// derivative.
    fn turn(&self, t: f64) -> [f64; 2] {
        let (sine, cosine) = t.sin_cos();
        let term = |a: f64| [(sine / a).asin(), cosine / (a * a - sine * sine).sqrt()];
        let [[a, da], [b, db], [c, dc]] = [self.ior, self.near, self.far].map(term);
        [PI + 2.0 * t - 2.0 * a - b - c, 2.0 - 2.0 * da - db - dc]
    }

    /// Solves `turn(t) = angle` where `turn` rises from its minimum, or where it falls to it.
    fn root(&self, angle: f64, rises: bool) -> Option<f64> {
        let mut t = if rises { FRAC_PI_2 } else { 0.0 };
        for _ in 0..STEPS {
            let [turn, slope] = self.turn(t);
            let above = turn - angle;
            if above.abs() < PRECISION * 1e-3 {
                return Some(t);
            }
            // Convexity keeps the steps on the side that they start on.
            if above < 0.0 || (slope > 0.0) != rises {
                return None;
            }
            t -= above / slope;
            if !(0.0..=FRAC_PI_2).contains(&t) {
                return None;
            }
        }
        ((self.turn(t)[0] - angle).abs() < PRECISION).then_some(t)
    }

    fn solve(&self, lens: &Lens) -> [Option<Crossing>; 3] {
        let crossing = |t: f64, side: f64| {
            let sine = t.sin();
            let turned = (sine / self.near).asin();
            let across = side * self.across;
            let direction = turned.sin() * across - turned.cos() * self.to_start;
            let exit = PI + t - turned - 2.0 * (sine / self.ior).asin();
            let exit = self.radius * (exit.cos() * self.to_start + exit.sin() * across);
            let exit = (lens.ball.center.as_dvec3() + exit).as_vec3();
            Crossing { direction: direction.as_vec3(), exit, beam: self.beam(lens, t) }
        };
        let place =
            |angle: f64, side: f64, rises: bool| self.root(angle, rises).map(|t| crossing(t, side));
        // `turn` starts at pi. It falls below the smaller angle in one place and rises above it in
        // another, or is never as small.
        let angle = self.angle;
        let falling = place(angle, 1.0, false);
        let rising = falling.and_then(|_| place(angle, 1.0, true));
        [falling, rising, place(TAU - angle, -1.0, true)]
    }

    /// Returns the beam about the ray that meets the surface at this angle.
    ///
    /// The rays turn about the line from the start to the center, so a beam is as wide across the
    /// plane as it is far from that line. Within the plane its end moves by the derivative of
    /// [`Self::turn`].
    fn beam(&self, lens: &Lens, t: f64) -> Beam {
        let (sine, cosine) = t.sin_cos();
        let [_, slope] = self.turn(t);
        let height = |distance: f64| distance * (distance * distance - sine * sine).sqrt();
        let mut spread = sine * cosine / (height(self.near) * self.sine * slope.abs());
        if self.far.is_finite() {
            spread /= height(self.far) * self.radius * self.radius;
        }
        let transmitted = 1.0 - fresnel::dielectric(lens.ior, cosine as f32);
        Beam { spread: spread as f32, transmitted: transmitted * transmitted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Sampler, Sequence, warp};
    use glam::Vec2;

    /// Traces a ray through a ball at the origin by Snell's law; returns where and in which
    /// direction it leaves.
    fn bend(lens: &Lens, from: DVec3, direction: DVec3) -> Option<[DVec3; 2]> {
        let radius = f64::from(lens.ball.radius);
        let ahead = from.dot(direction);
        let inside = ahead * ahead - from.length_squared() + radius * radius;
        let enter = from + (-ahead - (inside >= 0.0).then(|| inside.sqrt())?) * direction;
        let refract = |direction: DVec3, normal: DVec3, eta: f64| {
            let cosine = -direction.dot(normal);
            let across = (direction + cosine * normal) * eta;
            across - (1.0 - across.length_squared()).sqrt() * normal
        };
        let ior = f64::from(lens.ior);
        let within = refract(direction, enter / radius, 1.0 / ior);
        let exit = enter - 2.0 * enter.dot(within) * within;
        Some([exit, refract(within, -exit / radius, ior)])
    }

    /// Lenses with starts and ends, many of them close to the glass.
    fn cases() -> impl Iterator<Item = (Lens, Vec3, Vec3)> {
        (0..400).map(|number| {
            let sampler = Sampler::new(Sequence::Independent, 5, 0, 0, number);
            let [a, b, c, d] = sampler.set(0);
            let [e, f, g, h] = sampler.set(1);
            let ball = Ball { center: Vec3::ZERO, radius: 0.2 + a };
            let away = |u: f32| ball.radius * (1.01 + 6.0 * u * u * u);
            let start = away(b) * warp::sphere(Vec2::new(c, d));
            // Light that a lens collects comes from beyond it.
            let end = (warp::sphere(Vec2::new(e, f)) - start.normalize()).normalize();
            (Lens { ball, ior: 1.05 + g }, start, away(h) * end)
        })
    }

    /// The miss of the end by a ray in its plane, positive on one side of it and negative on the
    /// other; `None` if the ray misses the lens or leads away from the end.
    fn miss(lens: &Lens, start: DVec3, end: DVec3, turned: f64) -> Option<f64> {
        let across = (end - end.project_onto(start)).normalize();
        let direction = turned.sin() * across - turned.cos() * start.normalize();
        let [exit, leaving] = bend(lens, start, direction)?;
        let to_end = end - exit;
        let plane = start.cross(end).normalize();
        (leaving.dot(to_end) > 0.0).then(|| leaving.cross(to_end).dot(plane))
    }

    #[test]
    fn every_refracted_path_is_found_and_obeys_snell() {
        let mut counts = [0; 4];
        for (lens, start, end) in cases() {
            let (from, to) = (start.as_dvec3(), end.as_dvec3());
            let found: Vec<Crossing> = lens.crossings(start, End::Point(end)).collect();
            for crossing in &found {
                let direction = crossing.direction.as_dvec3().normalize();
                let [exit, leaving] = bend(&lens, from, direction).expect("a hit");
                assert!(exit.distance(crossing.exit.as_dvec3()) < 2e-5, "{lens:?} {crossing:?}");
                let to_end = (to - exit).normalize();
                // A direction rounded to `f32` is bent further where the ray grazes.
                assert!(leaving.distance(to_end) < 1e-4, "{lens:?} {crossing:?}");
            }
            const STEPS: i32 = 8_000;
            let near = from.length() / f64::from(lens.ball.radius);
            // Even steps of the angle at the surface, so that rays that graze it are as many.
            let turned =
                |step: i32| ((FRAC_PI_2 * f64::from(step) / f64::from(STEPS)).sin() / near).asin();
            let misses: Vec<_> =
                (1 - STEPS..STEPS).map(|step| miss(&lens, from, to, turned(step))).collect();
            let changes = |pair: &[Option<f64>]| match *pair {
                [Some(a), Some(b)] => (a < 0.0) != (b < 0.0),
                _ => false,
            };
            let expected = misses.windows(2).filter(|pair| changes(pair)).count();
            assert_eq!(found.len(), expected, "{lens:?} from {start} to {end}");
            counts[expected] += 1;
        }
        assert!(counts.iter().all(|&count| count > 5), "numbers of paths: {counts:?}");
    }

    #[test]
    fn beams_are_as_wide_as_neighbouring_rays_say() {
        for (lens, start, end) in cases() {
            let from = start.as_dvec3();
            for crossing in lens.crossings(start, End::Point(end)) {
                let direction = crossing.direction.as_dvec3().normalize();
                let beam = lens.beam(start, crossing.direction, End::Point(end)).expect("a beam");
                let ratio = beam.spread / crossing.beam.spread;
                let [exit, leaving] = bend(&lens, from, direction).expect("a hit");
                let distance = exit.distance(end.as_dvec3());
                let (x, y) = direction.any_orthonormal_pair();
                let step = 1e-6;
                let ray = |offset: DVec3| bend(&lens, from, (direction + offset).normalize());
                let [Some(x0), Some(x1), Some(y0), Some(y1)] =
                    [ray(-step * x), ray(step * x), ray(-step * y), ray(step * y)]
                else {
                    continue;
                };
                // Places across the path at its end, and directions for an end in the sky.
                let place = |[exit, leaving]: [DVec3; 2]| exit + distance * leaving;
                let per_area = 4.0 * step * step
                    / (place(x1) - place(x0)).cross(place(y1) - place(y0)).dot(leaving).abs();
                let per_angle =
                    4.0 * step * step / (x1[1] - x0[1]).cross(y1[1] - y0[1]).dot(leaving).abs();
                let sky = lens.beam(start, crossing.direction, End::Sky(leaving.as_vec3()));
                let sky = f64::from(sky.expect("a beam").spread);
                let spread = f64::from(crossing.beam.spread);
                // Where rays meet again, their area changes within the step.
                let steep = spread * distance * distance > 1e3 || sky > 1e3;
                assert!(steep || (ratio - 1.0).abs() < 2e-2, "{lens:?} {start} {end}: {ratio}");
                assert!(
                    steep || (spread / per_area - 1.0).abs() < 2e-2,
                    "{lens:?} {start} {end}: {spread}, not {per_area}"
                );
                assert!(
                    steep || (sky / per_angle - 1.0).abs() < 2e-2,
                    "{lens:?} {start} {end}: {sky}, not {per_angle}"
                );
            }
        }
    }
}
