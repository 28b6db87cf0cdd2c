//! PLY files of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// The tightest are polygons of many corners in bytes: twelve bytes of a triangle for each corner,
/// and as much again twice while an array grows or is promoted to quads.
const RATIO: usize = 64;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("ply", bytes, RATIO, 0));
