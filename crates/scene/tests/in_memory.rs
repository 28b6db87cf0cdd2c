//! Scenes load from memory as they do from files.

#![cfg(feature = "load")]

use rotund_scene::{LoadOptions, LoadProblem, load, load_bytes};
use std::{borrow::Cow, fs, path::Path};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");

#[test]
fn scenes_load_from_memory_as_from_files() {
    // A scene with PLY shapes, one of generators alone, and a single PLY file.
    let names = ["patches.json", "shapes4.json"];
    let lone = fs::read_dir(format!("{SCENES}/patches")).expect("its shapes").flatten().next();
    let lone = lone.expect("at least one").file_name();
    let names = names.map(str::to_owned).into_iter();
    for name in names.chain([format!("patches/{}", lone.to_string_lossy())]) {
        let path = Path::new(SCENES).join(&name);
        let from_disk = load(&path, &LoadOptions::default()).expect("a good scene");
        let bytes = fs::read(&path).expect("just loaded");
        let files = |path: &str| fs::read(Path::new(SCENES).join(path)).ok().map(Cow::Owned);
        let from_memory = load_bytes(&name, &bytes, &files, &LoadOptions::default());
        let from_memory = from_memory.expect("the same scene");
        assert!(from_disk.scene == from_memory.scene, "{name}");
        let files: Vec<_> = from_memory.files.iter().map(|f| Path::new(SCENES).join(f)).collect();
        assert_eq!(from_disk.files, files, "{name}");
    }
}

#[test]
fn paths_are_relative_to_the_folder_of_the_scene() {
    let json = br#"{ "shapes": [{ "uri": "shapes/a.ply" }, { "name": "b" }],
        "instances": [{ "shape": "c", "material": 0 }], "materials": [{}] }"#;
    let ply: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n\
        property float y\nproperty float z\nend_header\n1 2 3\n";
    let obj: &[u8] = b"v 0 0 0\nv 1 0 0\nl 1 2\n";
    let files = |path: &str| match path {
        "folder/shapes/a.ply" => Some(Cow::Borrowed(ply)),
        "folder/shapes/c.obj" => Some(Cow::Borrowed(obj)),
        _ => None,
    };
    let error = load_bytes("folder/x.json", json, &files, &LoadOptions::default());
    let error = error.expect_err("b has no file").to_string();
    assert!(error.starts_with("folder/x.json: shapes[1].uri is missing"), "{error}");
    let json = String::from_utf8_lossy(json).replace(r#", { "name": "b" }"#, "");
    let loaded = load_bytes("folder/x.json", json.as_bytes(), &files, &LoadOptions::default());
    let loaded = loaded.expect("all there");
    assert_eq!(loaded.scene.shapes[0].positions[0].to_array(), [1.0, 2.0, 3.0]);
    assert_eq!(loaded.scene.instances[0].shape, 1, "found by its name in a folder");
}

#[test]
fn missing_files_are_reported() {
    let load = |name: &str, json: &str| {
        load_bytes(name, json.as_bytes(), &|_| None, &LoadOptions::default()).expect_err(json)
    };
    let error = load("s.json", r#"{ "shapes": [{ "uri": "no.ply" }] }"#);
    assert!(matches!(*error.problem, LoadProblem::Read { .. }), "{error}");
    let text = "no.ply (named by shapes[0].uri of s.json): cannot be read: \
        not among the files in memory";
    assert_eq!(error.to_string(), text);
    let error = load("s.json", r#"{ "textures": [{ "uri": "../secret.png" }] }"#);
    assert!(matches!(*error.problem, LoadProblem::OutsideFolder { .. }), "{error}");
    let error = load("s.usd", "{}");
    assert!(matches!(*error.problem, LoadProblem::Unsupported { .. }), "{error}");
}

#[test]
fn generators_that_overflow_are_refused() {
    let json = r#"{ "shapes": [{ "generator":
        { "rectangle": { "size": [3e38, 1], "texture_scale": 1e39 } } }] }"#;
    let error = load_bytes("s.json", json.as_bytes(), &|_| None, &LoadOptions::default());
    let error = error.expect_err("texture coordinates beyond f32").to_string();
    assert!(error.contains("s.json: ") && error.contains("shapes[0]"), "{error}");
}
