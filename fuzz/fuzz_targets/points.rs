//! Loads arbitrary bytes as points in a text.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// A row of six characters is a position in double and in single precision, a colour and a radius,
/// in arrays that grow.
const RATIO: usize = 64;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("points", bytes, RATIO, 0));
