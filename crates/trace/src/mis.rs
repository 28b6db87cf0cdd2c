//! Multiple importance sampling.

/// Returns the weight of a sample of density `pdf` whose density by the other technique is `other`:
/// the power heuristic with exponent 2, for one sample of each technique. Either density may be
/// infinite; `pdf` must be positive.
///
/// Source: E. Veach, L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo
/// Rendering", SIGGRAPH 1995.
#[must_use]
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // The ratio of densities avoids the overflow of their squares, and 0 / 0 for a positive pdf.
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
