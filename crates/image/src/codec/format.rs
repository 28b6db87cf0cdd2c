//! The formats of image files.

use std::path::Path;

/// A format of image files that can be read and written.
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
}

impl Format {
    /// The extensions of file names that [`Self::from_path`] knows, for messages.
    pub const EXTENSIONS: &str = "png, jpg, hdr and exr";

    /// Returns the format that the extension of a file name stands for, in upper or lower case.
    #[must_use]
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        Self::from_extension(path.as_ref().extension()?.to_str()?)
    }

    /// Returns the format that an extension stands for, in upper or lower case.
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

    /// Returns the format whose signature the content of a file starts with.
    #[must_use]
    pub fn from_content(bytes: &[u8]) -> Option<Self> {
        let signatures: [(&[u8], Self); 4] = [
            (b"\x89PNG\r\n\x1a\n", Self::Png),
            (b"\xff\xd8\xff", Self::Jpeg),
            (b"#?", Self::Hdr),
            (b"\x76\x2f\x31\x01", Self::Exr),
        ];
        signatures.into_iter().find(|(start, _)| bytes.starts_with(start)).map(|(_, it)| it)
    }
}
