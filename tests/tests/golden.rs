//! The golden pictures of the workspace look as they did when somebody accepted them.

#[test]
fn the_golden_pictures_look_as_they_did() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = folder.path().join("report.html");
    let report = report.to_str().expect("a path of plain text");
    if let Err(error) = xtask::run(["xtask", "golden", "--report", report]) {
        panic!("{error:#}; for a page of what differs, run cargo xtask golden");
    }
}
