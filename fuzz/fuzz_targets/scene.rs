//! Scene files of any bytes: `cargo +nightly fuzz run scene -- -rss_limit_mb=2048`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rotund_scene::{LoadOptions, load};

fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("scene.json");
    std::fs::write(&scene, bytes).expect("writes the scene");
    let _ = load(&scene, &LoadOptions::default());
});
