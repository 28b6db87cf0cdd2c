//! Loads arbitrary bytes as an MTL file, the materials of a mesh.

#![no_main]

use libfuzzer_sys::fuzz_target;

/// A material takes nine bytes: a name, in a table too, a colour and the name of an image.
const RATIO: usize = 64;

fuzz_target!(|bytes: &[u8]| rotund_fuzz::survives("mtl", bytes, RATIO, 0));
