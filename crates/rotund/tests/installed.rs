//! The program needs nothing but itself: no checkout, no home, no environment.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in a folder that is its home as well, without any environment variable of ours.
fn rotund(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rotund"));
    command.env_clear().env("HOME", folder).current_dir(folder).args(arguments);
    command.output().expect("the program starts")
}

#[track_caller]
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = rotund(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn a_built_in_scene_is_compared_in_an_empty_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["compare", "shapes4", "--resolution", "24", "--samples", "1"];
    let table = succeed(folder.path(), &arguments);
    assert!(table.contains("shapes4") && table.contains("flip_mean"), "{table}");
    assert!(table.ends_with("open out/shapes4/report.html\n"), "{table}");
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
    let files = "vanilla.png vanilla.exr enhanced.png enhanced.exr difference.png flip.png \
        metrics.json report.html";
    for file in files.split_whitespace() {
        assert!(folder.path().join("out/shapes4").join(file).is_file(), "{file}");
    }
    let in_folder = fs::read_dir(folder.path()).expect("the folder is there").count();
    assert_eq!(in_folder, 1, "nothing but out/");
}

#[test]
fn a_scene_with_shapes_in_files_renders_by_both_methods() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for method in ["vanilla", "enhanced"] {
        let out = format!("{method}.png");
        let size = ["--resolution", "24", "--samples", "1"];
        let render = ["render", "patches", "--mode", method, "--out", &out];
        succeed(folder.path(), &[&render[..], &size].concat());
        assert!(folder.path().join(out).is_file());
    }
}

#[test]
fn a_lone_ply_file_renders() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
        property float z\nend_header\n0 0 0\n1 0 0\n";
    fs::write(folder.path().join("cloud.ply"), ply).expect("a shape file");
    let line = "render cloud.ply --radius 0.2 --resolution 24 --samples 1 --out cloud.png";
    let arguments: Vec<_> = line.split_whitespace().collect();
    let said = succeed(folder.path(), &arguments);
    assert!(said.starts_with("cloud.png: 24 x "), "{said}");
    assert!(folder.path().join("cloud.png").is_file());
    succeed(folder.path(), &["info", "cloud.ply"]);
}

/// Asserts that no line is longer than a terminal of 80 columns.
#[track_caller]
fn assert_narrow(text: &str) {
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line:?} is wider than 80 columns in\n{text}");
    }
}

#[test]
fn every_built_in_scene_is_described_within_80_columns() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for scene in ["glass", "lights", "patches", "shapes1", "shapes2", "shapes3", "shapes4"] {
        let text = succeed(folder.path(), &["info", scene]);
        assert!(text.starts_with(&format!("{scene}: ")), "{text}");
        assert_narrow(&text);
    }
}

#[test]
fn every_table_fits_in_80_columns_however_long_the_name_of_a_scene() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let name = "a-scene-with-a-name-that-nobody-would-type-more-than-once-".repeat(2);
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
        property float z\nproperty float radius\nend_header\n0 0 0 0.5\n";
    let scene = format!("{name}.ply");
    fs::write(folder.path().join(&scene), ply).expect("a shape file");
    let size = ["--resolution", "16", "--samples", "2"];
    let run = |arguments: &[&str]| succeed(folder.path(), arguments);
    let table = run(&[&["compare", &scene, "--out", "o"][..], &size].concat());
    assert!(table.lines().any(|line| line.trim_end() == &name[..80]), "{table}");
    assert_narrow(&table);
    let reference = "o/enhanced.exr";
    let noise = ["noise", &scene, "--reference", reference];
    assert_narrow(&run(&[&noise[..], &size].concat()));
    assert_narrow(&run(&["diff", "o/vanilla.png", reference]));
    let size = ["--bless", "--resolution", "16"];
    run(&[&["golden", "--dir", "g", &scene][..], &size].concat());
    let table = run(&["golden", "--dir", "g", &scene, "--isa", "portable"]);
    assert!(table.contains("FLIP") && table.contains("ok"), "{table}");
    assert_narrow(&table);
}

#[test]
fn an_unknown_scene_is_refused_with_the_names_of_the_built_in_ones() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = rotund(folder.path(), &["compare", "shapes5"]);
    assert_eq!(output.status.code(), Some(1));
    let expected = "error: there is no built-in scene \"shapes5\"; there are glass, lights, \
        molecule, neuron, patches, shapes1, shapes2, shapes3, shapes4, tracts, vessels, or give \
        the path of a JSON, PLY, OBJ, SWC, TCK, TRK, XYZ, TXT, CSV, PTS or ASC file\n";
    assert_eq!(String::from_utf8_lossy(&output.stderr), expected);
}

#[test]
fn a_missing_file_is_reported_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = rotund(folder.path(), &["info", "gone.json"]);
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(message.matches("No such file").count(), 1, "{message}");
    assert_eq!(message.matches("gone.json").count(), 1, "{message}");
}

#[test]
fn completions_are_for_rotund_and_know_every_command() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (shell, start) in [
        ("bash", "_rotund() {"),
        ("zsh", "#compdef rotund"),
        ("fish", "# Print an optspec"),
        ("powershell", "\nusing namespace"),
        ("elvish", "\nuse builtin"),
    ] {
        let script = succeed(folder.path(), &["completions", shell]);
        assert!(script.starts_with(start), "{shell}: {}", &script[..100]);
        let commands = [
            "compare",
            "render",
            "view",
            "merge",
            "diff",
            "noise",
            "info",
            "golden",
            "completions",
        ];
        for command in commands {
            assert!(script.contains(command), "{shell}: {command}");
        }
        assert!(!script.contains("xtask"), "{shell}");
    }
}

#[test]
fn help_is_that_of_rotund() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let without_a_command = succeed(folder.path(), &[]);
    let help = succeed(folder.path(), &["--help"]);
    for text in [without_a_command, help] {
        assert!(text.contains("Usage: rotund [COMMAND]"), "{text}");
        assert!(text.contains("rotund compare shapes4") && text.contains("130"), "{text}");
        assert!(!text.contains("xtask"), "{text}");
    }
}
