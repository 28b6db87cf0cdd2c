//! Bytes to images.

use super::decoded::{Decoded, Samples};
use super::error::{DecodeError, one_line};
use super::format::Format;
use super::size::{MAX_PIXELS, check_size};
use super::{hdr, openexr};
use ::image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Decodes an image file in memory. The bytes need not be trusted: an image that claims more pixels
/// than a file of this length can hold is refused before memory is allocated for it.
///
/// An HDR file may start with any `#?` and have any order of axes; its pixels are divided by its
/// exposure. An EXR file gives its display window, from the channels `R G B A`, also in a layer
/// such as Blender's `Combined`; one with a lone channel, or with a channel `Y` but none named `R`,
/// becomes grey.
///
/// # Errors
///
/// If the bytes are no image in this format, are damaged or cut short, or have more than 2^28
/// pixels.
pub fn decode(bytes: &[u8], format: Format) -> Result<Decoded, DecodeError> {
    let decoded = match format {
        Format::Png => decode_with_image(bytes, ImageFormat::Png),
        Format::Jpeg => decode_with_image(bytes, ImageFormat::Jpeg),
        Format::Bmp => decode_with_image(bytes, ImageFormat::Bmp),
        Format::Tga => decode_with_image(bytes, ImageFormat::Tga),
        Format::Hdr => hdr::decode(bytes),
        // Integer overflow in the library, as from damaged B44 data, panics in a debug build.
        Format::Exr => std::panic::catch_unwind(|| openexr::decode(bytes))
            .unwrap_or_else(|_| Err("the data of the image make no sense".to_owned())),
    };
    match decoded {
        Ok(Decoded { width, height, .. }) if width == 0 || height == 0 => {
            Err(DecodeError { problem: "the image has no pixels".to_owned() })
        }
        Ok(decoded) => Ok(decoded),
        Err(problem) => Err(DecodeError { problem: plain(problem) }),
    }
}

/// Replaces the messages of the libraries for common problems by one wording.
fn plain(problem: String) -> String {
    let early =
        ["unexpected end of file", "failed to fill whole buffer", "reference to missing bytes"];
    if early.iter().any(|words| problem.contains(words)) {
        return "the file is cut short, or no image of this format".to_owned();
    }
    if problem == "Memory limit exceeded" {
        return format!("the image has more than the {MAX_PIXELS} pixels supported");
    }
    one_line(&problem)
}

fn decode_with_image(bytes: &[u8], format: ImageFormat) -> Result<Decoded, String> {
    // For metadata, above all colour profiles, which may unfold to a thousand times their size.
    const METADATA: u64 = 1 << 25;
    let reader = |pixels: u64| {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(pixels + METADATA);
        reader.limits(limits);
        reader
    };
    let decoder = reader(0).into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    let bits = u64::from(decoder.original_color_type().bits_per_pixel());
    drop(decoder);
    check_size(width.into(), height.into(), bits, bytes)?;
    // The size has just been found to fit the file. Some decoders count the pixels twice.
    let unfolded = 2 * u64::from(width) * u64::from(height) * 16;
    let image = reader(unfolded).decode().map_err(|error| error.to_string())?;
    let samples = match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Samples::Linear(image.into_rgba32f().pixels().map(|pixel| pixel.0).collect())
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            Samples::Srgb16(image.into_rgba16().pixels().map(|pixel| pixel.0).collect())
        }
        _ => Samples::Srgb8(image.into_rgba8().pixels().map(|pixel| pixel.0).collect()),
    };
    Ok(Decoded { width, height, samples })
}
