//! What no compiler checks about this workspace.

#[test]
fn the_workspace_is_tidy() {
    if let Err(error) = xtask::run(["xtask", "tidy"]) {
        panic!("{error:#}; the lines above say where");
    }
}
