//! The numbers of the oracle against exact integers.

mod support;

use support::{Random, Wide};

/// Converts an integer of up to 100 bits, exactly.
fn from_integer(n: i128) -> Wide {
    let high = n as f64;
    Wide::from(high) + Wide::from((n - high as i128) as f64)
}

/// Converts a number that is an integer of up to 106 bits, exactly.
fn to_integer(w: Wide) -> i128 {
    let high = w.to_f64();
    high as i128 + (w - high.into()).to_f64() as i128
}

fn random_integer(random: &mut Random, bits: u32) -> i128 {
    let n = i128::from(random.bits()) << 40 ^ i128::from(random.bits());
    (n >> (104 - bits)) * if random.bits() & 1 == 0 { 1 } else { -1 }
}

#[test]
fn sums_and_products_of_integers_are_exact() {
    let mut random = Random(1);
    for _ in 0..100_000 {
        let (a, b) = (random_integer(&mut random, 100), random_integer(&mut random, 100));
        assert_eq!(to_integer(from_integer(a) + from_integer(b)), a + b, "{a} + {b}");
        assert_eq!(to_integer(from_integer(a) - from_integer(b)), a - b, "{a} - {b}");
        let (a, b) = (a >> 50, b >> 50);
        assert_eq!(to_integer(from_integer(a) * from_integer(b)), a * b, "{a} * {b}");
    }
}

#[test]
fn quotients_and_roots_invert_products_to_104_bits() {
    let mut random = Random(2);
    for _ in 0..100_000 {
        let a = from_integer(random_integer(&mut random, 100));
        let b = from_integer(random_integer(&mut random, 100) | 1);
        let back = (a / b) * b;
        assert!((back - a).abs().to_f64() <= a.abs().to_f64() * 2f64.powi(-102), "{a:?} {b:?}");
        let root = a.abs().sqrt();
        let off = (root * root - a.abs()).abs().to_f64();
        assert!(off <= a.abs().to_f64() * 2f64.powi(-101), "{a:?}");
    }
}

#[test]
fn a_difference_that_f64_loses_is_kept() {
    let (a, tiny) = (Wide::from(1.0), Wide::from(2f64.powi(-90)));
    assert_eq!(((a + tiny) - a).to_f64(), 2f64.powi(-90));
    assert_eq!(((a + tiny) * (a - tiny) - a).to_f64(), 0.0, "2^-180 is beyond 106 bits");
}
