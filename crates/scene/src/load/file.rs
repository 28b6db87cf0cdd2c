//! Access to the files that a scene names, on disk or in memory.

use super::error::{LoadError, LoadProblem, NamedBy};
use std::{
    borrow::Cow,
    fs::{self, File},
    io::{self, BufReader},
    path::{Component, Path, PathBuf},
};

/// The source of the content of files.
#[derive(Clone, Copy)]
pub(super) enum Files<'a> {
    /// The file system.
    Disk,
    /// A function from the path of a file to its content.
    Memory(&'a (dyn Fn(&str) -> Option<Cow<'a, [u8]>> + Sync)),
}

/// A file, and the field of the scene that names it.
#[derive(Clone, Debug)]
pub(super) struct NamedFile {
    pub path: PathBuf,
    pub named_by: Option<NamedBy>,
}

/// A file that is open for reading.
pub(super) enum Opened<'a> {
    /// A reader and the length of the file in bytes.
    Disk(BufReader<File>, u64),
    Memory(Cow<'a, [u8]>),
}

impl NamedFile {
    /// Creates a file that the caller of the loader names.
    pub(super) fn given(path: &Path) -> Self {
        Self { path: path.to_owned(), named_by: None }
    }

    /// Returns the error for a problem of this file.
    pub(super) fn fail(&self, problem: LoadProblem) -> LoadError {
        LoadError { named_by: self.named_by.clone(), ..problem.at(&self.path) }
    }

    /// Returns the extension in lower case.
    pub(super) fn extension(&self) -> String {
        extension(&self.path)
    }
}

impl<'a> Files<'a> {
    /// Opens a regular file. Any other is refused before it is opened, since opening a pipe waits
    /// for a writer.
    pub(super) fn open(&self, file: &NamedFile) -> Result<Opened<'a>, LoadError> {
        let failed = |error: io::Error| file.fail(LoadProblem::Read { error });
        match self {
            Self::Disk => {
                let kind = fs::metadata(&file.path).map_err(failed)?.file_type();
                if !kind.is_file() {
                    let what = if kind.is_dir() { "folder" } else { "pipe or device" };
                    return Err(file.fail(LoadProblem::NotAFile { what }));
                }
                let opened = File::open(&file.path).map_err(failed)?;
                let length = opened.metadata().map_err(failed)?.len();
                Ok(Opened::Disk(BufReader::with_capacity(1 << 16, opened), length))
            }
            Self::Memory(files) => match files(&slashed(&file.path)) {
                Some(bytes) => Ok(Opened::Memory(bytes)),
                None => Err(failed(io::Error::new(
                    io::ErrorKind::NotFound,
                    "not among the files in memory",
                ))),
            },
        }
    }

    /// Reads the whole of a regular file.
    pub(super) fn read(&self, file: &NamedFile) -> Result<Cow<'a, [u8]>, LoadError> {
        match self.open(file)? {
            Opened::Memory(bytes) => Ok(bytes),
            Opened::Disk(mut reader, length) => {
                let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
                match io::Read::read_to_end(&mut reader, &mut bytes) {
                    Ok(_) => Ok(Cow::Owned(bytes)),
                    Err(error) => Err(file.fail(LoadProblem::Read { error })),
                }
            }
        }
    }

    pub(super) fn is_file(&self, path: &Path) -> bool {
        match self {
            Self::Disk => path.is_file(),
            Self::Memory(files) => files(&slashed(path)).is_some(),
        }
    }

    pub(super) fn exists(&self, path: &Path) -> bool {
        match self {
            Self::Disk => path.exists(),
            Self::Memory(_) => self.is_file(path),
        }
    }

    /// Returns true if a path, relative to a folder, leads to a file outside of it. Files that do
    /// not exist are reported on opening.
    pub(super) fn leads_outside(&self, folder: &Path, uri: &str) -> bool {
        let stays = |component| matches!(component, Component::Normal(_) | Component::CurDir);
        if !Path::new(uri).components().all(stays) {
            return true;
        }
        if matches!(self, Self::Memory(_)) {
            return false;
        }
        // A symbolic link may lead out as well.
        let folder_or_dot = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        match (fs::canonicalize(folder_or_dot), fs::canonicalize(folder.join(uri))) {
            (Ok(folder), Ok(target)) => !target.starts_with(folder),
            _ => false,
        }
    }
}

/// Returns the extension in lower case.
pub(super) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Returns a path with `/` as the separator on all systems.
pub(super) fn slashed(path: &Path) -> String {
    path.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/")
}

/// Returns the content of a text file without the byte order mark of UTF-8; refuses UTF-16.
pub(super) fn text(bytes: &[u8]) -> Result<&[u8], LoadProblem> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(LoadProblem::Encoding);
    }
    Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// Returns the lines of a text, whatever ends them: a line feed, a carriage return and a line feed,
/// or a carriage return alone, as on old Macs.
pub(super) fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = rest.bytes().position(|byte| matches!(byte, b'\n' | b'\r'));
        let end = end.unwrap_or(rest.len());
        let (line, after) = rest.split_at(end);
        let terminator = if after.starts_with("\r\n") { 2 } else { after.len().min(1) };
        rest = &after[terminator..];
        Some(line)
    })
}
