//! Images of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// What the tightest compression may unfold to, twelve-fold: once as bytes or floats of the file's
/// own channels, once as four channels.
const RATIO: usize = 1400 * 12;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("texture", bytes, RATIO, 0));
