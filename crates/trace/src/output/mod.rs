//! Files: images as PNG, EXR and HDR, layers as EXR, and films as checkpoints.

mod checkpoint;
mod layers;

pub use checkpoint::{CheckpointError, load_film, load_film_header, save_film, save_film_unless};
pub use layers::{LayersError, encode_layers, write_layers};
pub use rotund_image::{WriteError, sweep, write_with};

use crate::Film;
use std::path::Path;

/// Writes the mean of the samples of a film; see [`Image::write`](rotund_image::Image::write).
///
/// # Errors
///
/// As [`Image::write`](rotund_image::Image::write).
pub fn write(path: impl AsRef<Path>, film: &Film) -> Result<(), WriteError> {
    film.image().write(path)
}
