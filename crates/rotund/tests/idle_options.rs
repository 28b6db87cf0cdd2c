//! Options that change nothing in a picture are named in a warning.

/// A triangle by itself, which gets a floor.
const TRIANGLE: &str = "v 0 1 0\nv 1 1 0\nv 0 2 0\nf 1 2 3\n";

#[test]
fn a_warning_names_the_option_that_changes_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("triangle.obj"), TRIANGLE).expect("writes the file");
    for (arguments, idle) in [
        ("triangle.obj --floor", Some("--floor")),
        ("triangle.obj --floor --transparent", None),
        ("shapes1 --floor --background white", Some("--floor")),
        ("shapes1 --background white", None),
        ("shapes1 --mode vanilla --kinds points,lines,quads", Some("--kinds")),
        ("shapes1 --mode vanilla", None),
        ("shapes1 --kinds lines", None),
    ] {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_rotund"))
            .current_dir(folder.path())
            .args(["render", "--out", "out.png", "--samples", "1", "--resolution", "16"])
            .args(arguments.split(' '))
            .output()
            .expect("the program starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments}: {message}");
        let named = ["--floor", "--kinds"]
            .into_iter()
            .find(|option| message.contains(&format!("{option} changes nothing")));
        assert_eq!(named, idle, "{arguments}: {message}");
    }
}
