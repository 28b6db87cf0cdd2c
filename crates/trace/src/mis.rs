//! Combining samplers of the same integrand.

/// Weight of a sample drawn with density `pdf` when another sampler would have drawn it with
/// density `other`: the power heuristic with exponent 2. Infinite densities are allowed.
///
/// Source: E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo
/// Rendering", SIGGRAPH 1995.
#[must_use]
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // The ratio neither overflows nor divides zero by zero where pdf is positive.
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
