//! The rounded cone.
//!
//! # Derivation
//!
//! Let `p0` be the origin, `e = p1 - p0`, `L² = e·e`, `ρ = r0 - r1`, and `d2 = L² - ρ²`, which is
//! positive unless one ball contains the other. The balls `|x - s e| = r0 - s ρ`, `0 <= s <= 1`,
//! sweep the solid; they touch the cone that is tangent to both end balls. A point `x` of the cone
//! belongs to the ball `s = y / d2`, with `y = x·e - r0 ρ`, so the body is the part with
//! `0 <= y <= d2` and the caps lie on either side of these two planes.
//!
//! On the ray `f + t d`, `f = o - p0`, the cone is a quadratic whose usual discriminant
//! `k1² - k0 k2` has terms that grow with the fourth power of the distance. Let `w = f × d`,
//! `g = d × e` and `w1 = w + g = (o - p1) × d`. In these the terms that grow with the distance
//! cancel symbolically, before any rounding, which generalizes the use of Lagrange's identity for
//! the sphere to two balls:
//!
//! ```text
//! discriminant = d2 D        D = |r0 w1 - r1 w|² - (f·g)²
//! ```
//!
//! where the volume `f·g` is proportional to the distance of the line from the axis. The roots are
//! measured from the point of the line closest to `p0`, as `θ = a (t - tc)` with `a = d·d` and
//! `tc = -f·d / a`:
//!
//! ```text
//! k2 θ² + 2 K1 θ + K0 = 0      k2 = |g|² - ρ² a      K1 = -m Y      K0 = a d2 (|w|² - r0² a) - Y²
//! a y = Y + m θ                Y = -(w·g) - r0 ρ a   m = d·e        θ = (-K1 ∓ a sqrt(d2 D)) / k2
//! ```
//!
//! # Which form of the root
//!
//! If `K1 >= 0`, both terms of the entry have one sign. Otherwise they cancel, and the entry also
//! is `K0 / (S - K1)` with `S = a sqrt(d2 D)`. Both terms of `K0` are negative if the line passes
//! within `r0` of `p0`: no digit cancels. If it passes farther away, `|K0|` may be as little as
//! `r² a / |w|²` of its terms, which on a slender cone leaves no digit at all: a hit halfway along
//! `10⁵` radii would be off by `10⁻⁵` radii. Then the difference is the better form: the error of
//! its terms is `2⁻⁵³ (|K1| + S) / k2`, against `2⁻⁵³ a d2 |w|² / (|K1| + S)`, and since
//! `|Y| <= |w| |g|` the first is less by the squared cosine between the ray and the axis.
//!
//! # Which part is hit
//!
//! The solid lies inside its tangent cone, so a line that misses the cone misses the solid. The
//! place at which the ray enters the cone (`y` below 0, within `0..=d2`, above `d2`) decides
//! whether it enters the solid through the cap about `p0`, the body, or the cap about `p1`: the
//! part of the cone between the two planes is in the solid, so a ray cannot cross it without having
//! entered. The same holds for the exit. A line steeper than the cone (`k2 < 0`) comes from, or
//! goes to, infinity inside the cone, on the side of the larger ball, and the cap of that ball
//! decides.
//!
//! Source: I. Quilez, "Rounded cone intersection", 2018, for the quadratic (`k2`, `y`, `d2` are
//! his).

mod exact;
mod profile;

use glam::{DVec3, Vec2, Vec3};

use crate::double_double::DoubleDouble;
use crate::filter::{CANCELLATION, FAR, Filtered, Solve, queries};
use crate::float::{F64_ROUNDOFF, error, off_sphere, round};
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Aabb, Hit, Ray, Sphere, widen};
use exact::{Crossing, End};
use profile::Profile;

