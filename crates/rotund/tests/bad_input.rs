//! The program says in one clear sentence what is wrong, exits with the documented code, and
//! leaves nothing behind.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn rotund(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rotund"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// Makes a folder with a small scene. `from` is replaced by `to` in the scene file; its shape is
/// `ply`.
fn scene(from: &str, to: &str, ply: &str) -> (tempfile::TempDir, PathBuf) {
    let json = r#"{
        "asset": { "version": "4.2" },
        "cameras": [{ "name": "front", "frame": [1,0,0, 0,1,0, 0,0,1, 0,0,2] }],
        "environments": [{ "emission": [1, 1, 1] }],
        "materials": [{ "name": "grey", "color": [0.5, 0.5, 0.5] }],
        "shapes": [{ "name": "one", "uri": "one.ply" }],
        "instances": [{ "name": "it", "shape": 0, "material": 0 }]
    }"#;
    assert!(from.is_empty() || json.contains(from), "{from:?} is in the scene");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.json");
    fs::write(&path, json.replacen(from, to, 1)).expect("a scene file");
    fs::write(folder.path().join("one.ply"), ply).expect("a shape file");
    (folder, path)
}

/// Asserts that a run failed with `code`, printed all of `words` on one line, and made no file.
#[track_caller]
fn assert_refused(why: &str, folder: &Path, output: &Output, code: i32, words: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{why}: {message}");
    assert!(output.stdout.is_empty(), "{why}: nothing goes to standard output");
    assert!(!message.contains("panicked"), "{why}: {message}");
    let error = message.lines().find(|line| line.starts_with("error: "));
    let error = error.unwrap_or_else(|| panic!("{why}: no error in {message:?}"));
    for word in words {
        assert!(error.contains(word), "{why}: {word:?} is not in {error:?}");
    }
    if code == 1 {
        assert_eq!(message.lines().count(), 1, "{why}: more than a line: {message}");
    }
    let left: Vec<_> = fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| name != "scene.json" && name != "one.ply")
        .collect();
    assert!(left.is_empty(), "{why}: left behind {left:?}");
}

#[test]
fn a_good_scene_renders_so_the_table_below_tests_its_faults_alone() {
    let (folder, _) = scene("", "", TRIANGLE);
    let output = rotund(
        folder.path(),
        &["render", "scene.json", "--resolution", "8", "--samples", "1", "--out", "a.png"],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path().join("a.png").is_file());
}

#[test]
fn a_bad_scene_is_refused_with_the_names_of_file_and_field() {
    let truncated = &TRIANGLE[..TRIANGLE.len() - 12];
    let out_of_range = TRIANGLE.replace("3 0 1 2", "3 0 1 7");
    let nan = TRIANGLE.replace("1 0 0\n0 1", "1 nan 0\n0 1");
    let sphere = |radius: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
             property float z\nproperty float radius\nelement point 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 {radius}\n1 0\n"
        )
    };
    let (negative, not_a_number) = (sphere("-1"), sphere("nan"));
    type Case<'a> = (&'a str, &'a str, &'a str, &'a str, &'a [&'a str]);
    let table: [Case<'_>; 11] = [
        // why                     in the scene          becomes              the shape
        ("missing shape", "one.ply", "two.ply", TRIANGLE, &["two.ply", "shapes[0]"]),
        (
            "truncated JSON",
            "\"shape\": 0, \"material\": 0 }]\n    }",
            "",
            TRIANGLE,
            &["scene.json"],
        ),
        ("truncated shape", "", "", truncated, &["one.ply", "ends"]),
        (
            "wrong type",
            "[0.5, 0.5, 0.5]",
            "\"red\"",
            TRIANGLE,
            &["scene.json", "materials[0].color"],
        ),
        (
            "unknown material",
            "\"material\": 0",
            "\"material\": 5",
            TRIANGLE,
            &["instances[0].material", "5"],
        ),
        ("unknown shape", "\"shape\": 0", "\"shape\": 9", TRIANGLE, &["instances[0].shape", "9"]),
        ("vertex out of range", "", "", &out_of_range, &["one.ply", "face 0", "7"]),
        ("NaN position", "", "", &nan, &["one.ply", "vertex 1"]),
        ("negative radius", "", "", &negative, &["one.ply", "vertex 0", "radius", "-1"]),
        ("NaN radius", "", "", &not_a_number, &["one.ply", "vertex 0", "radius"]),
        ("no shape at all", "", "", "", &["one.ply"]),
    ];
    for (why, from, to, ply, words) in table {
        let (folder, _) = scene(from, to, ply);
        let output = rotund(folder.path(), &["render", "scene.json", "--out", "a.png"]);
        assert_refused(why, folder.path(), &output, 1, words);
    }
}

