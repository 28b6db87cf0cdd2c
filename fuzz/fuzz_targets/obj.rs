//! OBJ files of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// The tightest are polygons whose corners take two characters each.
const RATIO: usize = 128;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("obj", bytes, RATIO, 0));
