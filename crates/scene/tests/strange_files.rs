//! Unusual files of editors and converters: what loads, and the messages for what does not.

#![cfg(feature = "load")]

use rotund_scene::{Elements, LoadOptions, Loaded, load};
use std::{fs, time::Instant};

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const SCENE: &str = r#"{ "materials": [{}], "shapes": [{ "uri": "quad.obj" }],
    "instances": [{ "shape": 0, "material": 0 }] }"#;

/// Loads `name` with this content, in a folder with a quad.
fn loaded(name: &str, content: &[u8]) -> Result<Loaded, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("quad.obj"), QUAD).expect("writes the mesh");
    fs::write(folder.path().join(name), content).expect("writes the file");
    load(folder.path().join(name), &LoadOptions::default()).map_err(|error| error.to_string())
}

fn utf16(text: &str) -> Vec<u8> {
    let units = std::iter::once(0xfeff).chain(text.encode_utf16());
    units.flat_map(u16::to_le_bytes).collect()
}

#[test]
fn byte_order_marks_and_all_line_ends_are_accepted() {
    let table = [
        ("a mark before UTF-8", "scene.json", format!("\u{feff}{SCENE}")),
        ("line ends of two bytes", "scene.json", SCENE.replace(' ', "\r\n")),
        ("no extension", "scene", SCENE.to_owned()),
        ("a mark before an OBJ", "thing.obj", format!("\u{feff}{QUAD}")),
        ("an OBJ with line ends of two bytes", "thing.obj", QUAD.replace('\n', "\r\n")),
        ("an element on two lines", "thing.obj", QUAD.replace(" 3 4", " \\\n3 4")),
        ("a last line that is said to go on", "thing.obj", QUAD.replace("4\n", "4 \\")),
        ("the same with other line ends", "thing.obj", QUAD.replace(" 3 4", " \\\r\n3 4")),
        ("an OBJ of an old Mac", "thing.obj", QUAD.replace('\n', "\r")),
        ("a scene of an old Mac", "scene.json", SCENE.replace('\n', "\r")),
    ];
    for (why, name, content) in table {
        let loaded = loaded(name, content.as_bytes()).unwrap_or_else(|e| panic!("{why}: {e}"));
        let quad = Elements::Quads(vec![[0, 1, 2, 3]]);
        assert!(loaded.scene.shapes.iter().any(|s| s.elements == quad), "{why}");
        assert_eq!(loaded.warnings, Vec::<String>::new(), "{why}");
    }
}

