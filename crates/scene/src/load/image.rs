//! Textures from image files.

use super::{
    context::Context,
    error::{LoadError, LoadProblem},
    file::NamedFile,
};
use crate::{Pixels, Texture};
use rotund_image::{Decoded, Format, Samples};

/// Reads an image, whatever its name; `is_data` says that it is no colour.
pub(super) fn read(
    context: &Context<'_>,
    file: &NamedFile,
    is_data: bool,
) -> Result<Texture, LoadError> {
    decode(&context.files.read(file)?, is_data).map_err(|problem| file.fail(problem))
}

/// Decodes an image. Bytes stay bytes, which take a quarter of the memory of
/// floats. 16 bits are kept if the texture is data, such as heights, and rounded to 8 in colours.
fn decode(bytes: &[u8], is_data: bool) -> Result<Texture, LoadProblem> {
    let decoded = Format::of_content(bytes).and_then(|format| rotund_image::decode(bytes, format));
    let Decoded { width, height, samples } =
        decoded.map_err(|error| LoadProblem::Image { problem: error.problem })?;
    let pixels = match samples {
        Samples::Srgb8(pixels) => Pixels::Bytes(pixels),
        Samples::Srgb16(pixels) => {
            let is_byte = |word: &u16| word.is_multiple_of(257);
            if is_data && !pixels.as_flattened().iter().all(is_byte) {
                Pixels::Words(pixels)
            } else {
                let byte = |word: u16| ((u32::from(word) + 128) / 257) as u8;
                Pixels::Bytes(pixels.into_iter().map(|pixel| pixel.map(byte)).collect())
            }
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
