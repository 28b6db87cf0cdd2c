//! `tidy`: what no compiler checks. Reads the workspace, prints every finding, fails if there is one.
//!
//! - A crate depends only on the crates that [`layers`] lists for it.
//! - `xtask` has no formula of intersection or shading ([`formulas`]).
//! - Unsafe code, files, arguments and JSON stay where `ARCHITECTURE.md` puts them ([`places`]).
//! - Files and lines are short, and nothing unfinished, switched off or of one machine is left
//!   behind ([`texts`]).
//! - Every scene loads without a warning, is mentioned where people find it, and every file beside
//!   the scenes belongs to one ([`scenes`]).

use crate::workspace;
use anyhow::{Context, Result, bail};
use rotund_report::console::say;
use std::fs;
use std::path::{Path, PathBuf};

#[cfg(test)]
mod circles;
mod formulas;
mod layers;
#[cfg(test)]
mod modules;
mod places;
mod scenes;
mod source;
mod texts;

/// Options of `tidy`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_: Args) -> Result<()> {
    let root = workspace::root();
    let files = text_files(&root)?;
    let mut findings = layers::check(&root)?;
    for (path, text) in &files {
        findings.extend(texts::check(path, text));
        findings.extend(places::check(path, text));
        findings.extend(formulas::check(path, text)?);
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
