//! Scene files of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// Of a scene that asks for nothing large: textures and elements that a generator makes of a few words.
const RATIO: usize = 1 << 12;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("scene", bytes, RATIO));
