//! Loads arbitrary bytes as a PLY file.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// The densest files are triangles of seven bytes with colours of their own: in the end each has
/// three vertices of its own, with an entry of the table of copies for each, while arrays grow.
const RATIO: usize = 256;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("ply", bytes, RATIO, 0));
