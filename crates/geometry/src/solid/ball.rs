//! The sphere as a solid.

use glam::{DVec3, Vec3};

use super::{End, ExactInterval, Filtered, Interval, ROUNDING, Solid, filtered, unbounded};
use crate::double_double::{DoubleDouble, Real};
use crate::filter::CANCELLATION;
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Hit, Ray, Sphere, widen};

impl Solid for Sphere {
    #[inline]
    fn interval(&self, ray: &Ray) -> Option<Interval> {
        filtered(filter(self, ray), || self.interval_exactly(ray))
    }

    #[cold]
    #[inline(never)]
    fn interval_exactly(&self, ray: &Ray) -> Option<ExactInterval> {
        let [entry, exit] = self.roots_in_double_double(ray)?;
        let finite = entry.nearest().is_finite() && exit.nearest().is_finite();
        finite.then_some(ExactInterval { entry, exit })
    }

    #[inline]
    fn crossing(&self, ray: &Ray, end: End) -> Option<Hit> {
        match end {
            End::Entry => self.closest(&unbounded(ray)),
            End::Exit => self.exit(ray),
        }
    }

    #[inline]
    fn contains(&self, point: Vec3) -> bool {
        let (c, r) = widen::ball(self.center, self.radius);
        let f = point.as_dvec3() - c;
        let (square, radius2) = (f.dot(f), r * r);
        let difference = square - radius2;
        // Written so that a NaN fails.
        if !(difference <= ROUNDING * (square + radius2) && r > 0.0) {
            return false;
        }
        difference < -ROUNDING * (square + radius2) || self.contains_exactly(point)
    }
}

/// Computes the interval in `f64`.
#[inline(always)]
fn filter(ball: &Sphere, ray: &Ray) -> Filtered {
    let (c, r) = widen::ball(ball.center, ball.radius);
    let (o, d) = widen::ray(ray);
    if r > 0.0 { chord(o - c, r, d) } else { Filtered::Miss }
}

/// Intersects the line `f + t d` with the ball of radius `r` about the origin.
///
/// With `w = f × d` and `a = d·d`, the roots are `(-f·d ∓ sqrt(a r² - w·w)) / a`. The error of `w`
/// is a share of `|f| |d|`.
#[inline(always)]
pub(super) fn chord(f: DVec3, r: f64, d: DVec3) -> Filtered {
    let (w, a, along) = (f.cross(d), d.dot(d), f.dot(d));
    let square = a * (r * r);
    let discriminant = square - w.dot(w);
    let reach = (f.dot(f) * a).sqrt();
    // The terms of the discriminant, times the digits that they may lose.
    let terms = square + reach * square.sqrt();
    // A NaN is uncertain.
    let certain = discriminant.abs() > CANCELLATION * square + 16.0 * ROUNDING * terms;
    if !certain {
        return Filtered::Uncertain;
    }
    if discriminant < 0.0 {
        return Filtered::Miss;
    }
    let root = discriminant.sqrt();
    let over_a = a.recip();
    Filtered::Found(Interval {
        entry: (-along - root) * over_a,
        exit: (root - along) * over_a,
        error: ROUNDING * (reach + root + terms / root) * over_a,
    })
}

impl Sphere {
    #[cold]
    #[inline(never)]
    fn contains_exactly(&self, point: Vec3) -> bool {
        let squares = [0, 1, 2].map(|i| {
            let f = DoubleDouble::exact(point[i]) - DoubleDouble::exact(self.center[i]);
            f * f
        });
        let r = DoubleDouble::exact(self.radius);
        squares[0] + squares[1] + squares[2] - r * r <= DoubleDouble::ZERO
    }
}
