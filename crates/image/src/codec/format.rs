//! The formats of image files.

use std::path::Path;

/// A format of image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// PNG: sRGB with alpha, written with 8 bits per channel.
    Png,
    /// JPEG: sRGB with 8 bits per channel, lossy, without alpha.
    Jpeg,
    /// Radiance HDR: linear, 8 bits per channel and a shared exponent, without alpha.
    Hdr,
    /// OpenEXR: linear, written with 32 bits per channel, lossless.
    Exr,
    /// Windows bitmap: sRGB with 8 bits per channel, only read.
    Bmp,
    /// Truevision TGA: sRGB with 8 bits per channel, only read.
    Tga,
}

impl Format {
    /// The extensions of the formats that are written, for messages.
    pub const EXTENSIONS: &str = "png, jpg, hdr and exr";

    /// Returns the format to write that the extension of a file name stands for, in upper or lower
    /// case.
    #[must_use]
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        Self::from_extension(path.as_ref().extension()?.to_str()?)
    }

    /// Returns the format to write that an extension stands for, in upper or lower case.
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "hdr" => Some(Self::Hdr),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }
}
