//! Images of any bytes: the first chooses the format. `cargo +nightly fuzz run texture`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rotund_scene::{LoadOptions, load};

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let name = ["image.png", "image.jpg", "image.hdr", "image.exr"][usize::from(first % 4)];
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join(name), bytes).expect("writes the image");
    let scene = folder.path().join("scene.json");
    let text = format!(r#"{{ "textures": [{{ "uri": "{name}" }}] }}"#);
    std::fs::write(&scene, text).expect("writes the scene");
    let _ = load(&scene, &LoadOptions::default());
});
