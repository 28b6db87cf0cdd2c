//! Golden pictures of a user's own scenes, by the command `golden`.

use std::fs;
use std::path::Path;

/// Runs `golden --dir` on scenes in a folder.
fn user_run(folder: &Path, scenes: &[&str], options: &[&str]) -> anyhow::Result<()> {
    let path = |name: &str| folder.join(name).into_os_string();
    let mut arguments = vec!["rotund".into(), "golden".into(), "--dir".into(), path("goldens")];
    arguments.extend(["--report".into(), path("report.html")]);
    arguments.extend(options.iter().map(Into::into));
    arguments.extend(scenes.iter().map(|scene| path(scene)));
    rotund::run(arguments)
}

fn write_scene(folder: &Path, name: &str, emission: f32) {
    let ball = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                property float z\nproperty float radius\nend_header\n0 0 -5 1\n";
    fs::write(folder.join("ball.ply"), ball).unwrap();
    let scene = format!(
        r#"{{"asset": {{"version": "4.2"}}, "cameras": [{{}}],
            "environments": [{{"emission": [{emission}, {emission}, {emission}]}}],
            "materials": [{{"color": [0.5, 0.5, 0.5]}}], "shapes": [{{"uri": "ball.ply"}}],
            "instances": [{{"shape": 0, "material": 0}}]}}"#
    );
    fs::write(folder.join(name), scene).unwrap();
}

#[test]
fn pictures_of_ones_own_scenes_are_checked_until_blessed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let error = |result: anyhow::Result<()>| format!("{:#}", result.unwrap_err());
    write_scene(folder, "a.json", 1.0);
    write_scene(folder, "b.json", 1.0);
    let bless = ["--bless", "--resolution", "24"];

    // A picture without a reference fails, and the check does not make one.
    let unblessed = error(user_run(folder, &["a.json"], &[]));
    assert!(unblessed.contains("1 of 1 pictures failed"), "{unblessed}");
    assert!(!folder.join("goldens").exists());

    user_run(folder, &["a.json", "b.json"], &bless).unwrap();
    user_run(folder, &["a.json", "b.json"], &[]).unwrap();

    // A reference whose scene is gone fails until --bless removes it.
    let dead = error(user_run(folder, &["a.json"], &[]));
    assert!(dead.contains("1 references belong to no scene"), "{dead}");
    user_run(folder, &["a.json"], &bless).unwrap();
    assert!(!folder.join("goldens/b.exr").exists());

    // --bless does not touch the reference of an unchanged picture.
    let before = fs::read(folder.join("goldens/a.exr")).unwrap();
    user_run(folder, &["a.json"], &bless).unwrap();
    assert_eq!(fs::read(folder.join("goldens/a.exr")).unwrap(), before);

    // A change fails with a page that needs no other file, and --bless accepts it.
    write_scene(folder, "a.json", 0.98);
    let changed = error(user_run(folder, &["a.json"], &[]));
    assert!(changed.contains("report.html") && changed.contains("--bless"), "{changed}");
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert_eq!(page.matches("<img ").count(), 4);
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 4);
    assert!(page.contains("<strong>energy</strong>") && !page.contains("http"));
    user_run(folder, &["a.json"], &bless).unwrap();
    user_run(folder, &["a.json"], &[]).unwrap();
}

#[test]
fn scenes_beside_their_references_are_checked_by_both_methods() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("goldens")).unwrap();
    write_scene(&folder.join("goldens"), "a.json", 1.0);
    user_run(folder, &[], &["--bless", "--resolution", "24"]).unwrap();
    for reference in ["a-vanilla.exr", "a-enhanced.exr"] {
        assert!(folder.join("goldens").join(reference).is_file(), "{reference}");
    }
    user_run(folder, &[], &[]).unwrap();
    let none = user_run(folder, &[], &["--only", "b"]).unwrap_err().to_string();
    assert_eq!(none, "no picture has \"b\" in its name");
}

#[test]
fn blessing_refuses_to_lower_a_check() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "a.json", 1.0);
    user_run(folder, &["a.json"], &["--bless", "--resolution", "24"]).unwrap();
    let before = fs::read(folder.join("goldens/a.exr")).unwrap();

    let smaller = user_run(folder, &["a.json"], &["--bless", "--resolution", "16"]);
    assert!(smaller.is_err(), "a smaller picture");
    write_scene(folder, "a.json", 0.0);
    let black = user_run(folder, &["a.json"], &["--bless", "--resolution", "24"]);
    assert!(black.is_err(), "a black picture");
    assert_eq!(fs::read(folder.join("goldens/a.exr")).unwrap(), before);
}
