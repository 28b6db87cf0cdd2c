//! Coordinates far from the origin, as georeferenced files have them: an offset is subtracted in
//! double precision before they become single, so that neighbours keep their distance.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Coordinates of smaller absolute value are single at once: they are multiples of half a
/// millimeter or less.
pub(super) const FAR: f64 = 4096.0;

/// Converts positions to single precision, relative to the offset that is returned.
pub(super) fn to_single(positions: &[DVec3]) -> (Vec<Vec3>, DVec3) {
    let offset =
        if positions.iter().any(is_far) { offset(positions.iter().copied()) } else { DVec3::ZERO };
    (positions.iter().map(|position| (position - offset).as_vec3()).collect(), offset)
}

fn is_far(position: &DVec3) -> bool {
    position.abs().max_element() >= FAR
}

/// Subtracts an offset, which is returned, from positions whose double is the sum of `positions`
/// and `rests`.
pub(super) fn move_near(positions: &mut [Vec3], rests: &[Vec3]) -> DVec3 {
    let whole = |(position, rest): (&Vec3, &Vec3)| position.as_dvec3() + rest.as_dvec3();
    let offset = offset(positions.iter().zip(rests).map(whole));
    if offset != DVec3::ZERO {
        positions.par_iter_mut().zip(rests).for_each(|(position, rest)| {
            *position = (whole((position, rest)) - offset).as_vec3();
        });
    }
    offset
}

/// Returns what to subtract: on each axis the median, rounded, or 0 where that gains nothing.
///
/// Points that are not finite, or at the origin as scanners write missing ones, do not count, nor
/// do few outliers. The components are sums of few powers of two, so that they are exact in single
/// precision, and so are their sums with other translations.
fn offset(positions: impl ExactSizeIterator<Item = DVec3>) -> DVec3 {
    const SAMPLE: usize = 1 << 12;
    let step = (positions.len() / SAMPLE).max(1);
    let mut sample: Vec<DVec3> = positions.step_by(step).collect();
    sample.retain(|position| position.is_finite() && *position != DVec3::ZERO);
    DVec3::from_array([0, 1, 2].map(|axis| {
        let mut values: Vec<f64> = sample.iter().map(|position| position[axis]).collect();
        values.sort_unstable_by(f64::total_cmp);
        let at = |part: usize| values.get((values.len() * part) / 20).copied().unwrap_or(0.0);
        let (median, spread) = (at(10), at(18) - at(2));
        if median.abs() < FAR || median.abs() < 2.0 * spread || median.abs() > 1e15 {
            return 0.0;
        }
        // A single has 24 bits; the steps leave four of them to sums.
        let step = median.abs().log2().floor().exp2() / f64::from(1 << 19);
        (median / step).round() * step
    }))
}
