//! Loads arbitrary bytes as a PLY file.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// The densest files are polygons of many corners of one byte each: a triangle of twelve bytes for
/// each corner, and twice as much again while an array grows or is converted to quads.
const RATIO: usize = 64;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("ply", bytes, RATIO, 0));
