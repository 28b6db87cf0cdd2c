//! Scene files of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// Of a scene without generators: its own lists, and four levels of subdivision of one quad.
const RATIO: usize = 1 << 12;
/// A cube of 99 steps, subdivided twice: a million quads of a few words.
const GENERATED: usize = 1 << 28;

fuzz_target!(|bytes: &[u8]| {
    let generates = bytes.windows(9).any(|word| word == b"generator");
    rotund_fuzz::survives("scene", bytes, RATIO, if generates { GENERATED } else { 0 });
});
