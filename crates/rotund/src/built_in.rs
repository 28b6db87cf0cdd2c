//! The scenes that are built into the program, so that it needs no checkout.

use anyhow::{Context, Result};
use rotund_scene::{LoadOptions, Loaded};
use std::path::Path;

/// The files of `scenes/`, each with its path relative to that folder; `build.rs` lists them.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/scene_files.rs"));

/// Returns the names of the scenes, in order.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().filter_map(|(path, _)| path.strip_suffix(".json"))
}

/// Loads the scene of this name, which must be one of [`names`].
pub(crate) fn load(name: &str, options: &LoadOptions) -> Result<Loaded> {
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    for (path, bytes) in FILES {
        let path = folder.path().join(path);
        let parent = path.parent().unwrap_or(Path::new(""));
        let written = std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&path, bytes));
        written.with_context(|| format!("cannot write {}", path.display()))?;
    }
    let path = folder.path().join(name).with_extension("json");
    let loaded = rotund_scene::load(path, options)?;
    Ok(Loaded { files: Vec::new(), ..loaded })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fs;

    /// Every file below a folder, relative to it.
    fn files_below(folder: &Path, prefix: &str) -> BTreeSet<(String, Vec<u8>)> {
        let entries = fs::read_dir(folder).expect("the folder is there");
        let mut files = BTreeSet::new();
        for path in entries.map(|entry| entry.expect("an entry").path()) {
            let name = path.file_name().expect("a name").to_string_lossy();
            if path.is_dir() {
                files.extend(files_below(&path, &format!("{prefix}{name}/")));
            } else {
                let bytes = fs::read(&path).expect("a readable file");
                files.insert((format!("{prefix}{name}"), bytes));
            }
        }
        files
    }

    #[test]
    fn every_scene_file_of_the_workspace_is_built_in() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let mut expected = files_below(&folder, "");
        expected.retain(|(name, _)| !name.ends_with(".md"));
        let found: BTreeSet<_> =
            FILES.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect();
        let names = |files: &BTreeSet<(String, Vec<u8>)>| {
            files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(names(&found), names(&expected));
        assert!(found == expected, "the bytes differ");
        assert!(found.len() > 10, "the folder has scenes and shapes");
    }

    #[test]
    fn every_built_in_scene_loads_without_a_warning() {
        for name in names() {
            let loaded = load(name, &LoadOptions::default());
            let loaded = loaded.unwrap_or_else(|error| panic!("{name}: {error:#}"));
            assert_eq!(loaded.warnings, [""; 0], "{name}");
            assert!(!loaded.scene.instances.is_empty(), "{name}");
        }
    }
}