/// The surface of the convex hull of two balls, `(p0, r0)` and `(p1, r1)`: a tapered capsule.
///
/// # Accuracy
///
/// `t` is the exact root, rounded. The position is within `1.0 u max(|p|, size)` of the surface,
/// `u = 2⁻²⁴`, and the normal within `1e-5` degrees, for lengths up to a million radii.
///
/// # Degenerate inputs
///
/// If one ball contains the other, or both have the same center, the shape is the larger ball. One
/// radius may be zero: that end is a tip. The normal of a hit there is along the axis, and that of
/// [`Self::normal`] is the limit of the normals of the body. If both radii are zero, or one is
/// negative or NaN, or a center is not finite, every ray misses.
///
/// ```
/// use rotund_geometry::glam::Vec3;
/// use rotund_geometry::{Ray, RoundedCone};
///
/// let tube = RoundedCone { p0: Vec3::ZERO, r0: 1.0, p1: 3.0 * Vec3::Z, r1: 1.0 };
/// let hit = tube.closest(&Ray::new(Vec3::new(-5.0, 0.0, 1.5), Vec3::X)).expect("a hit");
/// assert_eq!((hit.t, hit.normal), (4.0, Vec3::NEG_X));
/// assert_eq!(tube.uv(&hit).x, 0.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RoundedCone {
    /// The center of the first ball.
    pub p0: Vec3,
    /// The radius of the first ball; not negative, and one of the two is positive.
    pub r0: f32,
    /// The center of the second ball.
    pub p1: Vec3,
    /// The radius of the second ball.
    pub r1: f32,
}

/// The capsule of radius 1 about the segment from the origin to `(0, 1, 0)`.
impl Default for RoundedCone {
    fn default() -> Self {
        Self { p0: Vec3::ZERO, r0: 1.0, p1: Vec3::Y, r1: 1.0 }
    }
}

/// A crossing before rounding: the ball `s` that it belongs to, and the point relative to the
/// center of that ball.
pub(crate) struct Root {
    t: f32,
    s: f64,
    from_ball: DVec3,
    normal: DVec3,
}

queries!(
    RoundedCone,
    /// Returns the first crossing of the surface with `t` in `t_min..=t_max`.
    ///
    /// For a ray that starts inside, this is the exit.
);

impl Solve for RoundedCone {
    type Root = Root;

    /// Finds the entry of a ray that starts outside; [`Self::solve_exactly`] finds exits.
    #[inline(always)]
    fn filter(&self, ray: &Ray) -> Filtered<Root> {
        let ((p0, r0), (p1, r1)) = (widen::ball(self.p0, self.r0), widen::ball(self.p1, self.r1));
        let (o, d) = widen::ray(ray);
        let (e, f) = (p1 - p0, o - p0);
        let rho = r0 - r1;
        let d2 = e.dot(e) - rho * rho;
        let w = f.cross(d);
        let g = d.cross(e);
        let moment = r0 * g + rho * w;
        let volume = f.dot(g);
        let moment2 = moment.dot(moment);
        let discriminant = moment2 - volume * volume;
        let grazing = CANCELLATION * moment2;
        // Written so that a NaN fails.
        if !(discriminant > grazing && d2 > 0.0) {
            return if d2 > 0.0 && discriminant < -grazing {
                Filtered::Miss
            } else {
                Filtered::Uncertain
            };
        }
        let (a, b, m) = (d.dot(d), f.dot(d), d.dot(e));
        let width = a * d2;
        let inverse = width.recip();
        let over_a = inverse * d2;
        let (gg, ww, rho_a) = (g.dot(g), w.dot(w), rho * a);
        let k2 = gg - rho * rho_a;
        let square0 = r0 * r0 * a;
        let y0 = -w.dot(g) - r0 * rho_a;
        let k1 = -m * y0;
        let spread = a * (d2 * discriminant).sqrt();
        // See "Which form of the root".
        let (over, under) = if k1.is_sign_positive() | (ww > square0) {
            (-k1 - spread, k2)
        } else {
            (width * (ww - square0) - y0 * y0, spread - k1)
        };
        let theta = over / under;
        let y = y0 + m * theta;
        // Rare cases are uncertain: a line steeper than the cone, a length of more than a million
        // radii, and an origin more than 2²⁵ radii away, or nearer where the ray grazes.
        let thinnest = r0.min(r1);
        let slim = d2 > 1e12 * (thinnest * thinnest);
        let near = b * b * moment2 < FAR * (thinnest * thinnest) * a * discriminant;
        if !((k2 > 0.0) & (thinnest > 0.0) & !slim & near) {
            return Filtered::Uncertain;
        }
        let (t64, from_ball, s, radius);
        if y >= 0.0 && y <= width {
            let difference = theta - b;
            // The rounding error of `theta` is half the chord times the lost share of `D`, which
            // also bounds a share of K1; that of `b` is a share of its terms, which cancel where
            // the ray starts next to `p0`.
            let scale = spread * moment2 + f.abs().dot(d.abs()) * k2 * discriminant;
            if difference.abs() * k2 * discriminant < CANCELLATION * scale {
                return Filtered::Uncertain;
            }
            t64 = difference * over_a;
            s = y * inverse;
            from_ball = (f + t64 * d) - s * e;
            radius = r0 - s * rho;
        } else {
            // The cap on the side of the entry.
            let (center, along, square, passing);
            if y < 0.0 {
                (center, along, square, passing, s, radius) = (f, b, square0, ww, 0.0, r0);
            } else {
                let w1 = w + g;
                (center, along, square, passing, s, radius) =
                    (f - e, b - m, r1 * r1 * a, w1.dot(w1), 1.0, r1);
            }
            let chord = square - passing;
            let grazing = CANCELLATION * square;
            if chord < -grazing {
                return Filtered::Miss;
            }
            let root = chord.sqrt();
            let (near, far) = (-along - root, -along + root);
            if (chord <= grazing) | ((near * far).abs() <= grazing) {
                return Filtered::Uncertain;
            }
            t64 = near * over_a;
            from_ball = center + t64 * d;
        }
        match ray.accept(t64) {
            Some(t) => Filtered::Hit(Root { t, from_ball, s, normal: from_ball * radius.recip() }),
            None if t64 as f32 > ray.t_max => Filtered::Miss,
            None => Filtered::Uncertain,
        }
    }