#[test]
fn bad_arguments_are_refused_before_any_work() {
    type Case<'a> = (&'a str, &'a [&'a str], i32, &'a [&'a str]);
    let table: [Case<'_>; 15] = [
        ("no folder of references", &["golden", "scene.json"], 2, &["required arguments"]),
        ("unknown scene", &["info", "shapes9"], 1, &["shapes9", "shapes1", "shapes4"]),
        ("missing file", &["info", "no/such.json"], 1, &["no/such.json"]),
        ("a folder", &["info", "./"], 1, &["folder"]),
        (
            "unknown camera",
            &["render", "scene.json", "--camera", "side", "--out", "a.png"],
            1,
            &["side", "front"],
        ),
        ("zero samples", &["compare", "scene.json", "--samples", "0"], 2, &["--samples"]),
        ("zero size", &["compare", "scene.json", "--resolution", "0"], 2, &["--resolution"]),
        ("zero bounces", &["compare", "scene.json", "--bounces", "0"], 2, &["--bounces"]),
        ("unknown kind", &["compare", "scene.json", "--kinds", "lines,dots"], 2, &["dots"]),
        ("unknown command", &["dance"], 2, &["dance"]),
        (
            "unknown format",
            &["render", "scene.json", "--out", "a.gif"],
            1,
            &["a.gif", "png, jpg, hdr and exr"],
        ),
        (
            "format without alpha",
            &["render", "scene.json", "--transparent", "--out", "a.jpg"],
            1,
            &["a.jpg", "transparent", "png and exr"],
        ),
        ("no such folder", &["render", "scene.json", "--out", "x/a.png"], 1, &["x"]),
        ("a file is no folder", &["compare", "scene.json", "--out", "one.ply"], 1, &["one.ply"]),
        ("not an image", &["diff", "one.ply", "one.ply"], 1, &["one.ply", "EXR"]),
    ];
    let (folder, _) = scene("", "", TRIANGLE);
    for (why, arguments, code, words) in table {
        let output = rotund(folder.path(), arguments);
        assert_refused(why, folder.path(), &output, code, words);
    }
}

#[test]
fn a_truncated_image_is_refused_with_its_name() {
    let (folder, _) = scene("", "", TRIANGLE);
    for name in ["a.png", "a.jpg", "a.exr", "a.hdr"] {
        let render =
            ["render", "scene.json", "--resolution", "16", "--samples", "1", "--out", name];
        assert!(rotund(folder.path(), &render).status.success(), "{name}");
        let path = folder.path().join(name);
        let bytes = fs::read(&path).expect("a rendered image");
        fs::write(&path, &bytes[..bytes.len() / 2]).expect("half of it");
        let output = rotund(folder.path(), &["diff", name, name]);
        fs::remove_file(&path).expect("the image is there");
        assert_refused(name, folder.path(), &output, 1, &[name]);
    }
}

#[cfg(unix)]
#[test]
fn an_output_folder_without_permission_is_refused_before_the_render() {
    use std::os::unix::fs::PermissionsExt as _;
    let (folder, _) = scene("", "", TRIANGLE);
    let closed = tempfile::tempdir().expect("a temporary folder");
    fs::set_permissions(closed.path(), fs::Permissions::from_mode(0o555)).expect("permissions");
    if fs::write(closed.path().join("probe"), "").is_ok() {
        return; // The superuser may write anywhere.
    }
    let out = closed.path().join("a.png").to_string_lossy().into_owned();
    // If the render began, it would take hours.
    let long = ["render", "scene.json", "--samples", "1000000", "--out", &out];
    let output = rotund(folder.path(), &long);
    assert_refused("closed folder", folder.path(), &output, 1, &["cannot write"]);
}

#[test]
fn help_shows_examples_of_every_command() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let commands = ["compare", "render", "merge", "diff", "noise", "info", "golden", "completions"];
    for command in commands {
        let output = rotund(folder.path(), &[command, "--help"]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{command}");
        assert!(text.contains(&format!("  rotund {command} ")), "{command}: {text}");
        assert!(text.contains("Examples:"), "{command}: {text}");
    }
}

#[test]
fn a_scene_with_a_bad_texture_renders_if_asked_to_keep_going() {
    let (folder, _) =
        scene("\"cameras\"", "\"textures\": [{ \"uri\": \"gone.png\" }], \"cameras\"", TRIANGLE);
    let render = ["render", "scene.json", "--resolution", "16", "--samples", "1", "--out", "a.png"];
    let output = rotund(folder.path(), &render);
    assert_refused("without", folder.path(), &output, 1, &["gone.png", "textures[0].uri"]);
    let output = rotund(folder.path(), &[&render[..], &["--keep-going"]].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && folder.path().join("a.png").is_file(), "{said}");
    assert!(said.contains("left out") && said.contains("gone.png"), "{said}");
}

