//! Solids: the interval of a line inside a sphere or a rounded cone, and whether a point is inside.
//!
//! Unions of solids are decided by the order of the crossings of different solids along one line.
//! The order of two crossings is certain if they differ by more than their error bounds in `f64`;
//! otherwise both are computed with 106 bits.

mod ball;
mod cone;

use core::cmp::Ordering;

use glam::Vec3;

use crate::double_double::DoubleDouble;
use crate::{Hit, Primitive, Ray};

/// An end of the interval of a line inside a convex solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum End {
    /// The line enters the solid.
    Entry,
    /// The line leaves the solid.
    Exit,
}

/// The `t` between which the line of a ray is inside a convex solid, before rounding to `f32`.
///
/// The interval is that of the whole line: it may begin before `t_min` and end after `t_max`, and
/// its ends may be negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Where the line enters the solid.
    pub entry: f64,
    /// Where the line leaves the solid.
    pub exit: f64,
    /// Bound on the absolute error of `entry` and `exit`. NaN or infinite where `f64` has too few
    /// digits to bound it.
    pub error: f64,
}

/// The same as [`Interval`] with 106 bits, for comparisons that `f64` cannot decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactInterval {
    entry: DoubleDouble,
    exit: DoubleDouble,
}

impl Interval {
    /// Returns the `t` of one end.
    #[must_use]
    #[inline]
    pub fn end(&self, end: End) -> f64 {
        match end {
            End::Entry => self.entry,
            End::Exit => self.exit,
        }
    }
}

impl ExactInterval {
    fn end(&self, end: End) -> DoubleDouble {
        match end {
            End::Entry => self.entry,
            End::Exit => self.exit,
        }
    }

    /// Compares one end with an end of the interval of another solid on the same ray.
    #[must_use]
    pub fn compare(&self, end: End, other: &Self, other_end: End) -> Ordering {
        // Neither is NaN: intervals are only made of numbers.
        self.end(end).partial_cmp(&other.end(other_end)).unwrap_or(Ordering::Equal)
    }

    /// Compares one end with `t`.
    #[must_use]
    pub fn compare_with(&self, end: End, t: f32) -> Ordering {
        let t = <DoubleDouble as crate::double_double::Real>::exact(t);
        self.end(end).partial_cmp(&t).unwrap_or(Ordering::Equal)
    }
}

/// A closed convex solid: [`Sphere`](crate::Sphere) and [`RoundedCone`](crate::RoundedCone).
///
/// A line crosses its surface twice, where it enters and where it leaves, or touches it once, or
/// misses it. Points of the surface belong to the solid.
///
/// ```
/// use rotund_geometry::glam::Vec3;
/// use rotund_geometry::{End, Ray, Solid, Sphere};
///
/// let ball = Sphere { center: Vec3::ZERO, radius: 1.0 };
/// let ray = Ray::new(Vec3::new(0.5, 0.0, 0.0), Vec3::X);
/// let inside = ball.interval(&ray).expect("the line passes through the ball");
/// assert_eq!((inside.entry, inside.exit), (-1.5, 0.5));
/// let entry = ball.crossing(&ray, End::Entry).expect("behind the origin");
/// assert_eq!((entry.t, entry.normal), (-1.5, Vec3::NEG_X));
/// assert!(ball.contains(Vec3::X) && !ball.contains(1.001 * Vec3::X));
/// ```
pub trait Solid: Primitive {
    /// Returns the interval of the line inside the solid; `None` if the line misses it, which is
    /// certain.
    ///
    /// The interval of the ray, `t_min..=t_max`, does not matter. A ray with a NaN or an infinity,
    /// or with a zero direction, misses.
    fn interval(&self, ray: &Ray) -> Option<Interval>;

    /// Returns [`interval`](Self::interval) with 106 bits.
    fn interval_exactly(&self, ray: &Ray) -> Option<ExactInterval>;

    /// Returns the hit at one end of [`interval`](Self::interval), whether or not it is in the
    /// interval of the ray.
    ///
    /// If the entry is in the interval of the ray, it is the hit that
    /// [`closest`](Primitive::closest) returns, to the bit. An exit agrees with that of a ray that
    /// starts inside to one unit in the last place.
    fn crossing(&self, ray: &Ray, end: End) -> Option<Hit>;

    /// Returns whether the point is in the solid or on its surface, with a certain sign: in `f64`
    /// if that decides, else with 106 bits. A solid that no ray can hit, and a point that is not
    /// finite, give `false`.
    fn contains(&self, point: Vec3) -> bool;
}

/// The line of a ray without limits.
fn unbounded(ray: &Ray) -> Ray {
    Ray { t_min: f32::NEG_INFINITY, t_max: f32::INFINITY, ..*ray }
}

/// The result of computing an interval in `f64`.
enum Filtered {
    Miss,
    Found(Interval),
    /// `f64` cannot tell whether the line meets the solid.
    Uncertain,
}

/// Returns the interval in `f64` if that suffices to find it, else by `exactly`.
#[inline(always)]
fn filtered(filter: Filtered, exactly: impl FnOnce() -> Option<ExactInterval>) -> Option<Interval> {
    match filter {
        Filtered::Miss => None,
        Filtered::Found(interval) => Some(interval),
        Filtered::Uncertain => {
            let exact = exactly()?;
            let [entry, exit] = [exact.entry, exact.exit]
                .map(<DoubleDouble as crate::double_double::Real>::nearest);
            // Rounded to 53 bits.
            let error = f64::EPSILON * entry.abs().max(exit.abs()) + f64::MIN_POSITIVE;
            Some(Interval { entry, exit, error })
        }
    }
}

/// Bound on the error of a term of the intervals in `f64`, as a share of its parts: sixteen
/// roundings.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
