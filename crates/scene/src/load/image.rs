//! Textures from PNG, JPEG, HDR and EXR files.

use super::error::LoadProblem;
use crate::{Pixels, Texture};
use rotund_image::{Decoded, Format, Samples};

/// Returns the format of files with this extension, as in yocto-gl.
pub(super) fn format(extension: String) -> Result<Format, LoadProblem> {
    Format::from_extension(&extension)
        .ok_or(LoadProblem::Unsupported { extension, supported: Format::EXTENSIONS })
}

/// Decodes an image. Bytes stay bytes, which take a quarter of the memory of floats; 16 bits are
/// rounded to 8.
pub(super) fn read(bytes: &[u8], format: Format) -> Result<Texture, LoadProblem> {
    let Decoded { width, height, samples } = rotund_image::decode(bytes, format)
        .map_err(|error| LoadProblem::Image { problem: error.problem })?;
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

/// Replaces pixels that are not finite, which some renderers write, with black ones; returns their
/// number.
pub(super) fn mend(texture: &mut Texture) -> usize {
    let Pixels::Floats(pixels) = &mut texture.pixels else { return 0 };
    let mut mended = 0;
    for pixel in pixels.iter_mut().filter(|pixel| !pixel.iter().all(|c| c.is_finite())) {
        *pixel = [0.0, 0.0, 0.0, 1.0];
        mended += 1;
    }
    mended
}
