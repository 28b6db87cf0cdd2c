//! Lists the scene files that are built into the program.
//!
//! In a package they lie in `scenes/`. In a checkout that is a symbolic link, which Windows may
//! check out as a file of text, so the folder that it names is tried as well.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let folders = ["scenes", "../../scenes"].map(|folder| package.join(folder));
    let folder = folders.iter().find(|folder| folder.is_dir()).expect("the package has scenes");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut files = Vec::new();
    list(&folder.canonicalize()?, "", &mut files)?;
    files.sort();
    let mut table = String::from("&[\n");
    for (name, path) in files {
        writeln!(table, "    ({name:?}, include_bytes!({path:?})),").expect("a string grows");
    }
    table += "]\n";
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::write(out.join("scene_files.rs"), table)
}

/// Adds all files but pages for people, with their paths relative to the folder of the scenes.
fn list(folder: &Path, prefix: &str, files: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            list(&path, &format!("{prefix}{name}/"), files)?;
        } else if path.extension().is_some_and(|extension| extension != "md") {
            files.push((format!("{prefix}{name}"), path));
        }
    }
    Ok(())
}
