//! The folder of the workspace.

use std::env;
use std::path::{Path, PathBuf};

/// Returns the root of the workspace that the working directory belongs to, or else of the one that
/// this program was built in.
pub(crate) fn root() -> PathBuf {
    let around = env::current_dir().ok().and_then(|folder| {
        let is_root =
            |folder: &&Path| folder.join("scenes").is_dir() && folder.join("xtask").is_dir();
        folder.ancestors().find(is_root).map(Path::to_owned)
    });
    let built_in = || Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    around.unwrap_or_else(built_in)
}
