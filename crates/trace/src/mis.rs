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

/// Returns the weight of a path that light samples find `sampled` times as densely as the BSDF, and
/// light paths `light` times as densely, if it was found by the BSDF.
pub(crate) fn weight_of_bsdf(sampled: f32, light: f32) -> f32 {
    1.0 / (1.0 + sampled * sampled + light * light)
}

/// Returns the weight of the same path if it was found by a light sample.
pub(crate) fn weight_of_light_sample(sampled: f32, light: f32) -> f32 {
    let rest = 1.0 / sampled;
    1.0 / (1.0 + rest * rest * (1.0 + light * light))
}

/// Returns the weight of the same path if it was found by a light path.
pub(crate) fn weight_of_light_path(light: f32, sampled: f32) -> f32 {
    let rest = 1.0 / light;
    1.0 / (1.0 + rest * rest * (1.0 + sampled * sampled))
}