#[test]
fn a_file_outside_the_folder_is_read_only_if_allowed() {
    let (folder, _) = scene("one.ply", "../one.ply", TRIANGLE);
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).expect("a folder");
    fs::rename(folder.path().join("scene.json"), inner.join("scene.json"))
        .expect("moves the scene");
    let output = rotund(folder.path(), &["info", "inner/scene.json"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && said.contains("--allow-outside"), "{said}");
    let output = rotund(folder.path(), &["info", "inner/scene.json", "--allow-outside"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn control_characters_of_names_do_not_reach_the_terminal() {
    let (folder, _) = scene("\"front\"", "\"fr\\u001b[31mont\"", TRIANGLE);
    for arguments in [
        &["info", "scene.json"][..],
        &["info", "no\u{1b}[2J.json"],
        &["render", "scene.json", "--camera", "x", "--out", "a.png"],
        &["merge", "no\u{1b}[2J.film", "--out", "a.png"],
        &["merge", "no\u{7}.film", "--out", "a.png"],
    ] {
        let Output { stdout, stderr, .. } = rotund(folder.path(), arguments);
        let said = String::from_utf8([stdout, stderr].concat()).expect("text");
        let has_control = said.contains(|c: char| c.is_control() && c != '\n');
        assert!(!has_control && said.contains("\\u00"), "{arguments:?}: {said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_scene_whose_name_is_not_utf_8_renders() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let (folder, path) = scene("", "", TRIANGLE);
    let name = OsStr::from_bytes(b"sc\xffne.json");
    fs::rename(path, folder.path().join(name)).expect("moves the scene");
    let mut command = Command::new(env!("CARGO_BIN_EXE_rotund"));
    command.current_dir(folder.path()).arg("render").arg(name);
    let output = command.args(["--resolution", "8", "--samples", "1", "--out", "a.png"]).output();
    let output = output.expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn an_unknown_instruction_set_is_a_warning() {
    let (folder, _) = scene("", "", TRIANGLE);
    let mut command = Command::new(env!("CARGO_BIN_EXE_rotund"));
    command.current_dir(folder.path()).env("ROTUND_ISA", "mmx").args(["info", "scene.json"]);
    let output = command.output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.starts_with("warning: the variable ROTUND_ISA is ignored: "), "{said}");
    assert!(said.contains("\"mmx\"") && said.trim_end().ends_with(" is used"), "{said}");
}

/// Runs a shell line that sets a limit and then `exec`s the program; returns the exit code and what
/// it said.
#[cfg(target_os = "linux")]
fn under(limit: &str, folder: &Path, arguments: &str) -> (Option<i32>, String) {
    let line = format!("ulimit {limit}; exec {} {arguments}", env!("CARGO_BIN_EXE_rotund"));
    let mut command = Command::new("sh");
    let output = command.current_dir(folder).args(["-c", &line]).output().expect("sh");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[cfg(target_os = "linux")]
#[test]
fn points_that_do_not_fit_into_memory_are_refused_in_a_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Thirty million points, all at the origin: the file is a hole.
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 30000000\n\
        property float x\nproperty float y\nproperty float z\nend_header\n";
    let file = fs::File::create(folder.path().join("cloud.ply")).expect("a file");
    std::io::Write::write_all(&mut &file, header.as_bytes()).expect("a header");
    file.set_len(header.len() as u64 + 360_000_000).expect("a hole");
    for (kilobytes, words) in [(600_000, "load cloud.ply"), (2_000_000, "build the trees")] {
        let arguments = "render cloud.ply --radius 1 --resolution 8 --samples 1 --out a.png";
        let (code, said) = under(&format!("-v {kilobytes}"), folder.path(), arguments);
        assert_eq!(code, Some(5), "{said}");
        let expected = format!("error: not enough memory to {words}");
        assert!(said.starts_with(&expected) && said.lines().count() == 1, "{said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_does_not_fit_into_memory_is_refused_before_it_is_rendered() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // The film takes 300 MB, the picture half as much again.
    let arguments = "render shapes4 --resolution 4000 --samples 1 --threads 1 --out a.png";
    let (code, said) = under("-v 600000", folder.path(), arguments);
    assert_eq!(code, Some(5), "{said}");
    let expected = "error: not enough memory to write a picture of 4000 x 1333: it takes ";
    assert!(said.starts_with(expected) && said.lines().count() == 1, "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_beyond_the_limit_of_the_process_is_an_error_in_a_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = "render shapes4 --resolution 200 --samples 1 --out a.exr --checkpoint a.film";
    // In units of 512 bytes: a hundred kilobytes.
    let (code, said) = under("-f 200", folder.path(), arguments);
    assert_eq!(code, Some(5), "{said}");
    assert!(said.contains("error: cannot write a.exr: File too large"), "{said}");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0, "nothing is left");
}