    /// Finds the entry or the exit of any ray.
    #[cold]
    #[inline(never)]
    fn solve_exactly(&self, ray: &Ray) -> Option<Root> {
        if let Some((ball, s)) = self.one_ball() {
            return Self::solve_ball(&ball, s, ray);
        }
        Some(self.root(exact::solve(self, ray)?))
    }

    #[inline(always)]
    fn t(root: &Root) -> f32 {
        root.t
    }

    #[inline(always)]
    fn hit(&self, _: &Ray, Root { t, s, from_ball, normal }: Root) -> Hit {
        let ((p0, r0), (p1, r1)) = (widen::ball(self.p0, self.r0), widen::ball(self.p1, self.r1));
        let e = p1 - p0;
        let position = round(p0 + s * e + from_ball);
        // The center of the ball has a rounding of `e` and one of the product, and its radius two
        // of `s ρ`, which is shorter than `s e`. The rounding of the sum is one of the position and
        // one of `from_ball`, as for a sphere.
        let off =
            off_sphere(r0 + s * (r1 - r0), normal) + 4.0 * F64_ROUNDOFF * s * e.abs().element_sum();
        Hit {
            t,
            position,
            error: error(position, off),
            normal: round(normal),
            parameters: Vec2::new(s as f32, 0.0),
        }
    }
}

impl RoundedCone {
    /// Returns whether one ball contains the other; false for a NaN.
    fn is_one_ball(&self) -> bool {
        let e = self.p1.as_dvec3() - self.p0.as_dvec3();
        let rho = f64::from(self.r0) - f64::from(self.r1);
        e.dot(e) - rho * rho <= 0.0
    }

    /// Returns the larger ball and its place on the axis, if it contains the other ball.
    pub(crate) fn one_ball(&self) -> Option<(Sphere, f64)> {
        if !self.is_one_ball() {
            return None;
        }
        let [first, second] = [(self.p0, self.r0), (self.p1, self.r1)]
            .map(|(center, radius)| Sphere { center, radius });
        // No ray hits a ball without radius.
        let none = Sphere { radius: 0.0, ..first };
        if !(self.r0.min(self.r1) >= 0.0 && self.p0.is_finite() && self.p1.is_finite()) {
            return Some((none, 0.0));
        }
        Some(if self.r0 >= self.r1 { (first, 0.0) } else { (second, 1.0) })
    }

