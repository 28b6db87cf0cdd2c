//! Checks of the workspace that no compiler makes, for `cargo xtask tidy` and the tests.
//!
//! - A crate depends only on the crates that [`layers`] lists for it.
//! - No two files of a crate name each other, directly or round a circle ([`circles`]).
//! - `xtask` has no formula of intersection or shading ([`formulas`]).
//! - Unsafe code, files, arguments and JSON stay where `ARCHITECTURE.md` puts them ([`places`]).
//! - Files and lines are short, and nothing unfinished, switched off or of one machine is left
//!   behind ([`texts`]).
//! - Every scene loads without a warning, is mentioned where people find it, and every file beside
//!   the scenes belongs to one ([`scenes`]).

use anyhow::Result;
use std::path::Path;

mod circles;
mod files;
mod formulas;
mod layers;
mod modules;
mod places;
mod scenes;
mod source;
mod texts;

/// The result of [`check`].
#[derive(Clone, Debug)]
pub struct Checked {
    /// How many text files the workspace has.
    pub files: usize,
    /// One sentence each, with the place.
    pub findings: Vec<String>,
}

/// Checks the workspace in the folder `root`.
///
/// # Errors
///
/// If a file cannot be read or is not Rust, or cargo does not understand the workspace.
pub fn check(root: &Path) -> Result<Checked> {
    let files = files::text_files(root)?;
    let mut findings = layers::check(root)?;
    findings.extend(circles::check(&files)?);
    for (path, text) in &files {
        findings.extend(texts::check(path, text));
        findings.extend(places::check(path, text));
        findings.extend(formulas::check(path, text)?);
    }
    findings.extend(scenes::check(root, &files)?);
    Ok(Checked { files: files.len(), findings })
}
