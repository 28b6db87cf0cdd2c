//! Images from and to files.

use super::decode::decode;
use super::encode::encode_to;
use super::error::{ReadError, WriteError};
use super::format::Format;
use crate::Image;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write as _};
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

/// Writes a file under a temporary name in the same folder and renames it when it is complete, so
/// that a reader sees the old content or the new, and a failure leaves nothing behind. `encode`
/// writes the content; files of any kind can be written this way.
///
/// # Errors
///
/// If the folder cannot be written to, or `encode` fails.
pub fn write_with<E: Into<Box<dyn Error + Send + Sync>>>(
    path: impl AsRef<Path>,
    encode: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<(), WriteError> {
    let path = path.as_ref();
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let create = |source| WriteError::Create { path: path.into(), source };
    let encode_error = |source| WriteError::Encode { path: path.into(), source };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rotund-").suffix(".part");
    // A temporary file is readable by its owner alone by default; an image gets the usual
    // permissions.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let temporary = builder.tempfile_in(folder).map_err(create)?;
    {
        let mut buffer = BufWriter::new(temporary.as_file());
        encode(&mut buffer).map_err(|e| encode_error(e.into()))?;
        buffer.flush().map_err(|e| encode_error(e.into()))?;
    }
    temporary.as_file().sync_all().map_err(|e| encode_error(e.into()))?;
    temporary.persist(path).map_err(|e| encode_error(e.error.into()))?;
    Ok(())
}
