//! The direction of dependencies between the crates of the workspace.

use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

/// Each crate, and the crates of the workspace that it may depend on, for its tests too.
const MAY_USE: [(&str, &[&str]); 15] = [
    ("rotund-geometry", &[]),
    ("rotund-image", &[]),
    ("rotund-bvh", &["rotund-geometry"]),
    ("rotund-scene", &["rotund-geometry", "rotund-bvh", "rotund-image"]),
    ("rotund-trace", &["rotund-geometry", "rotund-bvh", "rotund-image", "rotund-scene"]),
    (
        "rotund-viewer",
        &["rotund-geometry", "rotund-bvh", "rotund-image", "rotund-scene", "rotund-trace"],
    ),
    ("rotund-report", &["rotund-image"]),
    ("rotund-denoise", &["rotund-image"]),
    (
        "rotund-golden",
        &[
            "rotund-geometry",
            "rotund-bvh",
            "rotund-image",
            "rotund-scene",
            "rotund-trace",
            "rotund-report",
        ],
    ),
    (
        "rotund",
        &[
            "rotund-geometry",
            "rotund-bvh",
            "rotund-image",
            "rotund-scene",
            "rotund-trace",
            "rotund-report",
            "rotund-denoise",
            "rotund-golden",
            "rotund-viewer",
        ],
    ),
    (
        "rotund-study",
        &[
            "rotund-geometry",
            "rotund-bvh",
            "rotund-image",
            "rotund-scene",
            "rotund-trace",
            "rotund-report",
        ],
    ),
    ("rotund-tidy", &["rotund-scene"]),
    ("rotund-browser", &["rotund-report"]),
    (
        "xtask",
        &[
            "rotund-image",
            "rotund-scene",
            "rotund-trace",
            "rotund-report",
            "rotund",
            "rotund-study",
            "rotund-tidy",
        ],
    ),
    (
        "rotund-tests",
        &[
            "rotund-geometry",
            "rotund-bvh",
            "rotund-image",
            "rotund-scene",
            "rotund-trace",
            "rotund-report",
            "rotund-denoise",
            "rotund-golden",
            "rotund",
            "xtask",
        ],
    ),
];

/// Finds dependencies that are not in [`MAY_USE`].
pub(crate) fn check(root: &Path) -> Result<Vec<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(root)
        .output()
        .context("cannot run cargo metadata")?;
    let complaint = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "cargo metadata failed: {complaint}");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let mut findings = Vec::new();
    for package in array(&metadata["packages"]) {
        let name = package["name"].as_str().unwrap_or_default();
        for dependency in array(&package["dependencies"]) {
            // A dependency with a path is in the workspace.
            if dependency["path"].is_string() {
                let target = dependency["name"].as_str().unwrap_or_default();
                findings.extend(against_direction(name, target));
            }
        }
    }
    Ok(findings)
}

fn array(value: &serde_json::Value) -> &[serde_json::Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn against_direction(name: &str, target: &str) -> Option<String> {
    match MAY_USE.iter().find(|(layer, _)| *layer == name) {
        None => Some(format!("{name} has no place among the layers of tidy")),
        Some((_, may)) if may.contains(&target) => None,
        Some((_, [])) => {
            Some(format!("{name} depends on {target}, but may use no crate of the workspace"))
        }
        Some((_, may)) => {
            Some(format!("{name} depends on {target}, but may use only {}", may.join(", ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_planted_backward_dependency_is_found() {
        let table = [
            ("forward", "rotund-scene", "[dependencies]\nrotund-geometry", 0),
            ("backward", "rotund-image", "[dependencies]\nrotund-geometry", 1),
            ("of tests", "rotund-image", "[dev-dependencies]\nrotund-geometry", 1),
            ("of builds", "rotund-report", "[build-dependencies]\nrotund-geometry", 1),
            ("of a new crate", "rotund-extra", "[dependencies]\nrotund-geometry", 1),
        ];
        for (why, name, dependency, count) in table {
            let root = tempfile::tempdir().expect("a folder");
            let write = |path: &str, text: &str| {
                let path = root.path().join(path);
                fs::create_dir_all(path.parent().expect("a folder above")).expect("made");
                fs::write(path, text).expect("written");
            };
            write("Cargo.toml", "[workspace]\nmembers = [\"a\", \"b\"]\nresolver = \"3\"\n");
            let package =
                |name: &str| format!("[package]\nname = \"{name}\"\nversion = \"0.1.0\"\n");
            write("a/Cargo.toml", &package("rotund-geometry"));
            write("a/src/lib.rs", "");
            let path = " = { path = \"../a\" }\n";
            write("b/Cargo.toml", &[&package(name), dependency, path].concat());
            write("b/src/lib.rs", "");
            let found = check(root.path()).expect("cargo reads it");
            assert_eq!(found.len(), count, "{why}: {found:?}");
            assert!(found.iter().all(|finding| finding.contains(name)), "{why}: {found:?}");
        }
    }

    #[test]
    fn no_crate_may_use_one_that_is_listed_after_it() {
        let place = |name: &str| MAY_USE.iter().position(|(layer, _)| *layer == name);
        for (name, may) in MAY_USE {
            assert!(may.iter().all(|target| place(target) < place(name)), "{name}");
        }
    }
}
