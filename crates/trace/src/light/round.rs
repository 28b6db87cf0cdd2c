//! Sampling the visible part of round emitters.

use super::flat::linear;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A point on a round emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoundPoint {
    pub(super) position: Vec3,
    /// Outward normal of unit length.
    pub(super) normal: Vec3,
    pub(super) density: Density,
}

/// A density per area or per solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Density {
    Area(f32),
    SolidAngle(f32),
}

/// A ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) center: Vec3,
    pub(super) radius: f32,
}

impl Ball {
    pub(super) fn area(&self) -> f32 {
        2.0 * TAU * self.radius * self.radius
    }

    /// Returns `1 - cos` of the half angle that the ball subtends, or `None` from inside.
    fn aperture(&self, from: Vec3) -> Option<f32> {
        let distance2 = self.center.distance_squared(from);
        let sine2 = self.radius * self.radius / distance2;
        (sine2 < 1.0).then(|| sine2 / (1.0 + (1.0 - sine2).sqrt()))
    }

    /// True if `from` is inside of the ball.
    pub(super) fn holds(&self, from: Vec3) -> bool {
        self.aperture(from).is_none()
    }

    /// Returns the density of [`Self::sample`]: uniform over the cone of directions to the ball, or
    /// over the surface if `from` is inside.
    pub(super) fn density(&self, from: Vec3) -> Density {
        match self.aperture(from) {
            Some(aperture) => Density::SolidAngle(1.0 / (TAU * aperture)),
            None => Density::Area(1.0 / self.area()),
        }
    }

    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> RoundPoint {
        let density = self.density(from);
        let normal = match self.aperture(from) {
            None => crate::warp::sphere(u),
            Some(aperture) => {
                let to_eye = (from - self.center).normalize();
                let distance = self.center.distance(from);
                // The angle at the eye is sampled; the law of sines gives the angle at the center.
                let away = u.x * aperture;
                let cosine = 1.0 - away;
                let sine2 = away * (2.0 - away);
                let sine_max2 = aperture * (2.0 - aperture);
                let reach = distance * cosine - distance * (sine_max2 - sine2).max(0.0).sqrt();
                let height = (distance - reach * cosine) / self.radius;
                let side = reach * sine2.sqrt() / self.radius;
                let (x, y) = to_eye.any_orthonormal_pair();
                let around = Vec2::from_angle(TAU * u.y);
                (height * to_eye + side * (around.x * x + around.y * y)).normalize()
            }
        };
        RoundPoint { position: self.center + self.radius * normal, normal, density }
    }
}

/// A rounded cone: the convex hull of two balls, neither of which contains the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    pub(super) balls: [Ball; 2],
    /// Direction from the first center to the second, of unit length.
    axis: Vec3,
    length: f32,
    /// Sine of the angle between the normals of the flank and the plane perpendicular to the axis.
    sine: f32,
    cosine: f32,
    /// Whether the caps are sampled.
    caps: [bool; 2],
}

/// The parts of a cone's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// The cap of the ball of this index.
    Cap(usize),
    Flank,
}

impl Cone {
    /// Returns `None` if one ball contains the other.
    pub(super) fn try_new(balls: [Ball; 2]) -> Option<Self> {
        let [b0, b1] = balls;
        let length = b0.center.distance(b1.center);
        let sine = (b0.radius - b1.radius) / length;
        (sine.abs() < 1.0).then(|| Self {
            balls,
            axis: (b1.center - b0.center) / length,
            length,
            sine,
            cosine: ((1.0 - sine) * (1.0 + sine)).sqrt(),
            caps: [true; 2],
        })
    }

    /// Returns the cone with only these caps sampled.
    pub(super) fn with_caps(self, caps: [bool; 2]) -> Self {
        Self { caps, ..self }
    }

    /// Returns the areas of both caps and the flank; zero for caps that are not sampled.
    fn areas(&self) -> [f32; 3] {
        let [r0, r1] = self.balls.map(|ball| ball.radius);
        let of_cap = |index: usize, area: f32| if self.caps[index] { area } else { 0.0 };
        [
            of_cap(0, TAU * r0 * r0 * (1.0 + self.sine)),
            of_cap(1, TAU * r1 * r1 * (1.0 - self.sine)),
            // Mean circumference times slant height; both have the cosine as a factor.
            PI * (r0 + r1) * self.cosine * self.length * self.cosine,
        ]
    }

    pub(super) fn area(&self) -> f32 {
        self.areas().iter().sum()
    }

    /// Returns half the range of azimuths at which the flank faces `from`, and the middle of the
    /// range.
    ///
    /// A tangent plane of the flank is tangent to both balls, so a generator with normal n is
    /// visible if n . (from - p0) > r0. With n = cosine * radial + sine * axis that bounds the
    /// azimuth.
    fn visible_flank(&self, from: Vec3) -> (f32, Vec3) {
        let to = from - self.balls[0].center;
        let along = to.dot(self.axis);
        let across = to - along * self.axis;
        let bound = (self.balls[0].radius - self.sine * along) / (self.cosine * across.length());
        let middle = across.try_normalize().unwrap_or_else(|| self.axis.any_orthonormal_vector());
        // On the axis the bound is infinite with either sign, or NaN if the cone has no flank.
        (if bound.is_nan() { 0.0 } else { bound.clamp(-1.0, 1.0).acos() }, middle)
    }

