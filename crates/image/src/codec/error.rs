//! Why an image was not read or written.

use super::format::Format;
use std::error::Error;
use std::io;
use std::path::PathBuf;

/// Why bytes are not an image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
#[non_exhaustive]
pub struct DecodeError {
    /// The problem in words, with all its causes.
    pub problem: String,
}

/// Why an image has no encoding in a format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
#[non_exhaustive]
pub struct EncodeError {
    /// The problem in words, with all its causes.
    pub problem: String,
}

/// Why an image file was not read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum ReadError {
    #[error("cannot read {}", path.display())]
    Open { path: PathBuf, source: io::Error },
    #[error("{} cannot be read as an image", path.display())]
    Decode { path: PathBuf, source: DecodeError },
}

/// Why a file was not written. A file that stood at the path before is untouched.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum WriteError {
    #[error("cannot write {}: image files are named {}", path.display(), Format::EXTENSIONS)]
    UnknownFormat { path: PathBuf },
    #[error("cannot write {}: its folder cannot be written to", path.display())]
    Create { path: PathBuf, source: io::Error },
    #[error("cannot write {}", path.display())]
    Encode { path: PathBuf, source: Box<dyn Error + Send + Sync> },
}

/// Joins the lines of a message: libraries break some.
pub(super) fn one_line(message: &str) -> String {
    let lines: Vec<&str> = message.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    lines.join(" ")
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_message_is_one_line() {
        assert_eq!(super::one_line("no image:\n  too wide\n\n"), "no image: too wide");
        assert_eq!(super::one_line("too wide"), "too wide");
    }
}
