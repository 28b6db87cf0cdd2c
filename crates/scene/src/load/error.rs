//! Why a file was refused, in words that help to mend it.

use std::{io, path::PathBuf};

/// Why a scene, or a file that it names, was refused.
///
/// `path` is the file to look at, `field` a path inside a scene file as in `instances[3].shape`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages and the names of the fields say it")]
pub enum LoadError {
    /// `named_by` says who asked for the file; empty if the caller did.
    #[error("cannot read {}{named_by}: {source}", path.display())]
    Read { path: PathBuf, named_by: NamedBy, source: io::Error },
    #[error("{}{named_by} is a {what}, not a file", path.display())]
    NotAFile { path: PathBuf, named_by: NamedBy, what: &'static str },
    #[error("{}{named_by}: files that end in {extension:?} are not supported, only {supported}", path.display())]
    Unsupported { path: PathBuf, named_by: NamedBy, extension: String, supported: &'static str },
    /// Not JSON, or a field of another type than expected; the source says what and where.
    #[error("{}: {}{}", path.display(), field_prefix(field), plain(field, source))]
    Json { path: PathBuf, field: String, source: serde_json::Error },
    #[error("{}: {field} is {value}, expected {expected}", path.display())]
    Value { path: PathBuf, field: String, value: String, expected: &'static str },
    #[error("{}: {field} is {value}, but the scene has {count} {what}", path.display())]
    IndexOutOfRange { path: PathBuf, field: String, value: i64, what: &'static str, count: usize },
    #[error("{}: {field} names {name:?}, which is not among the {what}{}", path.display(), nor_a_file(what, name))]
    UnknownName { path: PathBuf, field: String, name: String, what: &'static str },
    #[error(
        "{}: {field} is {uri:?}, which leads out of the folder of the scene; allow it explicitly if you trust the file",
        path.display()
    )]
    OutsideFolder { path: PathBuf, field: String, uri: String },
    #[error("{}: line {line} of the header: {problem}", path.display())]
    PlyHeader { path: PathBuf, line: usize, problem: String },
    #[error("{}: line {line}: {problem}", path.display())]
    ObjLine { path: PathBuf, line: usize, problem: String },
    #[error("{}: the file ends before {element} {index} of {count}", path.display())]
    Truncated { path: PathBuf, element: String, index: u64, count: u64 },
    #[error("{}: {element} {index}: {property} is {value}, expected {expected}", path.display())]
    ElementValue {
        path: PathBuf,
        element: String,
        index: u64,
        property: String,
        value: String,
        expected: &'static str,
    },
    #[error("{}: {element} {index} names vertex {vertex}, but there are {count} vertices", path.display())]
    VertexOutOfRange { path: PathBuf, element: String, index: u64, vertex: i64, count: usize },
    #[error("{}: has {first} and {second} in one shape; split it into one file for each kind", path.display())]
    MixedElements { path: PathBuf, first: &'static str, second: &'static str },
    #[error("{}: has no points, lines or faces", path.display())]
    EmptyShape { path: PathBuf },
    #[error("{}: has {count} {what}, more than the {limit} that are supported", path.display())]
    TooMany { path: PathBuf, what: &'static str, count: u64, limit: u64 },
    #[error("{}: is UTF-16, expected UTF-8; save it in that encoding", path.display())]
    Encoding { path: PathBuf },
    #[error("{}: {problem}", path.display())]
    Image { path: PathBuf, problem: String },
}

/// Which field of which file names a path; prints nothing for a path that the caller gave.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NamedBy(pub Option<(PathBuf, String)>);

impl std::fmt::Display for NamedBy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.0 {
            Some((path, field)) => write!(f, " (named by {field} of {})", path.display()),
            None => Ok(()),
        }
    }
}

/// `serde_path_to_error` calls the root `.`, which helps nobody.
fn field_prefix(field: &str) -> String {
    if field.is_empty() || field == "." { String::new() } else { format!("{field}: ") }
}

/// What a name may mean beside an item of the scene file.
fn nor_a_file(what: &str, name: &str) -> String {
    let extensions = match what {
        "shapes" => "ply or .obj",
        "textures" => "hdr, .exr, .png or .jpg",
        _ => return String::new(),
    };
    format!(", nor is there a file {what}/{name}.{extensions}")
}

/// What serde says, without names of Rust's types.
fn plain(field: &str, source: &serde_json::Error) -> String {
    let words = [
        ("expected f32", "expected a number"),
        ("expected u32", "expected an integer from 0 to 4294967295"),
        ("expected value at", "expected a value of another kind at"),
    ];
    let text = words.iter().fold(source.to_string(), |text, (from, to)| text.replace(from, to));
    // Inside the file these follow a value that could have ended.
    if field.is_empty() { text } else { text.replace("trailing characters", "too many items") }
}
