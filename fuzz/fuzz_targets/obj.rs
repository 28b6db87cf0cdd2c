//! Loads arbitrary bytes as an OBJ file.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// The densest files are polygons with two characters for each corner.
const RATIO: usize = 128;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("obj", bytes, RATIO, 0));
