//! The scenes that are built into the program, so that it needs no checkout.

use rotund_scene::{LoadError, LoadOptions, Loaded, load_bytes};
use std::borrow::Cow;

/// The files of `scenes/`, each with its path relative to that folder; `build.rs` lists them.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/scene_files.rs"));

/// Returns the names of the scenes, in order.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().filter_map(|(path, _)| path.strip_suffix(".json"))
}

/// Loads the scene of this name, if it is one of [`names`]. The list of files that were read is
/// empty.
pub(crate) fn load(name: &str, options: &LoadOptions) -> Option<Result<Loaded, LoadError>> {
    let scene = format!("{name}.json");
    let json = bytes(&scene)?;
    let file = |path: &str| bytes(path).map(Cow::Borrowed);
    let loaded = load_bytes(scene, json, &file, options);
    Some(loaded.map(|loaded| Loaded { files: Vec::new(), ..loaded }))
}

fn bytes(path: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(name, _)| *name == path).map(|(_, bytes)| *bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

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
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folders = ["../../scenes", "scenes"].map(|folder| package.join(folder));
        let folder = folders.into_iter().find(|folder| folder.is_dir()).expect("the scenes");
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
            let loaded = load(name, &LoadOptions::default()).expect("a built-in scene");
            let loaded = loaded.unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(loaded.warnings, [""; 0], "{name}");
            assert!(!loaded.scene.instances.is_empty(), "{name}");
        }
        assert!(load("shapes9", &LoadOptions::default()).is_none());
    }
}
