//! Images from and to files.

use super::decode::decode;
use super::encode::encode_to;
use super::error::{ReadError, WriteError};
use super::format::Format;
use super::replace::write_with;
use crate::Image;
use std::path::Path;

impl Image {
    /// Reads a PNG, JPEG, BMP, TGA, Radiance HDR or OpenEXR file; its content decides on the
    /// format, not its name.
    ///
    /// HDR and EXR files are linear, the others are decoded from sRGB. Alpha is 1 where the file
    /// has none; a file with a single channel becomes grey.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is in no such format or is damaged, or claims a size that it
    /// cannot hold.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ReadError> {
        let path = path.as_ref();
        let bytes =
            std::fs::read(path).map_err(|source| ReadError::Open { path: path.into(), source })?;
        let decoded = Format::of_content(&bytes)
            .and_then(|format| decode(&bytes, format))
            .map_err(|source| ReadError::Decode { path: path.into(), source })?;
        Ok(decoded.into())
    }

    /// Writes the image in the format that the extension of the name stands for:
    ///
    /// - `png`: sRGB with 8 bits per channel, clipped to `0.0..=1.0`, with alpha;
    /// - `jpg`, `jpeg`: the same without alpha, lossy, of quality 92;
    /// - `exr`: linear, 32 bits, with alpha;
    /// - `hdr`: linear, 8 bits and a shared exponent, without alpha. Channels are clipped to
    ///   `0.0..=1.69e38`, and NaN becomes 0.
    ///
    /// The file appears under its name when it is complete, never before.
    ///
    /// # Errors
    ///
    /// If the name has another extension, the image is not `width * height` pixels or has none, or
    /// the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), WriteError> {
        let path = path.as_ref();
        let format = Format::from_path(path)
            .ok_or_else(|| WriteError::UnknownFormat { path: path.into() })?;
        write_with(path, |file| encode_to(file, self, format))
    }
}