    /// Returns the visible areas of both caps and the flank, with half of each cap: the
    /// probabilities of the parts up to normalization.
    fn visible_areas(&self, from: Vec3) -> [f32; 3] {
        let [cap0, cap1, flank] = self.areas();
        let (half_range, _) = self.visible_flank(from);
        [0.5 * cap0, 0.5 * cap1, flank * half_range / PI]
    }

    /// True if `from` is inside of the cone.
    pub(super) fn holds(&self, from: Vec3) -> bool {
        let to = from - self.balls[0].center;
        let along = to.dot(self.axis);
        let across = (to - along * self.axis).length();
        // The line from the point against the normal of the flank meets the axis here.
        let nearest = (along - across * self.sine / self.cosine).clamp(0.0, self.length);
        let radius = self.balls[0].radius - self.sine * nearest;
        (along - nearest).powi(2) + across * across <= radius * radius
    }

    fn part_at(&self, position: Vec3) -> Part {
        let along = (position - self.balls[0].center).dot(self.axis);
        if along < self.balls[0].radius * self.sine {
            Part::Cap(0)
        } else if along > self.length + self.balls[1].radius * self.sine {
            Part::Cap(1)
        } else {
            Part::Flank
        }
    }

    /// Returns the density of [`Self::sample`] at a point of the surface.
    pub(super) fn density(&self, from: Vec3, position: Vec3) -> Density {
        if self.holds(from) {
            return Density::Area(1.0 / self.area());
        }
        let areas = self.visible_areas(from);
        let sum: f32 = areas.iter().sum();
        if sum <= 0.0 {
            return Density::Area(0.0);
        }
        match self.part_at(position) {
            Part::Cap(index) => match self.balls[index].density(from) {
                Density::Area(pdf) => Density::Area(areas[index] / sum * pdf),
                Density::SolidAngle(pdf) => Density::SolidAngle(areas[index] / sum * pdf),
            },
            // The probability of the flank over its visible area.
            Part::Flank => Density::Area(1.0 / sum),
        }
    }

    /// Samples a point: uniformly over the visible flank, or over the directions to the ball of a
    /// cap. Returns `None` if the point of that ball does not belong to its cap, and is inside of
    /// the cone, or if only caps could be visible and none is sampled.
    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> Option<RoundPoint> {
        let inside = self.holds(from);
        let areas = if inside { self.areas() } else { self.visible_areas(from) };
        let sum: f32 = areas.iter().sum();
        if sum <= 0.0 {
            return None;
        }
        let place = u.x * sum;
        let rest = |before: f32, area: f32| {
            Vec2::new(((place - before) / area).clamp(0.0, 1.0_f32.next_down()), u.y)
        };
        let caps = areas[0] + areas[1];
        if place >= caps && areas[2] > 0.0 {
            let (half_range, middle) = if inside {
                (PI, self.axis.any_orthonormal_vector())
            } else {
                self.visible_flank(from)
            };
            let [position, normal] = self.flank(rest(caps, areas[2]), half_range, middle);
            return Some(RoundPoint { position, normal, density: Density::Area(1.0 / sum) });
        }
        let is_first = place < areas[0] || areas[1] <= 0.0;
        let (index, before) = if is_first { (0, 0.0) } else { (1, areas[0]) };
        let u = rest(before, areas[index]);
        if inside {
            let [position, normal] = self.cap(index, u);
            return Some(RoundPoint { position, normal, density: Density::Area(1.0 / sum) });
        }
        let point = self.balls[index].sample(from, u);
        (self.part_at(point.position) == Part::Cap(index))
            .then(|| RoundPoint { density: self.density(from, point.position), ..point })
    }

    /// Samples position and normal uniformly over the flank within the azimuth `half_range` of
    /// `middle`.
    fn flank(&self, u: Vec2, half_range: f32, middle: Vec3) -> [Vec3; 2] {
        let [b0, b1] = self.balls;
        let along = linear(b0.radius, b1.radius, u.x);
        let around = Vec2::from_angle((2.0 * u.y - 1.0) * half_range);
        let radial = around.x * middle + around.y * self.axis.cross(middle);
        let normal = (self.cosine * radial + self.sine * self.axis).normalize();
        let center = b0.center + along * self.length * self.axis;
        let radius = b0.radius + along * (b1.radius - b0.radius);
        [center + radius * normal, normal]
    }

    /// Samples position and normal uniformly over the cap of a ball.
    fn cap(&self, index: usize, u: Vec2) -> [Vec3; 2] {
        let Ball { center, radius } = self.balls[index];
        // By Archimedes, area is uniform along the axis, here between the flank and the pole.
        let pole = if index == 0 { -1.0 } else { 1.0 };
        let height = self.sine + u.x * (pole - self.sine);
        let side = ((1.0 - height) * (1.0 + height)).max(0.0).sqrt();
        let (x, y) = self.axis.any_orthonormal_pair();
        let around = Vec2::from_angle(TAU * u.y);
        let normal = height * self.axis + side * (around.x * x + around.y * y);
        [center + radius * normal, normal]
    }
}
