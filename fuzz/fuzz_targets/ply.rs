//! PLY files of any bytes: `cargo +nightly fuzz run ply -- -rss_limit_mb=1024`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rotund_scene::{LoadOptions, load};

fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("shape.ply"), bytes).expect("writes the shape");
    let scene = folder.path().join("scene.json");
    std::fs::write(&scene, r#"{ "shapes": [{ "uri": "shape.ply" }] }"#).expect("writes the scene");
    let _ = load(&scene, &LoadOptions::default());
});
