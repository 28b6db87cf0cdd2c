//! Files that are replaced as a whole, so that nobody sees half of one.

use super::error::WriteError;
use std::error::Error;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Start and end of the name of a file that is being written.
const PREFIX: &str = ".rotund-";
const SUFFIX: &str = ".part";
/// Symbolic links that are followed, as by Linux.
const MOST_LINKS: usize = 40;

/// Writes a file under a temporary name in the same folder and renames it when it is complete, so
/// that a reader sees the old content or the new, and a failure leaves nothing behind. `encode`
/// writes the content; files of any kind can be written this way.
///
/// A symbolic link is followed, and the mode of a file that exists is kept.
///
/// # Errors
///
/// If the folder cannot be written to, the path leads to something else than a regular file, or
/// `encode` fails.
pub fn write_with<E: Into<Box<dyn Error + Send + Sync>>>(
    path: impl AsRef<Path>,
    encode: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<(), WriteError> {
    let path = path.as_ref();
    let create = |source| WriteError::Create { path: path.into(), source };
    let encode_error = |source| WriteError::Encode { path: path.into(), source };
    let target = follow(path).map_err(|error| encode_error(error.into()))?;
    let existing = fs::metadata(&target).ok();
    if existing.as_ref().is_some_and(|existing| !existing.is_file()) {
        return Err(encode_error("it is not a regular file".into()));
    }
    let temporary = temporary_in(folder_of(&target)).map_err(create)?;
    {
        let mut buffer = BufWriter::new(temporary.as_file());
        encode(&mut buffer).map_err(|e| encode_error(e.into()))?;
        buffer.flush().map_err(|e| encode_error(e.into()))?;
    }
    if let Some(existing) = existing {
        // Some file systems have no modes; the content is worth more than they are.
        let _ = temporary.as_file().set_permissions(existing.permissions());
    }
    temporary.as_file().sync_all().map_err(|e| encode_error(e.into()))?;
    temporary.persist(&target).map_err(|e| encode_error(e.error.into()))?;
    Ok(())
}

/// Removes what killed processes left in a folder while they wrote files with [`write_with`]. Files
/// of running processes, on this machine or another, are locked and stay.
pub fn sweep(folder: impl AsRef<Path>) {
    // What cannot be read or removed here stays: it does no harm.
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        let ours = name.starts_with(PREFIX.as_bytes()) && name.ends_with(SUFFIX.as_bytes());
        if ours && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            let file = File::open(entry.path());
            if file.is_ok_and(|file| file.try_lock().is_ok()) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Returns the folder that a file is in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Returns the path that symbolic links lead to from `path`, whether there is a file or not.
fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(link) = fs::read_link(&path) else { return Ok(path) };
        path = folder_of(&path).join(link);
    }
    Err(io::Error::other("it is a circle of symbolic links"))
}

/// Creates a temporary file, locked so that [`sweep`] in another process lets it live.
fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    // A temporary file is readable by its owner alone by default; an image gets the usual
    // permissions.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        // The error of the system alone: tempfile would add the random name.
        let temporary =
            builder.tempfile_in(folder).map_err(|error| io::Error::from(error.kind()))?;
        match temporary.as_file().try_lock() {
            // Swept between its creation and the lock: once more.
            Ok(()) if !temporary.path().exists() => {}
            Err(TryLockError::WouldBlock) => {}
            // A file system without locks can have no sweep either.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(temporary),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn write(path: &Path, text: &str) -> Result<(), WriteError> {
        write_with(path, |file| file.write_all(text.as_bytes()))
    }

    #[test]
    fn what_a_killed_process_left_is_swept_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        // A process that is killed leaves a file that nobody has locked.
        fs::write(folder.path().join(".rotund-dead00.part"), "half").expect("a file");
        fs::write(folder.path().join(".rotund-notes"), "kept").expect("a file");
        fs::write(folder.path().join("b.part"), "kept").expect("a file");
        write_with(&path, |file| {
            sweep(folder.path());
            file.write_all(b"whole")
        })
        .expect("it is written");
        assert_eq!(fs::read_to_string(&path).expect("a file"), "whole");
        assert_eq!(names(folder.path()), [".rotund-notes", "a.txt", "b.part"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_modes_kept() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let [far, near] = ["far", "near"].map(|name| folder.path().join(name));
        fs::create_dir(&far).expect("a folder");
        fs::create_dir(&near).expect("a folder");
        let (real, link) = (far.join("real.txt"), near.join("link.txt"));
        fs::write(&real, "old").expect("a file");
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).expect("a mode");
        symlink("../far/real.txt", &link).expect("a link");
        write(&link, "new").expect("it is written");
        assert_eq!(fs::read_to_string(&real).expect("a file"), "new");
        let mode = fs::metadata(&real).expect("a file").permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        assert!(fs::symlink_metadata(&link).expect("a link").is_symlink());

        // A link to a file that is not there yet, and a circle.
        let dangling = near.join("dangling.txt");
        symlink("../far/later.txt", &dangling).expect("a link");
        write(&dangling, "first").expect("it is written");
        assert_eq!(fs::read_to_string(far.join("later.txt")).expect("a file"), "first");
        symlink("circle.txt", near.join("circle.txt")).expect("a link");
        assert!(write(&near.join("circle.txt"), "no").is_err());
        assert!(write(Path::new("/dev/null"), "no").is_err(), "it must stay a device");
    }
}
