//! Reasons why a render is refused.

use crate::film::FilmError;
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
    #[error("shard {index} is out of range: {count} shards are counted from 0")]
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
