//! Loads arbitrary bytes as an image.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// The highest ratio of compression, times twelve: once for the channels of the file as bytes or
/// floats, once for four channels.
const RATIO: usize = 1400 * 12;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("texture", bytes, RATIO, 0));
