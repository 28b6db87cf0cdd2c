//! `tidy`: what no compiler checks. Reads the workspace, prints every finding, fails if there is one.
//!
//! - A crate depends only on crates that stand to its left in [`LAYERS`].
//! - A source file has at most [`MOST_LINES`] lines, `ARCHITECTURE.md` at most [`MOST_LINES_OF_MAP`].
//! - Unsafe code, files, arguments, JSON stay where `ARCHITECTURE.md` puts them.
//! - Nothing unfinished, switched off or of one machine is left behind.
//! - Every scene loads without a warning, is mentioned where people find it, and every file beside
//!   the scenes belongs to one.

use crate::workspace;
use anyhow::{Context, Result, bail, ensure};
use rotund_report::console::say;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

mod places;
mod scenes;

/// The direction of dependencies.
const LAYERS: [&str; 11] = [
    "rotund-geometry",
    "rotund-bvh",
    "rotund-image",
    "rotund-scene",
    "rotund-trace",
    "rotund-report",
    "rotund-golden",
    "rotund",
    "rotund-study",
    "xtask",
    "rotund-tests",
];
/// Who passes this has two concepts in one file.
const MOST_LINES: usize = 500;
/// A map of the code is to be read in one go.
const MOST_LINES_OF_MAP: usize = 150;

/// What is not to stay, and why. Each is in two pieces, so that this list does not find itself.
const LEFTOVERS: [(&str, &str, &str); 12] = [
    ("to", "do!(", "is unfinished"),
    ("unimplement", "ed!(", "is unfinished"),
    ("TO", "DO", "is unfinished"),
    ("FIX", "ME", "is unfinished"),
    ("db", "g!(", "is for debugging"),
    ("#[ign", "ore", "is a test that does not run"),
    ("<<<<", "<<<", "is half a merge"),
    (">>>>", ">>>", "is half a merge"),
    ("/ho", "me/", "is a path of one machine"),
    ("/Us", "ers/", "is a path of one machine"),
    ("/wo", "rk/", "is a path of one machine"),
    ("C:", "\\", "is a path of one machine"),
];

/// Options of `tidy`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_: Args) -> Result<()> {
    let root = workspace::root();
    let mut findings = crate_direction(&root)?;
    let files = text_files(&root)?;
    for (path, text) in &files {
        findings.extend(check_text(path, text));
        findings.extend(places::check(path, text));
    }
    findings.extend(scenes::check(&root, &files)?);
    for finding in &findings {
        say(finding)?;
    }
    match findings.len() {
        0 => say(format!("{} files are tidy", files.len())),
        1 => bail!("1 thing is not tidy"),
        count => bail!("{count} things are not tidy"),
    }
}

/// Dependencies of the workspace that run against the direction, development ones included.
fn crate_direction(root: &Path) -> Result<Vec<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(root)
        .output()
        .context("cannot run cargo metadata")?;
    let complaint = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "cargo metadata failed: {complaint}");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let mut edges = Vec::new();
    for package in array(&metadata["packages"]) {
        let name = package["name"].as_str().unwrap_or_default();
        for dependency in array(&package["dependencies"]) {
            // What has a path is of the workspace.
            if dependency["path"].is_string() {
                let target = dependency["name"].as_str().unwrap_or_default();
                edges.push((name.to_owned(), target.to_owned()));
            }
        }
    }
    ensure!(!edges.is_empty(), "cargo metadata lists no dependencies within the workspace");
    Ok(against_direction(&edges))
}

fn array(value: &serde_json::Value) -> &[serde_json::Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn against_direction(edges: &[(String, String)]) -> Vec<String> {
    let layer = |name: &str| LAYERS.iter().position(|layer| *layer == name);
    let wrong = |(name, target): &&(String, String)| match (layer(name), layer(target)) {
        (Some(from), Some(to)) => to >= from,
        _ => true,
    };
    let text = |(name, target): &(String, String)| {
        format!("{name} depends on {target}, but the direction is {}", LAYERS.join(" <- "))
    };
    edges.iter().filter(wrong).map(text).collect()
}

/// Sizes and leftovers of one file.
fn check_text(path: &Path, text: &str) -> Vec<String> {
    let mut findings = Vec::new();
    let lines = text.lines().count();
    let most = match path.extension().and_then(|extension| extension.to_str()) {
        Some("rs") => MOST_LINES,
        _ if path.ends_with("ARCHITECTURE.md") => MOST_LINES_OF_MAP,
        _ => usize::MAX,
    };
    if lines > most {
        findings.push(format!("{}: {lines} lines, {most} are the most", path.display()));
    }
    for (number, line) in text.lines().enumerate() {
        for (start, end, why) in LEFTOVERS {
            let leftover = format!("{start}{end}");
            if line.contains(&leftover) {
                findings.push(format!("{}:{}: {leftover} {why}", path.display(), number + 1));
            }
        }
    }
    findings
}

/// Every text file of the workspace, its path relative to the root.
fn text_files(root: &Path) -> Result<Vec<(PathBuf, String)>> {
    let extensions = ["rs", "toml", "md", "json", "yml", "yaml", "html", "css", "js", "sh"];
    let mut files = Vec::new();
    for path in walk(root)? {
        let is_text = path
            .extension()
            .and_then(|extension| extension.to_str())
            .is_some_and(|extension| extensions.contains(&extension));
        if is_text {
            let text = fs::read_to_string(&path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            files.push((path.strip_prefix(root)?.to_owned(), text));
        }
    }
    Ok(files)
}

/// All files in a folder, in order, but what cargo and git keep there and what commands write.
fn walk(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let entries =
        fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_file() {
            files.push(path);
        } else if path.is_dir() && !["target", "out", ".git", "corpus"].contains(&name.as_str()) {
            files.extend(walk(&path)?);
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(from: &str, to: &str) -> (String, String) {
        (from.to_owned(), to.to_owned())
    }

    #[test]
    fn a_dependency_to_the_right_is_found() {
        let table = [
            ("to the left", edge("rotund-scene", "rotund-geometry"), 0),
            ("to the right", edge("rotund-geometry", "rotund-scene"), 1),
            ("on itself", edge("rotund-bvh", "rotund-bvh"), 1),
            ("on a crate without a place", edge("rotund-trace", "rotund-extra"), 1),
        ];
        for (why, edge, count) in table {
            assert_eq!(against_direction(&[edge]).len(), count, "{why}");
        }
    }

    #[test]
    fn leftovers_and_long_files_are_found_with_their_lines() {
        let marker = ["to", "do!("].concat();
        let found = check_text(Path::new("a.rs"), &format!("fn a() {{\n    {marker})\n}}\n"));
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("a.rs:2: "), "{found:?}");
        assert!(check_text(Path::new("a.rs"), &"\n".repeat(500)).is_empty());
        assert_eq!(check_text(Path::new("a.rs"), &"\n".repeat(501)).len(), 1);
        assert!(check_text(Path::new("a.json"), &"\n".repeat(501)).is_empty());
        assert_eq!(check_text(Path::new("ARCHITECTURE.md"), &"\n".repeat(151)).len(), 1);
    }
}
