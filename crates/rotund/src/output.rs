//! Where results go: checked before the work, written so that no half of a file can be seen.

use anyhow::{Context, Result, bail};
use std::io::Write as _;
use std::path::Path;

/// Makes sure that files can be made in `folder`, which is created if need be.
pub fn prepare_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    check_writable(folder)
}

/// Makes sure that an image file can be made under this name.
pub fn check_image_file(path: &Path) -> Result<()> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if !["png", "exr", "hdr"].contains(&extension.as_str()) {
        bail!("cannot write {}: an image is named *.png, *.exr or *.hdr", path.display());
    }
    check_file(path)
}

/// Makes sure that a file can be made under this name.
pub fn check_file(path: &Path) -> Result<()> {
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
    // The error of the operating system, without the random name of the file.
    if let Err(error) = file {
        let reason = std::io::Error::from(error.kind());
        bail!("cannot write to the folder {}: {reason}", folder.display());
    }
    Ok(())
}

/// Writes a file of text.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    rotund_trace::output::write_with(path, |file| file.write_all(text.as_bytes()))?;
    Ok(())
}
