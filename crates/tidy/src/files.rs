//! The files of the workspace.

use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Reads every text file below `root`; paths are relative to it.
pub(crate) fn text_files(root: &Path) -> Result<Vec<(PathBuf, String)>> {
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

/// Lists all files below a folder in order, without those of cargo and git and the output of
/// commands.
pub(crate) fn walk(folder: &Path) -> Result<Vec<PathBuf>> {
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
