//! Why pictures were not compared or accepted, or differ.

use crate::check::Finding;
use rotund_image::{CompareError, EncodeError, WriteError};
use rotund_scene::{LoadError, SceneError};
use rotund_trace::RenderError;
use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a suite of golden pictures failed. The message names the picture or the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages and the names of the fields say it")]
pub enum GoldenError {
    /// The suite ran, and pictures differ from their references.
    #[error("{0}")]
    Failed(Failed),
    /// Pictures that cannot be references; the others were accepted.
    #[error("{0}")]
    Refused(Refused),
    #[error("a picture cannot be named {name:?}: its reference would not be a file of the folder")]
    Name { name: String },
    #[error("{first} and {second} would share the reference {name}.exr: rename one")]
    NameTaken { name: String, first: String, second: String },
    #[error("the suite of {} has no pictures: a check of nothing would always pass", folder.display())]
    NoPictures { folder: PathBuf },
    #[error("the resolution of the suite is 0, expected at least 1 pixel")]
    Resolution,
    #[error("{} has no scene files", folder.display())]
    NoScenes { folder: PathBuf },
    #[error(transparent)]
    Load(#[from] Box<LoadError>),
    #[error("the scene of picture {name:?} is not valid")]
    Scene { name: String, source: Box<SceneError> },
    #[error("the scene of picture {name:?} has no camera")]
    NoCamera { name: String },
    #[error("picture {name:?} cannot be rendered")]
    Render { name: String, source: Box<RenderError> },
    #[error("picture {name:?} cannot be compared")]
    Compare { name: String, source: CompareError },
    #[error("{} is not a reference picture: {problem}", path.display())]
    Reference { path: PathBuf, problem: String },
    #[error("cannot {action} {}", path.display())]
    Folder { action: &'static str, path: PathBuf, source: io::Error },
    #[error("cannot encode a picture for {}", path.display())]
    Page { path: PathBuf, source: EncodeError },
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Pictures that differ from their references. Both `Display` and `Debug` print a list for people,
/// so that a test that returns or unwraps the error shows it.
#[derive(Clone, PartialEq)]
pub struct Failed {
    /// Name of each picture that differs, and the checks that failed.
    pub pictures: Vec<(String, Vec<Finding>)>,
    /// Problems that are no difference: a picture without a reference, a reference without a
    /// picture.
    pub complaints: Vec<String>,
    /// Number of pictures of the suite.
    pub count: usize,
    /// The page that shows what differs, if there is a difference to show.
    pub page: Option<PathBuf>,
}

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "golden pictures: {} of {} differ", self.pictures.len(), self.count)?;
        for (name, findings) in &self.pictures {
            for finding in findings {
                write!(f, "\n  {name}: {finding}")?;
            }
        }
        for complaint in &self.complaints {
            write!(f, "\n  {complaint}")?;
        }
        if let Some(page) = &self.page {
            write!(f, "\nThe page {} shows the differences.", page.display())?;
        }
        write!(f, "\nIf the change is intended, accept it by {}=1.", crate::BLESS_VARIABLE)
    }
}

impl fmt::Debug for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Pictures that cannot be references, with the reasons. `Debug` prints the same list as `Display`.
#[derive(Clone, PartialEq, Eq)]
pub struct Refused {
    /// Name of each picture, and why it was refused. Its reference is as before.
    pub pictures: Vec<(String, String)>,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("refused as golden pictures; their references are as before:")?;
        self.pictures.iter().try_for_each(|(name, reason)| write!(f, "\n  {name}: {reason}"))
    }
}

impl fmt::Debug for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}
