//! How unlikely a difference is, if nothing but chance made it.

use crate::moments::Moments;
use statrs::function::{beta::checked_beta_reg, erf::erfc_inv};

/// How often a run over a whole set of pictures in which nothing changed fails all the same: once in
/// a thousand runs. It is shared out evenly between the kinds of tests, and in each kind between all
/// tests of all pictures (C. Bonferroni, "Teoria statistica delle classi e calcolo delle
/// probabilità", 1936), so it is an upper bound, whatever the tests have to do with each other.
pub const FALSE_ALARMS: f64 = 1e-3;

/// Kinds of tests that have a false alarm rate.
const KINDS: f64 = 3.0;

/// The largest p-value that fails, for one of `tests` tests of one kind.
pub fn level(tests: usize) -> f64 {
    FALSE_ALARMS / KINDS / tests.max(1) as f64
}

/// The probability that Student's t with `freedom` degrees of freedom is at least this far from 0,
/// to either side. Accurate far into the tails, for it is no difference from 1.
pub fn p_value(t: f64, freedom: f64) -> f64 {
    if t.is_infinite() {
        return 0.0;
    }
    checked_beta_reg(0.5 * freedom, 0.5, freedom / (freedom + t * t)).unwrap_or(1.0)
}

/// How far a normal variable is from 0, to either side, with this probability.
pub fn normal_quantile(p: f64) -> f64 {
    std::f64::consts::SQRT_2 * erfc_inv(p)
}

/// The difference of the means of two pictures over some pixels, in one channel.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    /// Mean of the second picture.
    pub expected: f64,
    /// Mean of the first minus that of the second.
    pub difference: f64,
    /// Standard error of the difference.
    pub error: f64,
    /// Student's t; infinite if the difference has no error but is one.
    pub t: f64,
    /// Degrees of freedom, at least.
    pub freedom: f64,
}

/// Numbers may differ by this much, relatively, without being different: what is lost in half
/// precision. Another instruction set, or a sum in another order, moves them by far less; an error
/// of a tenth of a percent is four times as much.
const ROUNDING: f64 = 1.0 / 4096.0;

/// Compares `actual` with `reference` on the pixels with these indices.
///
/// Pixels are independent, so variances add. The variance of a replica is the larger of the two
/// pictures': a picture that happened to miss what is rare is not taken for a quiet one, and a
/// noisier sampler is not taken for an error. Degrees of freedom follow F. Satterthwaite, "An
/// approximate distribution of estimates of variance components", Biometrics Bulletin 2(6), 1946.
pub fn compare(
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
    // Not a number if it is 0 / 0, where there is nothing to tell apart.
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
