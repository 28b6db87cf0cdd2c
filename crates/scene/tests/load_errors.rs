//! The message for every kind of invalid input names the file and the problem.

#![cfg(feature = "load")]

use rotund_scene::{LoadOptions, load};
use std::{fs, path::Path};
use tempfile::TempDir;

/// A folder with a scene of one triangle, parts of which each case replaces.
struct Folder(TempDir);

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn scene(shape: &str, rest: &str) -> String {
    format!(
        r#"{{ "asset": {{ "version": "4.2" }}, "shapes": [{{ "name": "thing", "uri": "{shape}" }}],
        "materials": [{{ "name": "grey", "color": [0.5, 0.5, 0.5] }}]{rest} }}"#
    )
}

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.write("shape.ply", TRIANGLE);
        folder.write("scene.json", scene("shape.ply", ""));
        folder
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), content).expect("writes into the folder");
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Returns the message of the error of loading.
    fn error(&self, options: &LoadOptions) -> String {
        load(self.path().join("scene.json"), options).expect_err("refused").to_string()
    }
}

fn assert_names(why: &str, message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{why}: {part:?} is not in {message:?}");
    }
    assert!(!message.contains('\n'), "{why}: one line: {message:?}");
}

#[test]
fn the_scene_before_replacements_loads() {
    let folder = Folder::new();
    let loaded = load(folder.path().join("scene.json"), &LoadOptions::default());
    let loaded = loaded.expect("a good scene");
    assert_eq!(loaded.scene.shapes[0].elements.count(), 1);
    assert_eq!(loaded.warnings, Vec::<String>::new());
}

