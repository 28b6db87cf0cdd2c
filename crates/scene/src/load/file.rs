//! Files that a scene names: which may be opened, and how.

use super::error::NamedBy;
use crate::LoadError;
use std::{
    fs::{self, File},
    io,
    path::{Component, Path, PathBuf},
};

/// The file that `uri`, in `field` of the scene at `scene`, means: relative to the scene's folder,
/// and not outside it unless that is allowed.
pub(super) fn resolve(
    scene: &Path,
    field: &str,
    uri: &str,
    allow_outside: bool,
) -> Result<PathBuf, LoadError> {
    let outside = || LoadError::OutsideFolder {
        path: scene.to_owned(),
        field: field.to_owned(),
        uri: uri.to_owned(),
    };
    let folder = scene.parent().unwrap_or(Path::new(""));
    let path = folder.join(uri);
    if allow_outside {
        return Ok(path);
    }
    let stays = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    if !Path::new(uri).components().all(stays) {
        return Err(outside());
    }
    // A link may lead out as well. What does not exist is found out when it is opened.
    if let (Ok(folder), Ok(target)) = (fs::canonicalize(or_dot(folder)), fs::canonicalize(&path))
        && !target.starts_with(folder)
    {
        return Err(outside());
    }
    Ok(path)
}

/// Opens a regular file and tells its length. Anything else is refused before it is opened, for to
/// open a pipe is to wait for its writer.
pub(super) fn open(path: &Path, named_by: &NamedBy) -> Result<(File, u64), LoadError> {
    let failed = |source: io::Error| LoadError::Read {
        path: path.to_owned(),
        named_by: named_by.clone(),
        source,
    };
    let kind = fs::metadata(path).map_err(failed)?.file_type();
    if !kind.is_file() {
        let what = if kind.is_dir() { "folder" } else { "pipe or device" };
        return Err(LoadError::NotAFile {
            path: path.to_owned(),
            named_by: named_by.clone(),
            what,
        });
    }
    let file = File::open(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    Ok((file, length))
}

/// The whole of a regular file.
pub(super) fn read(path: &Path, named_by: &NamedBy) -> Result<Vec<u8>, LoadError> {
    let (mut file, length) = open(path, named_by)?;
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    match io::Read::read_to_end(&mut file, &mut bytes) {
        Ok(_) => Ok(bytes),
        Err(source) => {
            Err(LoadError::Read { path: path.to_owned(), named_by: named_by.clone(), source })
        }
    }
}

/// The extension in lower case.
pub(super) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn or_dot(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// The content of a text file without the mark that some editors put before UTF-8; an error if the mark is that of
/// UTF-16.
pub(super) fn text<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8], LoadError> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(LoadError::Encoding { path: path.to_owned() });
    }
    Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}
