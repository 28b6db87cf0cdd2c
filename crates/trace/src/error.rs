//! Reasons why a render or a film is refused.

use rotund_scene::SceneError;

/// A reason why a render is refused before it begins.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
#[non_exhaustive]
pub enum RenderError {
    #[error("there is no camera {camera}: the scene has {count}, counted from 0")]
    NoCamera { camera: usize, count: usize },
    #[error("option `{field}` is 0; it must be at least 1")]
    Zero { field: &'static str },
    /// Fields count shards from 0, the message from 1.
    #[error("there is no shard {}/{count}", u64::from(*index) + 1)]
    Shard { index: u32, count: u32 },
    #[error("option `clamp` is {clamp}; it must be a positive number")]
    Clamp { clamp: f32 },
    #[error("cannot resume the film: its {field} is {film}, that of the options {options}")]
    OtherPicture { field: &'static str, film: String, options: String },
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Film(#[from] FilmError),
}

/// A reason why a film cannot be made or added to.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
#[non_exhaustive]
pub enum FilmError {
    #[error("a film of {width} x {height} has no pixels")]
    Empty { width: u32, height: u32 },
    #[error("a film of {width} x {height} does not fit into memory: it takes 56 bytes a pixel")]
    TooLarge { width: u32, height: u32 },
    #[error("pixel ({x}, {y}) is outside of a film of {width} x {height}")]
    OutOfRange { x: u32, y: u32, width: u32, height: u32 },
    #[error("a merge of some shards takes no more samples: add them to the shards")]
    Merged,
}
