//! Completion of an axis to an orthonormal basis.

use glam::DVec3;

/// Completes the unit vector `n` to a right-handed orthonormal basis `(x, y, n)`, and returns
/// `x, y`.
///
/// They vary smoothly with `n` except where `n.z` changes sign. The computation has no branch and
/// no normalization; its error is a few units in the last place.
///
/// Source: T. Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
pub(crate) fn across(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        DVec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}