#[test]
fn bad_scenes() {
    let rest = |rest: &str| scene("shape.ply", &format!(", {rest}"));
    let table: &[(&str, String, &[&str])] = &[
        // what is wrong                 the file                         what the message names
        ("not JSON", "{ nonsense".into(), &["scene.json: is not JSON: ", "line 1"]),
        ("junk", "junk".into(), &["scene.json: is not JSON: expected a value at line 1 column 1"]),
        ("cut off", rest("\"cameras\": [{ \"lens\": 0.0"), &["scene.json", "cameras", "EOF"]),
        ("empty", String::new(), &["scene.json", "line 1"]),
        ("something after the end", format!("{} []", scene("shape.ply", "")), &["trailing"]),
        (
            "a word for a number",
            rest(r#""cameras": [{ "lens": "long" }]"#),
            &["scene.json", "cameras[0].lens", "\"long\""],
        ),
        ("an object for a list", rest(r#""cameras": 3"#), &["cameras", "an array, or an object"]),
        ("a short frame", rest(r#""cameras": [{ "frame": [1, 0] }]"#), &["cameras[0].frame", "12"]),
        (
            "a flat frame",
            rest(
                r#""instances": [{ "frame": [1,0,0, 0,0,0, 0,0,1, 0,0,0], "shape": 0, "material": 0 }]"#,
            ),
            &["instances[0].frame", "independent"],
        ),
        (
            "a number beyond f32",
            rest(r#""cameras": [{ "lens": 1e99 }]"#),
            &["cameras[0].lens", "inf", "positive"],
        ),
        ("no lens", rest(r#""cameras": [{ "lens": 0 }]"#), &["cameras[0].lens", "positive"]),
        ("negative aspect", rest(r#""cameras": [{ "aspect": -1 }]"#), &["cameras[0].aspect", "-1"]),
        (
            "a look at itself",
            rest(r#""cameras": [{ "lookat": [0,0,0, 0,0,0, 0,1,0] }]"#),
            &["cameras[0].lookat"],
        ),
        (
            "a shape that is not there",
            rest(r#""instances": [{ "shape": 7, "material": 0 }]"#),
            &["scene.json", "instances[0].shape", "7", "1 shapes"],
        ),
        (
            "a negative index",
            rest(r#""instances": [{ "shape": 0, "material": -1 }]"#),
            &["instances[0].material", "-1", "1 materials"],
        ),
        (
            "an index that is no integer",
            rest(r#""instances": [{ "shape": 0.5, "material": 0 }]"#),
            &["instances[0].shape", "an index or a name"],
        ),
        (
            "a name that is not there",
            rest(r#""instances": [{ "shape": "thing", "material": "gray" }]"#),
            &["instances[0].material", "\"gray\"", "materials"],
        ),
        (
            "an instance of nothing",
            rest(r#""instances": [{ "material": 0 }]"#),
            &["instances[0].shape", "missing"],
        ),
        (
            "a texture that is not there",
            rest(r#""environments": [{ "emission_tex": 2 }]"#),
            &["environments[0].emission_tex", "2", "0 textures"],
        ),
        (
            "an unknown material",
            r#"{ "materials": [{ "type": "cheese" }] }"#.into(),
            &["materials[0].type", "cheese", "matte"],
        ),
        (
            "too rough",
            r#"{ "materials": [{ "roughness": 2 }] }"#.into(),
            &["materials[0].roughness", "2", "between 0 and 1"],
        ),
        (
            "a colour below zero",
            r#"{ "materials": [{ "color": [0, -1, 0] }] }"#.into(),
            &["materials[0].color", "-1"],
        ),
        (
            "a missing file",
            scene("nowhere.ply", ""),
            &["nowhere.ply", "shapes[0].uri", "scene.json"],
        ),
        ("a folder", scene("folder.ply", ""), &["folder", "shapes[0].uri"]),
        ("no file and no generator", r#"{ "shapes": [{}] }"#.into(), &["shapes[0].uri", "missing"]),
        (
            "a kind of mesh that nobody reads",
            scene("scene.json", ""),
            &["scene.json", "\"json\"", "ply"],
        ),
        (
            "a file that is no image",
            r#"{ "textures": [{ "uri": "scene.json" }] }"#.into(),
            &["scene.json", "no image", "PNG"],
        ),
        ("an image that is none", r#"{ "textures": [{ "uri": "bad.png" }] }"#.into(), &["bad.png"]),
        (
            "out of the folder",
            scene("../shape.ply", ""),
            &["shapes[0].uri", "../shape.ply", "folder"],
        ),
        ("an absolute path", scene("/etc/passwd", ""), &["shapes[0].uri", "/etc/passwd", "folder"]),
        (
            "an unknown generator",
            r#"{ "shapes": [{ "generator": { "teapot": {} } }] }"#.into(),
            &["shapes[0].generator", "teapot", "quad_sphere"],
        ),
        (
            "a generator without a radius",
            r#"{ "shapes": [{ "generator": { "disk": { "steps": 3 } } }] }"#.into(),
            &["shapes[0].generator", "radius"],
        ),
        (
            "a generator of too much",
            r#"{ "shapes": [{ "generator": { "disk": { "steps": 4000000000, "radius": 1 } } }] }"#
                .into(),
            &["shapes[0].generator.steps", "4000000000", "4096"],
        ),
        (
            "hair on a cloud",
            r#"{ "shapes": [{ "generator": { "hair": { "strands": 1, "steps": 1, "length": 1,
                "radius": [1, 1], "on": { "points_grid": { "steps": [1, 1], "size": [1, 1],
                "radius": 1 } } } } }] }"#
                .into(),
            &["shapes[0].generator.on", "surface"],
        ),
    ];
    for (why, content, parts) in table {
        let folder = Folder::new();
        folder.write("scene.json", content);
        folder.write("bad.png", "no image");
        fs::create_dir(folder.path().join("folder.ply")).expect("a folder");
        assert_names(why, &folder.error(&LoadOptions::default()), parts);
    }
}

/// Returns a PLY file with these lines of the header and this data.
fn ply(header: &[&str], data: &str) -> String {
    format!("ply\nformat ascii 1.0\n{}\nend_header\n{data}", header.join("\n"))
}

#[test]
fn bad_shapes() {
    const XYZ: [&str; 4] =
        ["element vertex 3", "property float x", "property float y", "property float z"];
    let with = |more: &[&str], data: &str| ply(&[&XYZ[..], more].concat(), data);
    const FACE: [&str; 2] = ["element face 1", "property list uchar int vertex_indices"];
    const LINE: [&str; 2] = ["element line 1", "property list uchar int vertex_indices"];
    const POINT: [&str; 2] = ["element point 1", "property list uchar int vertex_indices"];
    let table: &[(&str, String, &[&str])] = &[
        ("empty", String::new(), &["is not a PLY file", "start with a line `ply`"]),
        ("not PLY", "solid cube\n".into(), &["is not a PLY file", "start with a line `ply`"]),
        ("a header without an end", "ply\nformat ascii 1.0\n".into(), &["line 3", "no end"]),
        ("no format", "ply\nend_header\n".into(), &["line 2", "format"]),
        (
            "an unknown format",
            "ply\nformat binary_middle_endian 1.0\n".into(),
            &["line 2", "middle"],
        ),
        ("an unknown type", with(&["property quad w"], ""), &["line 7", "\"quad\""]),
        (
            "a list as long as a fraction",
            with(&["property list float int l"], ""),
            &["line 7", "\"l\""],
        ),
        ("a property of nothing", "ply\nformat ascii 1.0\nproperty float x\n".into(), &["line 3"]),
        ("a count of a word", "ply\nelement vertex many\n".into(), &["line 2", "\"many\""]),
        ("a negative count", "ply\nelement vertex -1\n".into(), &["line 2", "\"-1\""]),
        ("nonsense", "ply\nhello\n".into(), &["line 2", "hello"]),
        ("no positions", ply(&["element vertex 1", "property float x"], "0\n"), &["x, y and z"]),
        (
            "no elements",
            with(&[], "").replace("vertex 3", "vertex 0"),
            &["no points, lines or faces"],
        ),
        ("fewer vertices than claimed", with(&[], "0 0 0\n0 0 0\n"), &["before vertex 2 of 3"]),
        (
            "ten to the eighteen vertices",
            with(&[], "0 0 0\n").replace("vertex 3", "vertex 1000000000000000000"),
            &["before vertex", "of 1000000000000000000"],
        ),
        (
            "a list that runs past the end",
            with(&FACE, "0 0 0 1 0 0 0 1 0\n200 0 1\n"),
            &["before face 0 of 1"],
        ),
        (
            "a list of a negative length",
            with(
                &["element face 1", "property list char int vertex_indices"],
                "0 0 0 1 0 0 0 1 0 -3 0\n",
            ),
            &["face 0", "vertex_indices", "-3"],
        ),
        (
            "a word for a number",
            with(&[], "0 0 zero\n0 0 0\n0 0 0\n"),
            &["vertex 0", "z", "\"zero\""],
        ),
        (
            "not a number anywhere",
            with(&[], "0 nan 0\n0 nan 0\n0 0 nan\n"),
            &["vertex 0", "position", "NaN", "finite"],
        ),
        ("infinite", with(&[], "1e99 0 0\n1e99 0 0\n1e99 0 0\n"), &["vertex 0", "position", "inf"]),
        (
            "negative radii",
            with(&["property float radius"], "0 0 0 -1\n0 0 0 -0.5\n0 0 0 -1\n"),
            &["vertex 0", "radius", "-1", "not negative"],
        ),
        (
            "a vertex that is not there",
            with(&FACE, "0 0 0 1 0 0 0 1 0\n3 0 1 3\n"),
            &["face 0", "vertex 3", "3 vertices"],
        ),
        (
            "a negative vertex",
            with(&FACE, "0 0 0 1 0 0 0 1 0\n3 0 1 -1\n"),
            &["face 0", "vertex -1", "3 vertices"],
        ),
        (
            "a line to nowhere",
            with(&LINE, "0 0 0 1 0 0 0 1 0\n2 0 9\n"),
            &["line 0", "vertex 9", "3 vertices"],
        ),
        (
            "a point that is not there",
            with(&POINT, "0 0 0 1 0 0 0 1 0\n1 4\n"),
            &["point 0", "vertex 4", "3 vertices"],
        ),
    ];
    for (why, content, parts) in table {
        let folder = Folder::new();
        folder.write("shape.ply", content);
        let message = folder.error(&LoadOptions::default());
        assert_names(why, &message, parts);
        assert_names(why, &message, &["shape.ply"]);
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_without_a_panic() {
    let mut binary = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
        property float y\nproperty double z\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n"
        .to_vec();
    for i in 0..3_u8 {
        binary.extend(f32::from(i).to_le_bytes());
        binary.extend(f32::from(i * i).to_le_bytes());
        binary.extend(0_f64.to_le_bytes());
    }
    binary.push(3);
    for i in 0..3_i32 {
        binary.extend(i.to_le_bytes());
    }
    let folder = Folder::new();
    folder.write("shape.ply", &binary);
    load(folder.path().join("scene.json"), &LoadOptions::default())
        .expect("the whole file is good");
    for length in 0..binary.len() {
        folder.write("shape.ply", &binary[..length]);
        assert_names("cut", &folder.error(&LoadOptions::default()), &["shape.ply"]);
    }
    let json = scene("shape.ply", "");
    folder.write("shape.ply", TRIANGLE);
    for length in 0..json.len() - 1 {
        folder.write("scene.json", &json.as_bytes()[..length]);
        assert_names("cut", &folder.error(&LoadOptions::default()), &["scene.json"]);
    }
}

#[test]
fn files_outside_the_folder_are_refused_unless_allowed() {
    let outer = Folder::new();
    fs::create_dir(outer.path().join("inner")).expect("a folder");
    let path = outer.path().join("inner/scene.json");
    fs::write(&path, scene("../shape.ply", "")).expect("writes the scene");
    assert!(load(&path, &LoadOptions::default()).is_err(), "refused by default");
    let allowed = LoadOptions { allow_outside_folder: true, ..LoadOptions::default() };
    assert!(load(&path, &allowed).is_ok(), "allowed explicitly");
}

#[cfg(unix)]
#[test]
fn a_link_out_of_the_folder_is_followed_only_if_allowed() {
    let (elsewhere, folder) = (Folder::new(), Folder::new());
    let link = folder.path().join("link.ply");
    std::os::unix::fs::symlink(elsewhere.path().join("shape.ply"), link).expect("a link");
    folder.write("scene.json", scene("link.ply", ""));
    assert_names("link", &folder.error(&LoadOptions::default()), &["shapes[0].uri", "folder"]);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_without_waiting() {
    let folder = Folder::new();
    let pipe = folder.path().join("pipe.ply");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        // Skip the test on systems without the tool.
        return;
    }
    folder.write("scene.json", scene("pipe.ply", ""));
    assert_names(
        "pipe",
        &folder.error(&LoadOptions::default()),
        &["pipe.ply", "pipe", "shapes[0]"],
    );
}

#[test]
fn a_missing_scene_and_a_folder_are_named() {
    let folder = Folder::new();
    let options = LoadOptions::default();
    let missing = load(folder.path().join("no.json"), &options).expect_err("refused").to_string();
    assert_names("missing", &missing, &["no.json", "cannot be read"]);
    let directory = load(folder.path(), &options).expect_err("refused").to_string();
    assert_names("folder", &directory, &["folder, not a file"]);
}

#[test]
fn a_bad_texture_is_white_if_asked_to_keep_going() {
    let folder = Folder::new();
    folder.write("scene.json", r#"{ "textures": [{ "uri": "gone.png" }] }"#);
    let options = LoadOptions { keep_going: true, ..LoadOptions::default() };
    let loaded = load(folder.path().join("scene.json"), &options).expect("keeps going");
    assert_eq!(loaded.scene.textures[0].width, 1);
    assert_names("keep going", &loaded.warnings[0], &["gone.png", "textures[0]", "white"]);
}

#[test]
fn each_unknown_field_is_one_warning() {
    let folder = Folder::new();
    folder.write(
        "scene.json",
        r#"{ "materials": [{ "shine": 1 }, { "shine": 2 }, { "glow": 1 }], "weather": "fine" }"#,
    );
    let loaded = load(folder.path().join("scene.json"), &LoadOptions::default()).expect("loads");
    let named = |what: &str| loaded.warnings.iter().filter(|w| w.contains(what)).count();
    assert_eq!(loaded.warnings.len(), 3, "{:?}", loaded.warnings);
    assert_eq!(
        (named("materials[].shine"), named("materials[].glow"), named("weather")),
        (1, 1, 1)
    );
    let by_name = r#"{ "materials": { "a.1": { "shine": 1 }, "b": { "shine": 2 } } }"#;
    folder.write("scene.json", by_name);
    let loaded = load(folder.path().join("scene.json"), &LoadOptions::default()).expect("loads");
    let [warning] = &loaded.warnings[..] else { panic!("one: {:?}", loaded.warnings) };
    assert_names("items by name", warning, &["materials[].shine"]);
}
