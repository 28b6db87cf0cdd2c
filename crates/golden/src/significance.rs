//! The probability of a difference under the hypothesis that noise alone causes it.

use crate::moments::Moments;
use statrs::function::{beta::checked_beta_reg, erf::erfc_inv};

/// Upper bound on the false-alarm rate: the probability that a run over a whole set of pictures
/// fails although nothing changed.
///
/// The rate is divided evenly among the three kinds of t-tests (pixels, blocks, whole pictures),
/// and within a kind among all tests of all pictures (C. Bonferroni, "Teoria statistica delle
/// classi e calcolo delle probabilità", 1936). The bound holds however the tests depend on each
/// other.
pub const FALSE_ALARMS: f64 = 1e-3;

/// Number of kinds of t-tests.
const KINDS: f64 = 3.0;

/// Returns the largest p-value that fails, for one of `tests` tests of one kind.
pub(crate) fn level(tests: usize) -> f64 {
    FALSE_ALARMS / KINDS / tests.max(1) as f64
}

/// Returns the probability that the absolute value of Student's t with `freedom` degrees of freedom
/// is at least `|t|`. It is accurate far into the tails, because it is not computed as a difference
/// from 1.
pub(crate) fn p_value(t: f64, freedom: f64) -> f64 {
    if t.is_infinite() {
        return 0.0;
    }
    checked_beta_reg(0.5 * freedom, 0.5, freedom / (freedom + t * t)).unwrap_or(1.0)
}

/// Returns the absolute value that a standard normal variable exceeds with probability `p`.
pub(crate) fn normal_quantile(p: f64) -> f64 {
    std::f64::consts::SQRT_2 * erfc_inv(p)
}

/// The difference of the means of two pictures over some pixels, in one channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Comparison {
    /// Mean of the second picture.
    pub(crate) expected: f64,
    /// Mean of the first minus that of the second.
    pub(crate) difference: f64,
    /// Standard error of the difference.
    pub(crate) error: f64,
    /// Student's t; infinite for a difference without a standard error.
    pub(crate) t: f64,
    /// Lower bound on the degrees of freedom.
    pub(crate) freedom: f64,
}

/// Relative difference that counts as none: the rounding error of half precision. Another
/// instruction set or order of summation moves values by far less, and an error of a tenth of a
/// percent is four times as much.
const ROUNDING: f64 = 1.0 / 4096.0;

/// Compares `actual` with `reference` on the pixels with these indices.
///
/// Pixels are independent, so variances add. The variance of a replica is the larger one of the two
/// pictures, so that a picture that happened to miss rare bright paths does not seem quiet, and a
/// noisier sampler does not seem wrong. Degrees of freedom follow F. Satterthwaite, "An approximate
/// distribution of estimates of variance components", Biometrics Bulletin 2(6), 1946.
pub(crate) fn compare(
    actual: &Moments,
    reference: &Moments,
    pixels: impl Iterator<Item = usize>,
    channel: usize,
) -> Comparison {
    let [ours, theirs] = [actual, reference].map(|moments| f64::from(moments.replicas));
    let (mut count, mut expected, mut difference) = (0.0, 0.0, 0.0);
    let (mut variance, mut squares) = (0.0, 0.0);
    for i in pixels {
        count += 1.0;
        expected += reference.mean[i][channel];
        difference += actual.mean[i][channel] - reference.mean[i][channel];
        let spread = actual.variance[i][channel].max(reference.variance[i][channel]);
        let term = spread / ours + reference.variance[i][channel] / theirs;
        variance += term;
        squares += term * term;
    }
    let (expected, difference) = (expected / count, difference / count);
    let error = variance.sqrt() / count;
    let beyond_rounding = (difference.abs() - ROUNDING * expected.abs()).max(0.0);
    // Avoids 0 / 0 where neither a difference nor an error exists.
    let t = if beyond_rounding > 0.0 { beyond_rounding / error } else { 0.0 };
    let terms = if squares > 0.0 { variance * variance / squares } else { 1.0 };
    Comparison { expected, difference, error, t, freedom: (ours - 1.0).max(1.0) * terms }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_values_agree_with_tables() {
        // Two-sided quantiles of Student's t: NIST/SEMATECH e-Handbook, section 1.3.6.7.2; the last
        // from P = 1 - (1 / pi) 2 atan t for one degree of freedom.
        let table = [
            (12.706, 1.0, 0.05),
            (2.228, 10.0, 0.05),
            (3.169, 10.0, 0.01),
            (3.385, 30.0, 0.002),
            (1e6, 1.0, 2e-6 / std::f64::consts::PI),
        ];
        for (t, freedom, p) in table {
            let found = p_value(t, freedom);
            assert!((found / p - 1.0).abs() < 2e-3, "t {t}, {freedom}: {found} is not {p}");
        }
        assert!((normal_quantile(0.05) - 1.959_964).abs() < 1e-5);
    }

    #[test]
    fn far_tails_do_not_drown_in_rounding() {
        // With many degrees of freedom t is normal: erfc(8 / sqrt 2) = 1.244e-15.
        let p = p_value(8.0, 1e7);
        assert!((p / 1.244e-15 - 1.0).abs() < 0.01, "{p}");
        assert_eq!(p_value(f64::INFINITY, 31.0), 0.0);
        assert_eq!(p_value(0.0, 31.0), 1.0);
    }
}
