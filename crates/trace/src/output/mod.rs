//! Files: images as PNG, EXR and HDR, layers as EXR, and films as checkpoints.

mod checkpoint;
mod layers;

pub use checkpoint::{CheckpointError, load_film, save_film};
pub use layers::write_layers;
pub use rotund_image::{OutputError, srgb_from_linear, write_image, write_with};

use crate::Film;
use std::path::Path;

/// Writes the mean of the samples of a film; see [`write_image`].
///
/// # Errors
///
/// As [`write_image`].
pub fn write(path: impl AsRef<Path>, film: &Film) -> Result<(), OutputError> {
    write_image(path, &film.image())
}
