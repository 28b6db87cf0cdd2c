//! The rounded cone as a solid.
//!
//! The letters and the derivation of the roots are those of the module `rounded_cone`.
//!
//! A point `x`, relative to `p0`, is in the ball `s` if `|x - s e|² - (r0 - s ρ)²` is not positive.
//! That is `h - 2 s y + s² d2` with `h = x·x - r0²`. It is smallest at `s = y / d2`. So the point
//! is in the solid if, for `y` below 0, `h` is not positive; for `y` above `d2`, `h - 2 y + d2` is
//! not; and in between, `h d2 - y²` is not.

use glam::{DVec3, Vec3};

use super::ball::chord;
use super::{End, ExactInterval, Filtered, Interval, ROUNDING, Solid, filtered, unbounded};
use crate::double_double::{DoubleDouble, Real};
use crate::filter::CANCELLATION;
#[cfg(not(feature = "std"))]
use crate::libm_functions::Functions as _;
use crate::{Hit, Ray, RoundedCone, widen};

impl Solid for RoundedCone {
    #[inline]
    fn interval(&self, ray: &Ray) -> Option<Interval> {
        filtered(filter(self, ray), || self.interval_exactly(ray))
    }

    #[cold]
    #[inline(never)]
    fn interval_exactly(&self, ray: &Ray) -> Option<ExactInterval> {
        if let Some((ball, _)) = self.one_ball() {
            return ball.interval_exactly(ray);
        }
        let [entry, exit] = self.roots_in_double_double(ray)?;
        // If the cone is too long for 106 bits, the exit may come out before the entry.
        (entry <= exit).then_some(ExactInterval { entry, exit })
    }

    #[inline]
    fn crossing(&self, ray: &Ray, end: End) -> Option<Hit> {
        match end {
            End::Entry => self.closest(&unbounded(ray)),
            End::Exit => self.exit(&unbounded(ray)),
        }
    }

    #[inline]
    fn contains(&self, point: Vec3) -> bool {
        let ((p0, r0), (p1, r1)) = (widen::ball(self.p0, self.r0), widen::ball(self.p1, self.r1));
        match contains(point.as_dvec3() - p0, p1 - p0, r0, r0 - r1) {
            Some(inside) if r0.min(r1) >= 0.0 => inside,
            Some(_) => false,
            None => self.contains_exactly(point),
        }
    }
}

/// Decides in `f64` whether the point `x` is in the solid; `None` if the digits do not suffice.
#[inline(always)]
fn contains(x: DVec3, e: DVec3, r0: f64, rho: f64) -> Option<bool> {
    let (xx, ee) = (x.dot(x), e.dot(e));
    let d2 = ee - rho * rho;
    let (y, y_terms) = (x.dot(e) - r0 * rho, (xx * ee).sqrt() + r0 * rho.abs());
    let (h, h_terms) = (xx - r0 * r0, xx + r0 * r0);
    let d2_terms = ee + rho * rho;
    let certain = |value: f64, terms: f64| value.abs() > ROUNDING * terms;
    if !(certain(d2, d2_terms) && d2 > 0.0 && certain(y, y_terms)) {
        return None;
    }
    let (value, terms) = if y < 0.0 {
        (h, h_terms)
    } else if !certain(y - d2, y_terms + d2_terms) {
        return None;
    } else if y > d2 {
        (h - 2.0 * y + d2, h_terms + 2.0 * y_terms + d2_terms)
    } else {
        (h * d2 - y * y, h_terms * d2_terms + 2.0 * y * y_terms)
    };
    // A NaN is not certain.
    certain(value, terms).then_some(value < 0.0)
}