#[test]
fn messages_for_files_that_are_no_scenes_are_plain() {
    let materials = |what: &str| format!("{{ \"materials\": {what} }}").into_bytes();
    let table: [(&str, &str, Vec<u8>, &[&str]); 15] = [
        ("UTF-16", "scene.json", utf16(SCENE), &["UTF-16", "UTF-8"]),
        ("an OBJ in UTF-16", "thing.obj", utf16(QUAD), &["UTF-16", "UTF-8"]),
        (
            "another format",
            "movie.gltf",
            b"{}".to_vec(),
            &["\"gltf\"", "json, ply, obj, swc, tck, trk, xyz"],
        ),
        (
            "a PLY by another name",
            "mesh",
            b"ply\nformat".to_vec(),
            &["\"\"", "json, ply, obj, swc, tck, trk, xyz"],
        ),
        ("null", "scene.json", b"null".to_vec(), &["null", "expected an object"]),
        ("an array", "scene.json", b"[]".to_vec(), &["sequence", "expected an object"]),
        ("an item in brackets", "scene.json", materials("[[]]"), &["materials[0]", "an object"]),
        ("an item that is none", "scene.json", materials("[3]"), &["materials[0]", "an object"]),
        ("a word for a number", "scene.json", materials(r#"[{"ior": "x"}]"#), &["ior", "a number"]),
        (
            "a number for a type",
            "scene.json",
            materials(r#"[{"type": 7}]"#),
            &["type", "another kind"],
        ),
        (
            "a colour of four",
            "scene.json",
            materials(r#"[{"color": [1, 1, 1, 1]}]"#),
            &["color", "too many"],
        ),
        (
            "half a level",
            "scene.json",
            br#"{ "subdivs": [{ "subdivisions": 1.5 }] }"#.to_vec(),
            &["subdivs[0].subdivisions", "1.5", "an integer from 0"],
        ),
        (
            "a frame of three numbers",
            "scene.json",
            br#"{ "instances": [{ "frame": [1, 2, 3] }] }"#.to_vec(),
            &["instances[0].frame", "expected a frame", "12 numbers"],
        ),
        (
            "a version of the time before the format",
            "scene.json",
            br#"{ "asset": { "version": "3.1" } }"#.to_vec(),
            &["asset.version", "3.1", "version 4.0 or later"],
        ),
        (
            "shapes as they were before it",
            "scene.json",
            br#"{ "shapes": [{ "name": "a", "filename": "models/a.ply" }] }"#.to_vec(),
            &["shapes[].filename", "version 4.0 or later"],
        ),
    ];
    for (why, name, content, parts) in table {
        let message = loaded(name, &content).expect_err(why);
        for part in parts.iter().chain([&name]) {
            assert!(message.contains(part), "{why}: {part:?} is not in {message:?}");
        }
    }
}

#[test]
fn deep_nesting_neither_overflows_the_stack_nor_takes_long() {
    let start = Instant::now();
    let deep = |open: &str, close: &str| {
        format!("{}1{}", open.repeat(200_000), close.repeat(200_000)).into_bytes()
    };
    for (why, content) in [
        ("where nothing is known", [b"{ \"weather\": ".to_vec(), deep("[", "]"), b"}".to_vec()]),
        ("of objects", [b"{ \"weather\": ".to_vec(), deep("{\"a\":", "}"), b"}".to_vec()]),
        ("in a known field", [b"{ \"asset\": ".to_vec(), deep("[", "]"), b"}".to_vec()]),
        ("in an item", [b"{ \"materials\": [".to_vec(), deep("[", "]"), b"]}".to_vec()]),
    ] {
        // Either a warning or an error.
        let _ = loaded("scene.json", &content.concat()).map_err(|message| {
            assert!(message.contains("scene.json"), "{why}: {message}");
        });
    }
    assert!(start.elapsed().as_secs() < 10, "took {:?}", start.elapsed());
}

#[test]
fn a_subdivision_beyond_memory_is_refused_at_once() {
    let scene = |levels: u32| {
        format!(
            r#"{{ "shapes": [{{}}], "subdivs": [{{ "shape": 0, "uri": "quad.obj",
                "subdivisions": {levels} }}] }}"#
        )
    };
    let start = Instant::now();
    for levels in [12, 13, 31, 32, u32::MAX] {
        let message = loaded("scene.json", scene(levels).as_bytes()).expect_err("too many");
        let value = levels.to_string();
        for part in ["subdivs[0].subdivisions", &value, "8388608 quads"] {
            assert!(message.contains(part), "{part:?} is not in {message:?}");
        }
    }
    assert!(start.elapsed().as_secs() < 2, "took {:?}", start.elapsed());
    let quads =
        loaded("scene.json", scene(7).as_bytes()).expect("subdivides").scene.shapes.remove(0);
    assert_eq!(quads.elements.count(), 4_usize.pow(7));
}

#[test]
fn a_polyline_or_polygon_of_any_length_is_one_list() {
    let mut vertices = String::new();
    let mut list = String::new();
    for i in 1..=100_000 {
        vertices += &format!("v {i} {} 0\n", i % 7);
        list += &format!(" {i}");
    }
    let line = loaded("thing.obj", format!("{vertices}l{list}\n").as_bytes()).expect("a polyline");
    assert_eq!(line.scene.shapes[1].elements.count(), 99_999);
    let face = loaded("thing.obj", format!("{vertices}f{list}\n").as_bytes()).expect("a polygon");
    assert_eq!(face.scene.shapes[1].elements.count(), 99_998);
    let count = 300_000_u32;
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
         property float z\nelement line 1\nproperty list uint uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    for i in 0..count {
        bytes.extend([i as f32, (i % 5) as f32, 0.0].map(f32::to_le_bytes).concat());
    }
    bytes.extend(count.to_le_bytes());
    bytes.extend((0..count).flat_map(u32::to_le_bytes));
    let hair = loaded("hair.ply", &bytes).expect("a long polyline");
    assert_eq!(hair.scene.shapes[1].elements.count(), count as usize - 1);
}

#[test]
fn an_empty_path_is_visible_in_the_message() {
    let message = load("", &LoadOptions::default()).map(drop).expect_err("no file").to_string();
    assert!(message.starts_with("\"\": cannot be read: "), "{message}");
}
