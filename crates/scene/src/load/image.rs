//! Textures from PNG, JPEG, HDR and EXR files.

use super::{
    error::NamedBy,
    file::{extension, read},
};
use crate::{LoadError, Pixels, Texture};
use rotund_image::{DecodeError, Format, Samples};
use std::path::Path;

/// Reads an image. The extension decides on the format, as in yocto-gl.
pub(super) fn load(path: &Path, named_by: &NamedBy) -> Result<Texture, LoadError> {
    let Some(format) = Format::from_path(path) else {
        return Err(LoadError::Unsupported {
            path: path.to_owned(),
            named_by: named_by.clone(),
            extension: extension(path),
            supported: Format::EXTENSIONS,
        });
    };
    let bytes = read(path, named_by)?;
    decode(&bytes, format)
        .map_err(|DecodeError { problem, .. }| LoadError::Image { path: path.to_owned(), problem })
}

/// Makes black what is not finite, as renderers leave it here and there, and says how many pixels were.
pub(super) fn mend(texture: &mut Texture) -> usize {
    let Pixels::Floats(pixels) = &mut texture.pixels else { return 0 };
    let mut mended = 0;
    for pixel in pixels.iter_mut().filter(|pixel| !pixel.iter().all(|c| c.is_finite())) {
        *pixel = [0.0, 0.0, 0.0, 1.0];
        mended += 1;
    }
    mended
}

/// Decodes an image. Bytes stay bytes, which take a quarter of the memory of floats; of 16 bits the
/// upper 8 are kept, rounded.
pub(super) fn decode(bytes: &[u8], format: Format) -> Result<Texture, DecodeError> {
    let rotund_image::Decoded { width, height, samples } = rotund_image::decode(bytes, format)?;
    let pixels = match samples {
        Samples::Srgb8(pixels) => Pixels::Bytes(pixels),
        Samples::Srgb16(pixels) => {
            let byte = |word: u16| ((u32::from(word) + 128) / 257) as u8;
            Pixels::Bytes(pixels.into_iter().map(|pixel| pixel.map(byte)).collect())
        }
        Samples::Linear(pixels) => Pixels::Floats(pixels),
    };
    Ok(Texture { name: String::new(), width, height, pixels })
}
