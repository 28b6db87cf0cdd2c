//! Images to bytes.

use super::error::{EncodeError, one_line};
use super::format::Format;
use crate::Image;
use ::image::codecs::{hdr::HdrEncoder, jpeg::JpegEncoder, png::PngEncoder};
use ::image::{ExtendedColorType, ImageEncoder as _};
use exr::prelude::{
    Encoding, Image as ExrImage, Layer, LayerAttributes, LineOrder, SpecificChannels,
    WritableImage as _,
};
use std::io::{Cursor, Seek, Write};

/// Quality of JPEG files, of 100.
const JPEG_QUALITY: u8 = 92;

/// The encoding of EXR files: lossless, with tiles in increasing order. In any other order, tiles
/// are written as threads finish them, and the bytes of a file would differ from run to run.
pub const EXR_ENCODING: Encoding =
    Encoding { line_order: LineOrder::Increasing, ..Encoding::FAST_LOSSLESS };

/// Encodes an image in memory. [`Image::write`] describes what each format keeps.
///
/// # Errors
///
/// If the image is not `width * height` pixels or has none, or is too large for the format.
pub fn encode(image: &Image, format: Format) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = Cursor::new(Vec::new());
    encode_to(&mut bytes, image, format)?;
    Ok(bytes.into_inner())
}

/// Returns the colour of a pixel in the range of Radiance HDR. The library would wrap the exponents
/// of other numbers around.
fn rgbe_range([r, g, b, _]: [f32; 4]) -> ::image::Rgb<f32> {
    /// The largest mantissa, 255/256, at the largest exponent, 255 - 128.
    const LARGEST: f32 = 255.0 * (1_u128 << 119) as f32;
    /// Below this power of two an exponent is 0, which stands for black, or less.
    const SMALLEST: f32 = 0.25 * f32::MIN_POSITIVE;
    let in_range = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, LARGEST) };
    let color = [r, g, b].map(in_range);
    let black = color.iter().all(|&channel| channel < SMALLEST);
    ::image::Rgb(if black { [0.0; 3] } else { color })
}

pub(super) fn encode_to(
    file: impl Write + Seek,
    image: &Image,
    format: Format,
) -> Result<(), EncodeError> {
    let &Image { width, height, ref pixels } = image;
    if pixels.is_empty() || !image.is_whole() {
        let count = pixels.len();
        let problem = format!("an image of {width} x {height} holds {count} pixels");
        return Err(EncodeError { problem });
    }
    let size = (width as usize, height as usize);
    let plain = |error: ::image::ImageError| EncodeError { problem: one_line(&error.to_string()) };
    match format {
        Format::Png => {
            let bytes = image.srgb_bytes();
            let encoder = PngEncoder::new(file);
            encoder
                .write_image(bytes.as_flattened(), width, height, ExtendedColorType::Rgba8)
                .map_err(plain)
        }
        Format::Jpeg => {
            let rgb = |[r, g, b, _]: [u8; 4]| [r, g, b];
            let bytes: Vec<u8> = image.srgb_bytes().into_iter().flat_map(rgb).collect();
            let encoder = JpegEncoder::new_with_quality(file, JPEG_QUALITY);
            encoder.write_image(&bytes, width, height, ExtendedColorType::Rgb8).map_err(plain)
        }
        Format::Bmp | Format::Tga => {
            let problem = "BMP and TGA files are only read; write a PNG instead".to_owned();
            Err(EncodeError { problem })
        }
        Format::Hdr => {
            let colors: Vec<_> = pixels.iter().map(|&pixel| rgbe_range(pixel)).collect();
            HdrEncoder::new(file).encode(&colors, size.0, size.1).map_err(plain)
        }
        Format::Exr => {
            let channels = SpecificChannels::rgba(|at: exr::math::Vec2<usize>| {
                let [r, g, b, a] = pixels[at.y() * size.0 + at.x()];
                (r, g, b, a)
            });
            let layer = Layer::new(size, LayerAttributes::default(), EXR_ENCODING, channels);
            let written = ExrImage::from_layer(layer).write().to_buffered(file);
            written.map_err(|error| EncodeError { problem: one_line(&error.to_string()) })
        }
    }
}
