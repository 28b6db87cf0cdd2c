//! Errors of loading: the file, the field that names it, and the problem.

use crate::SceneError;
use std::{error::Error, fmt, io, path::Path, path::PathBuf};

/// Why a scene cannot be loaded.
///
/// The message is complete, so [`Error::source`] is `None`.
#[derive(Debug)]
pub struct LoadError {
    /// The file that has the problem.
    pub path: PathBuf,
    /// The field that names the file; `None` for the path that the caller gave.
    pub named_by: Option<NamedBy>,
    /// The problem of the file.
    pub problem: Box<LoadProblem>,
}

/// A field of a scene file that names another file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedBy {
    /// The scene file.
    pub scene: PathBuf,
    /// Path of the field in it, as in `shapes[3].uri`.
    pub field: String,
}

/// The problem of a file. `field` is a path inside a scene file, as in `instances[3].shape`.
#[derive(Debug)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages and the names of the fields say it")]
pub enum LoadProblem {
    Read {
        error: io::Error,
    },
    NotAFile {
        what: &'static str,
    },
    Unsupported {
        extension: String,
        supported: &'static str,
    },
    /// Not JSON, or a field of another type than expected; the error has the position.
    Json {
        field: String,
        error: serde_json::Error,
    },
    Value {
        field: String,
        value: String,
        expected: &'static str,
    },
    IndexOutOfRange {
        field: String,
        value: i64,
        what: &'static str,
        count: usize,
    },
    UnknownName {
        field: String,
        name: String,
        what: &'static str,
    },
    OutsideFolder {
        field: String,
        uri: String,
    },
    NotPly,
    PlyHeader {
        line: usize,
        problem: String,
    },
    ObjLine {
        line: usize,
        problem: String,
    },
    SwcLine {
        line: usize,
        problem: String,
    },
    /// A line of points as text.
    PointsLine {
        line: usize,
        problem: String,
    },
    /// The header of a file of streamlines, TCK or TRK.
    TracksHeader {
        problem: String,
    },
    Streamline {
        index: u64,
        problem: String,
    },
    Truncated {
        element: String,
        index: u64,
        count: u64,
    },
    ElementValue {
        element: String,
        index: u64,
        property: String,
        value: String,
        expected: &'static str,
    },
    VertexOutOfRange {
        element: String,
        index: u64,
        vertex: i64,
        count: usize,
    },
    EmptyShape,
    TooMany {
        what: &'static str,
        count: u64,
        limit: u64,
    },
    Encoding,
    Image {
        problem: String,
    },
    /// The result of a generator or subdivision is not valid, because its parameters are too large.
    Scene {
        error: SceneError,
    },
}

impl LoadProblem {
    /// Returns the error for this problem of a file that the caller named.
    pub(super) fn at(self, path: &Path) -> LoadError {
        LoadError { path: path.to_owned(), named_by: None, problem: Box::new(self) }
    }
}

impl Error for LoadError {}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.path {
            empty if empty.as_os_str().is_empty() => f.write_str("\"\"")?,
            path => write!(f, "{}", path.display())?,
        }
        if let Some(NamedBy { scene, field }) = &self.named_by {
            write!(f, " (named by {field} of {})", scene.display())?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl fmt::Display for LoadProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { error } => write!(f, "cannot be read: {error}"),
            Self::NotAFile { what } => write!(f, "is a {what}, not a file"),
            Self::Unsupported { extension, supported } => {
                write!(f, "files that end in {extension:?} are not supported, only {supported}")
            }
            Self::Json { field, error } => f.write_str(&json_error(field, error)),
            Self::Value { field, value, expected } => {
                write!(f, "{field} is {value}, expected {expected}")
            }
            Self::IndexOutOfRange { field, value, what, count } => {
                write!(f, "{field} is {value}, but the scene has {count} {what}")
            }
            Self::UnknownName { field, name, what } => {
                write!(f, "{field} names {name:?}, which is not among the {what}")?;
                let extensions = match *what {
                    "shapes" => "ply or .obj",
                    "textures" => "hdr, .exr, .png or .jpg",
                    _ => return Ok(()),
                };
                write!(f, ", nor is there a file {what}/{name}.{extensions}")
            }
            Self::OutsideFolder { field, uri } => write!(
                f,
                "{field} is {uri:?}, which leads out of the folder of the scene; \
                 allow it explicitly if you trust the file"
            ),
            Self::NotPly => f.write_str("is not a PLY file: it does not start with a line `ply`"),
            Self::PlyHeader { line, problem } => write!(f, "line {line} of the header: {problem}"),
            Self::ObjLine { line, problem }
            | Self::SwcLine { line, problem }
            | Self::PointsLine { line, problem } => {
                write!(f, "line {line}: {problem}")
            }
            Self::TracksHeader { problem } => write!(f, "header: {problem}"),
            Self::Streamline { index, problem } => write!(f, "streamline {index}: {problem}"),
            Self::Truncated { element, index, count } => {
                write!(f, "the file ends before {element} {index} of {count}")
            }
            Self::ElementValue { element, index, property, value, expected } => {
                write!(f, "{element} {index}: {property} is {value}, expected {expected}")
            }
            Self::VertexOutOfRange { element, index, vertex, count } => {
                write!(f, "{element} {index} names vertex {vertex}, but there are {count} vertices")
            }
            Self::EmptyShape => f.write_str("has no points, lines or faces"),
            Self::TooMany { what, count, limit } => {
                write!(f, "has {count} {what}, more than the {limit} that are supported")
            }
            Self::Encoding => f.write_str("is UTF-16, expected UTF-8; save it in that encoding"),
            Self::Image { problem } => f.write_str(problem),
            Self::Scene { error } => error.fmt(f),
        }
    }
}

/// Returns the field and the message of serde_json, without the names of Rust's types.
fn json_error(field: &str, error: &serde_json::Error) -> String {
    let syntax = matches!(error.classify(), serde_json::error::Category::Syntax);
    // The path of a key that is none is `?`.
    if syntax && matches!(field, "." | "?") && !error.to_string().starts_with("trailing characters")
    {
        let text = error.to_string().replace("expected value at", "expected a value at");
        return format!("is not JSON: {text}");
    }
    let words = [
        ("expected f32", "expected a number"),
        ("expected u32", "expected an integer from 0 to 4294967295"),
        ("expected value at", "expected a value of another kind at"),
    ];
    let text = words.iter().fold(error.to_string(), |text, (from, to)| text.replace(from, to));
    match field {
        "" => text,
        // `serde_path_to_error` calls the root `.`. Inside the file, "trailing characters" follow
        // an array of fixed length.
        "." => text.replace("trailing characters", "too many items"),
        _ => format!("{field}: {}", text.replace("trailing characters", "too many items")),
    }
}
