//! Errors of scenes.

use crate::ElementKind;
use std::{error::Error, fmt};

/// Why a scene is not valid, or trees or lights do not fit it: names the item, the element or
/// vertex, and the value.
///
/// The message is complete, so [`Error::source`] is `None`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages and the names of the fields say it")]
pub enum SceneError {
    /// A reference to an item that the scene does not have.
    IndexOutOfRange {
        item: SceneItem,
        field: &'static str,
        index: u32,
        what: &'static str,
        count: usize,
    },
    /// A number outside of its range, or a frame without an inverse.
    Value { item: SceneItem, field: &'static str, value: String, expected: &'static str },
    /// A vertex array that is neither empty nor as long as the positions.
    ArrayLength { shape: SceneItem, array: &'static str, length: usize, positions: usize },
    /// Points or lines without radii.
    MissingRadii { shape: SceneItem, kind: ElementKind },
    /// More points than positions: point `i` is vertex `i`.
    MissingPositions { shape: SceneItem, points: u32, positions: usize },
    /// An element names a vertex that its shape does not have.
    VertexOutOfRange {
        shape: SceneItem,
        kind: ElementKind,
        element: usize,
        vertex: u32,
        positions: usize,
    },
    /// A position, normal, texture coordinate, colour or radius that is outside of its domain.
    VertexValue {
        shape: SceneItem,
        array: &'static str,
        vertex: usize,
        value: String,
        expected: &'static str,
    },
    /// The number of pixels is not width times height.
    PixelCount { texture: SceneItem, width: u32, height: u32, pixels: usize },
    /// A pixel that is not finite, or negative in a texture of emission.
    PixelValue { texture: SceneItem, x: usize, y: usize, value: String, expected: &'static str },
    /// Not four bytes for each pixel of a texture.
    ByteCount { width: u32, height: u32, bytes: usize },
    /// More elements than a tree holds.
    TooMany { shape: SceneItem, kind: ElementKind, count: usize, limit: usize },
    /// Refitting is impossible: the scene does not have as many items or elements as the one that
    /// the trees were built from.
    Changed { item: Option<SceneItem>, what: &'static str, before: usize, now: usize },
    /// As [`Self::Changed`], of the lights that a renderer built from a scene rather than the
    /// trees.
    LightsChanged { item: Option<SceneItem>, what: &'static str, before: usize, now: usize },
}

/// An item of a scene, for messages: prints as in `shapes[3] "hair"`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneItem {
    /// The field of [`crate::Scene`] that holds the item, as in `"shapes"`.
    pub array: &'static str,
    /// Index of the item in that field.
    pub index: usize,
    /// Name of the item; may be empty.
    pub name: String,
}

impl fmt::Display for SceneItem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { array, index, name } = self;
        write!(f, "{array}[{index}]")?;
        if name.is_empty() { Ok(()) } else { write!(f, " {name:?}") }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IndexOutOfRange { item, field, index, what, count } => {
                write!(f, "{item}: {field} is {index}, but the scene has {count} {what}")
            }
            Self::Value { item, field, value, expected } => {
                write!(f, "{item}: {field} is {value}, expected {expected}")
            }
            Self::ArrayLength { shape, array, length, positions } => {
                write!(f, "{shape}: {array} has {length} values for {positions} positions")
            }
            Self::MissingRadii { shape, kind } => {
                write!(f, "{shape}: radii is empty, but {kind} need one for each position")
            }
            Self::MissingPositions { shape, points, positions } => {
                write!(f, "{shape}: has {points} points, but only {positions} positions")
            }
            Self::VertexOutOfRange { shape, kind, element, vertex, positions } => {
                write!(f, "{shape}: {kind}[{element}] names vertex {vertex}, but the shape has ")?;
                write!(f, "{positions} positions")
            }
            Self::VertexValue { shape, array, vertex, value, expected } => {
                write!(f, "{shape}: {array}[{vertex}] is {value}, expected {expected}")
            }
            Self::PixelCount { texture, width, height, pixels } => {
                write!(f, "{texture}: is {width} x {height}, but has {pixels} pixels")
            }
            Self::PixelValue { texture, x, y, value, expected } => {
                write!(f, "{texture}: pixel ({x}, {y}) is {value}, expected {expected}")
            }
            Self::ByteCount { width, height, bytes } => {
                let expected = 4 * u128::from(*width) * u128::from(*height);
                write!(f, "a texture of {width} x {height} pixels needs {expected} bytes, ")?;
                write!(f, "four for each pixel, and not {bytes}")
            }
            Self::TooMany { shape, kind, count, limit } => {
                write!(f, "{shape}: has {count} {kind}, but a tree holds at most {limit}")
            }
            Self::Changed { item, what, before, now } => {
                changed(f, item.as_ref(), what, *before, *now, "trees")
            }
            Self::LightsChanged { item, what, before, now } => {
                changed(f, item.as_ref(), what, *before, *now, "lights")
            }
        }
    }
}

/// Prints that something built from a scene does not fit it any more.
fn changed(
    f: &mut fmt::Formatter<'_>,
    item: Option<&SceneItem>,
    what: &str,
    before: usize,
    now: usize,
    built: &str,
) -> fmt::Result {
    match item {
        Some(item) => write!(f, "{item}: has")?,
        None => write!(f, "the scene has")?,
    }
    write!(f, " {now} {what}, but the {built} were built from {before}: build new {built}")
}

impl Error for SceneError {}
