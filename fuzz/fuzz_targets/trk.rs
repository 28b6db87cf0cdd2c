//! Loads arbitrary bytes as a TRK file.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// A point of twelve bytes is a position, a colour, a radius and a line, in arrays that grow.
const RATIO: usize = 16;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("trk", bytes, RATIO, 0));
