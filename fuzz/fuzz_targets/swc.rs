//! Loads arbitrary bytes as an SWC file.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// A row takes fourteen bytes: a node as read, as linked and as drawn with up to two vertices, each
/// in an array that grows, and an entry of the table of ids.
const RATIO: usize = 64;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("swc", bytes, RATIO, 0));
