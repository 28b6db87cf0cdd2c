//! Output files: checked before a long render, and written so that nobody sees half of one.

use anyhow::{Context, Result, bail};
use rotund_image::Format;
use std::io::Write as _;
use std::path::Path;

/// Creates `folder` if need be, and makes sure that files can be made in it.
///
/// # Errors
///
/// If the folder cannot be made or written to.
pub fn prepare_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    check_writable(folder)
}

/// Makes sure that an image file can be made under this name; returns its format.
pub(crate) fn check_image_file(path: &Path) -> Result<Format> {
    let Some(format) = Format::from_path(path) else {
        bail!("cannot write {}: images are {} files", path.display(), Format::EXTENSIONS);
    };
    check_file(path)?;
    Ok(format)
}

/// Makes sure that a file can be made under this name.
pub(crate) fn check_file(path: &Path) -> Result<()> {
    if path.is_dir() {
        bail!("cannot write {}: it is a folder", path.display());
    }
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => check_writable(parent),
        _ => check_writable(Path::new(".")),
    }
}

fn check_writable(folder: &Path) -> Result<()> {
    let file = tempfile::Builder::new().prefix(".rotund-").tempfile_in(folder);
    // The message has the error of the operating system alone: tempfile would add the random name.
    if let Err(error) = file {
        let reason = std::io::Error::from(error.kind());
        bail!("cannot write to the folder {}: {reason}", folder.display());
    }
    Ok(())
}

/// Writes a file of text.
///
/// # Errors
///
/// If the file cannot be written; one that exists is unchanged then.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    rotund_trace::output::write_with(path, |file| file.write_all(text.as_bytes()))?;
    Ok(())
}