/// Computes the interval in `f64`, with bounds on the error of each term.
#[inline(always)]
fn filter(cone: &RoundedCone, ray: &Ray) -> Filtered {
    let ((p0, r0), (p1, r1)) = (widen::ball(cone.p0, cone.r0), widen::ball(cone.p1, cone.r1));
    let (o, d) = widen::ray(ray);
    let (e, f) = (p1 - p0, o - p0);
    let rho = r0 - r1;
    let (ee, a, ff) = (e.dot(e), d.dot(d), f.dot(f));
    let d2 = ee - rho * rho;
    let (w, g) = (f.cross(d), d.cross(e));
    let moment = r0 * g + rho * w;
    let volume = f.dot(g);
    let moment2 = moment.dot(moment);
    let discriminant = moment2 - volume * volume;
    // The lengths |f| |d|, |d| |e| and |f| |d| |e|, of which errors are shares.
    let (fd, de) = ((ff * a).sqrt(), (a * ee).sqrt());
    let fde = fd * ee.sqrt();
    let terms = moment2 + moment2.sqrt() * (r0 * de + rho.abs() * fd + fde);
    let thinnest = r0.min(r1);
    // Written so that a NaN is uncertain.
    if !(d2 > CANCELLATION * ee
        && thinnest > 0.0
        && discriminant.abs() > CANCELLATION * moment2 + 16.0 * ROUNDING * terms)
    {
        return Filtered::Uncertain;
    }
    if discriminant < 0.0 {
        return Filtered::Miss;
    }
    let (b, m) = (f.dot(d), d.dot(e));
    let width = a * d2;
    let (gg, ww) = (g.dot(g), w.dot(w));
    let k2 = gg - rho * rho * a;
    let k2_error = ROUNDING * (gg.sqrt() * de + rho * rho * a);
    let certain = k2.abs() > 1024.0 * k2_error;
    if !certain {
        return Filtered::Uncertain;
    }
    let square = r0 * r0 * a;
    let (y0, y0_error) = (-w.dot(g) - r0 * rho * a, ROUNDING * (fd * de + r0 * rho.abs() * a));
    let k1 = -m * y0;
    let k0 = -(width * (square - ww)) - y0 * y0;
    let k0_error = ROUNDING * (width * (square + ww.sqrt() * fd)) + 2.0 * y0.abs() * y0_error;
    let spread = a * (d2 * discriminant).sqrt();
    // Both terms of q have the sign of -k1, so their sum does not cancel; the other root is k0 / q.
    let q = -k1 - spread.copysign(k1);
    let q_error = m.abs() * y0_error + ROUNDING * (spread + spread * terms / discriminant);
    let first = q / k2;
    let first_error = (q_error + first.abs() * k2_error) / k2.abs();
    let second = k0 / q;
    let second_error = (k0_error + second.abs() * q_error) / q.abs();
    // Entry, then exit.
    let (thetas, errors) = if k1.is_sign_positive() {
        ([first, second], [first_error, second_error])
    } else {
        ([second, first], [second_error, first_error])
    };
    let (mut ends, mut end_errors) = ([0.0; 2], [0.0; 2]);
    // Both ends are often in the same cap.
    let mut caps = [None; 2];
    for (end, (theta, theta_error)) in thetas.into_iter().zip(errors).enumerate() {
        let is_entry = end == 0;
        // The line is inside the cone from or to infinity.
        let endless = k2 < 0.0 && is_entry == (m * rho >= 0.0);
        let y = match endless {
            false => y0 + m * theta,
            true if is_entry == (m >= 0.0) => f64::NEG_INFINITY,
            true => f64::INFINITY,
        };
        if y.is_nan() {
            return Filtered::Uncertain;
        }
        if y >= 0.0 && y <= width {
            ends[end] = (theta - b) / a;
            end_errors[end] = (theta_error + ROUNDING * fd) / a;
        } else {
            let cap = usize::from(y > width);
            let interval = match caps[cap] {
                Some(interval) => interval,
                None => match chord(if cap == 0 { f } else { f - e }, [r0, r1][cap], d) {
                    Filtered::Found(interval) => interval,
                    other => return other,
                },
            };
            caps[cap] = Some(interval);
            ends[end] = [interval.entry, interval.exit][end];
            end_errors[end] = interval.error;
        }
    }
    // The sum bounds both, and is NaN if one is.
    let error = end_errors[0] + end_errors[1];
    Filtered::Found(Interval { entry: ends[0], exit: ends[1], error })
}

impl RoundedCone {
    #[cold]
    #[inline(never)]
    fn contains_exactly(&self, point: Vec3) -> bool {
        if let Some((ball, _)) = self.one_ball() {
            return ball.contains(point);
        }
        let valid = self.r0.min(self.r1) >= 0.0 && self.r0.max(self.r1) > 0.0;
        if !(valid && point.is_finite() && self.p0.is_finite() && self.p1.is_finite()) {
            return false;
        }
        let exact = |p: Vec3| p.to_array().map(DoubleDouble::exact);
        let sub = |a: [DoubleDouble; 3], b: [DoubleDouble; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
        let dot =
            |a: [DoubleDouble; 3], b: [DoubleDouble; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let p0 = exact(self.p0);
        let (x, e) = (sub(exact(point), p0), sub(exact(self.p1), p0));
        let (r0, r1) = (DoubleDouble::exact(self.r0), DoubleDouble::exact(self.r1));
        let rho = r0 - r1;
        let d2 = dot(e, e) - rho * rho;
        let y = dot(x, e) - r0 * rho;
        let h = dot(x, x) - r0 * r0;
        let value = if y < DoubleDouble::ZERO {
            h
        } else if y > d2 {
            h - y - y + d2
        } else {
            h * d2 - y * y
        };
        value <= DoubleDouble::ZERO
    }
}
