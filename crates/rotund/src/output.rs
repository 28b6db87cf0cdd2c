//! Output files: checked before a long render, and written so that nobody sees half of one.

use crate::cancel::survive_large_files;
use anyhow::{Context, Result, bail};
use rotund_image::Format;
use rotund_trace::output::{sweep, write_with};
use std::io::Write as _;
use std::path::{Path, PathBuf};

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
    if path.exists() && !path.is_file() {
        bail!("cannot write {}: it is not a regular file", path.display());
    }
    check_writable(&identity(path).parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf))
}

/// Makes sure that no two of the files that a command writes are one, and that none is a file that
/// it reads. Each output has the name of its option.
pub(crate) fn check_distinct(outputs: &[(&str, &Path)], inputs: &[PathBuf]) -> Result<()> {
    for (index, (option, path)) in outputs.iter().enumerate() {
        let file = identity(path);
        if let Some((other, _)) = outputs[..index].iter().find(|(_, path)| identity(path) == file) {
            bail!("{other} and {option} are both {}: give them different names", path.display());
        }
        // Only a file that exists can be one that is read.
        if path.exists() && inputs.iter().any(|input| identity(input) == file) {
            bail!("{option} would replace {}, which is read: give another name", path.display());
        }
    }
    Ok(())
}

/// Returns the one path of a file that may not exist yet: that which symbolic links lead to.
fn identity(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    // As many links as the file system follows; a circle ends anywhere.
    for _ in 0..40 {
        let Ok(link) = std::fs::read_link(&path) else { break };
        path = path.parent().unwrap_or(Path::new("")).join(link);
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    path.file_name().map_or_else(|| folder.clone(), |name| folder.join(name))
}

/// Makes sure that files can be made in a folder. What killed runs left in it is removed.
fn check_writable(folder: &Path) -> Result<()> {
    survive_large_files();
    sweep(folder);
    let file = tempfile::Builder::new().prefix(".rotund-").suffix(".part").tempfile_in(folder);
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
    write_with(path, |file| file.write_all(text.as_bytes()))?;
    Ok(())
}
