//! Loads arbitrary bytes as a scene file.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// Scenes without generators: their lists, and four levels of subdivision of one quad.
const RATIO: usize = 1 << 12;
/// A cube of 99 steps, subdivided twice, has a million quads.
const GENERATED: usize = 1 << 28;

fuzz_target!(|bytes: &[u8]| {
    let generates = bytes.windows(9).any(|word| word == b"generator");
    rotund_fuzz::survives("scene", bytes, RATIO, if generates { GENERATED } else { 0 });
});