    /// Solves for the larger ball, where it contains the other.
    fn solve_ball(ball: &Sphere, s: f64, ray: &Ray) -> Option<Root> {
        let root = match ball.filter(ray) {
            Filtered::Hit(root) => root,
            Filtered::Miss => return None,
            Filtered::Uncertain => ball.solve_exactly(ray)?,
        };
        Some(Root { t: root.t, s, from_ball: root.from_center, normal: root.normal })
    }

    /// Completes a crossing by its normal.
    fn root(&self, Crossing { t, s, from_ball, .. }: Crossing) -> Root {
        let radius = f64::from(self.r0) + s * (f64::from(self.r1) - f64::from(self.r0));
        let normal = from_ball / radius;
        let square = normal.dot(normal);
        if (square - 1.0).abs() < 1e-9 {
            return Root { t, s, from_ball, normal };
        }
        // A tip of radius zero has many normals; the axis is one of them. At distances at which 106
        // bits are too few, the nearest point of the ball is taken.
        let e = self.p1.as_dvec3() - self.p0.as_dvec3();
        let normal = from_ball.normalize_or((if s < 0.5 { -e } else { e }).normalize_or(DVec3::Y));
        Root { t, s, from_ball: radius * normal, normal }
    }

    /// Returns the hit where the line of an unbounded ray leaves the solid.
    pub(crate) fn exit(&self, ray: &Ray) -> Option<Hit> {
        if let Some((ball, s)) = self.one_ball() {
            return ball.exit(ray).map(|hit| Hit { parameters: Vec2::new(s as f32, 0.0), ..hit });
        }
        Some(self.hit(ray, self.root(exact::exit(self, ray)?)))
    }

    /// Returns where the line of the ray enters and leaves the solid, with 106 bits. The shape must
    /// not be a single ball.
    pub(crate) fn roots_in_double_double(&self, ray: &Ray) -> Option<[DoubleDouble; 2]> {
        let ray = Ray { t_min: f32::NEG_INFINITY, t_max: f32::INFINITY, ..*ray };
        let root = |end| Some(exact::solve_in_double_double(self, &ray, &[end])?.root);
        Some([root(End::Entry)?, root(End::Exit)?])
    }

    /// Returns a box that contains the shape and every position that [`Self::closest`] reports for
    /// a ray that starts up to 2²⁶ sizes away.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let (r0, r1) = (Vec3::splat(self.r0), Vec3::splat(self.r1));
        Aabb { min: (self.p0 - r0).min(self.p1 - r1), max: (self.p0 + r0).max(self.p1 + r1) }
            .grown_by_rounding()
    }

    /// Returns the surface parameters of a hit: along the profile and around the axis, see
    /// [`Self::position`].
    #[must_use]
    pub fn uv(&self, hit: &Hit) -> Vec2 {
        Profile::new(self).uv(f64::from(hit.parameters.x), hit.normal.as_dvec3())
    }

    /// Returns the point at the fraction `u` of the profile, and at the angle `2 pi v` around the
    /// axis.
    ///
    /// The profile is parametrized by arc length. It runs from the pole of the cap about `p0` over
    /// this cap, the body and the other cap to the pole about `p1`.
    #[must_use]
    pub fn position(&self, uv: Vec2) -> Vec3 {
        round(Profile::new(self).position(uv))
    }

    /// Returns the place on the axis that belongs to [`Self::position`]: the center of the ball
    /// that touches the surface there is `p0` at 0, `p1` at 1, and linearly interpolated in
    /// between.
    ///
    /// Interpolate values given at the two ends, such as colors, by it.
    #[must_use]
    pub fn along_axis(&self, uv: Vec2) -> f32 {
        Profile::new(self).ball(uv) as f32
    }

    /// Returns the outward unit normal at [`Self::position`].
    #[must_use]
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        round(Profile::new(self).normal(uv))
    }

    /// Returns the derivatives of [`Self::position`] by `u` and by `v`. The second is zero at the
    /// poles.
    #[must_use]
    pub fn tangents(&self, uv: Vec2) -> (Vec3, Vec3) {
        let (du, dv) = Profile::new(self).tangents(uv);
        (round(du), round(dv))
    }
}
