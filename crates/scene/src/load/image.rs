//! Textures from PNG, JPEG, HDR and EXR files.

use super::error::LoadProblem;
use crate::{Pixels, Texture};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

const SUPPORTED: &str = "png, jpg, hdr and exr";

/// No compression in these formats packs tighter than so many bytes of samples into one. Deflate, in PNG and
/// EXR, reaches 1032; a block of 64 samples of a JPEG takes at least one bit, of which four-fold subsampled
/// colours make 1365 bytes to one.
const TIGHTEST: u64 = 1400;

/// 16,384 x 16,384.
const MOST_PIXELS: u64 = 1 << 28;

/// The format of a file of this extension, as in yocto-gl; `None` means EXR.
pub(super) fn format(extension: String) -> Result<Option<ImageFormat>, LoadProblem> {
    Ok(match extension.as_str() {
        "png" => Some(ImageFormat::Png),
        "jpg" | "jpeg" => Some(ImageFormat::Jpeg),
        "hdr" => Some(ImageFormat::Hdr),
        "exr" => None,
        _ => return Err(LoadProblem::Unsupported { extension, supported: SUPPORTED }),
    })
}

/// Decodes an image.
pub(super) fn read(bytes: &[u8], format: Option<ImageFormat>) -> Result<Texture, LoadProblem> {
    decode(bytes, format).map_err(|problem| LoadProblem::Image { problem: plain(problem) })
}

/// What the libraries say of a file that ends early, each in its way, in one.
fn plain(problem: String) -> String {
    let early =
        ["unexpected end of file", "failed to fill whole buffer", "reference to missing bytes"];
    if early.iter().any(|words| problem.contains(words)) {
        return "the file is cut short, or no image of this format".to_owned();
    }
    if problem == "Memory limit exceeded" {
        return format!("the image has more than the {MOST_PIXELS} pixels supported");
    }
    problem
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

fn decode(bytes: &[u8], format: Option<ImageFormat>) -> Result<Texture, String> {
    let texture = match format {
        Some(format) => decode_with_image(bytes, format)?,
        // Where the library lets numbers wrap round, as B44 does with bad data, a debug build panics.
        None => std::panic::catch_unwind(|| decode_exr(bytes))
            .unwrap_or_else(|_| Err("the data of the image make no sense".to_owned()))?,
    };
    if texture.width == 0 || texture.height == 0 {
        return Err("the image has no pixels".to_owned());
    }
    Ok(texture)
}

fn decode_with_image(bytes: &[u8], format: ImageFormat) -> Result<Texture, String> {
    // For what surrounds the pixels, colour profiles above all, which may unfold to a thousand times their
    // size.
    const AROUND: u64 = 1 << 25;
    let reader = |pixels: u64| {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = image::Limits::no_limits();
        limits.max_alloc = Some(pixels + AROUND);
        reader.limits(limits);
        reader
    };
    let decoder = reader(0).into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    let bits = u64::from(decoder.original_color_type().bits_per_pixel());
    drop(decoder);
    check_size(width.into(), height.into(), bits, bytes)?;
    // What the file unfolds to has just been found to fit its size. Some decoders count it twice.
    let unfolded = 2 * u64::from(width) * u64::from(height) * 16;
    let image = reader(unfolded).decode().map_err(|error| error.to_string())?;
    let pixels = match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Pixels::Floats(image.into_rgba32f().pixels().map(|pixel| pixel.0).collect())
        }
        _ => Pixels::Bytes(image.into_rgba8().pixels().map(|pixel| pixel.0).collect()),
    };
    Ok(Texture { name: String::new(), width, height, pixels })
}

/// Colour, or a lone channel, and `Y` among others, as grey.
fn decode_exr(bytes: &[u8]) -> Result<Texture, String> {
    use exr::prelude::{MetaData, ReadChannels, ReadLayers, ReadSpecificChannel, read};

    // The dimensions first: the library allocates what a header claims.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| error.to_string())?;
    let mut names = Vec::new();
    for header in &meta.headers {
        let bits = 8 * header.channels.bytes_per_pixel as u64;
        check_size(header.layer_size.0 as u64, header.layer_size.1 as u64, bits, bytes)?;
        names.extend(header.channels.list.iter().map(|channel| channel.name.to_string()));
    }
    let grey = match &names[..] {
        [name] if name != "A" => Some(name.as_str()),
        _ if names.iter().any(|name| name == "R") => None,
        _ => names.iter().any(|name| name == "Y").then_some("Y"),
    };
    let levels = read().no_deep_data().largest_resolution_level();
    let pixels = match grey {
        Some(name) => levels
            .specific_channels()
            .required(name)
            .optional("A", 1.0)
            .collect_pixels(
                |size, _| Canvas::new(size.0, size.1),
                |canvas: &mut Canvas, at, (y, a): (f32, f32)| canvas.set(at.0, at.1, [y, y, y, a]),
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map(|image| image.layer_data.channel_data.pixels),
        None => levels
            .rgba_channels(
                |size, _| Canvas::new(size.0, size.1),
                |canvas: &mut Canvas, at, (r, g, b, a): (f32, f32, f32, f32)| {
                    canvas.set(at.0, at.1, [r, g, b, a]);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map(|image| image.layer_data.channel_data.pixels),
    };
    let Canvas { width, height, pixels } = pixels.map_err(|error| error.to_string())?;
    Ok(Texture {
        name: String::new(),
        width: u32::try_from(width).map_err(|error| error.to_string())?,
        height: u32::try_from(height).map_err(|error| error.to_string())?,
        pixels: Pixels::Floats(pixels),
    })
}

/// The pixels of an image while they come in.
struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 4]>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![[0.0; 4]; width * height] }
    }

    fn set(&mut self, x: usize, y: usize, pixel: [f32; 4]) {
        self.pixels[y * self.width + x] = pixel;
    }
}

/// Refuses sizes that no file of this length holds, before anything is allocated for them.
fn check_size(width: u64, height: u64, bits_per_pixel: u64, bytes: &[u8]) -> Result<(), String> {
    let pixels = width.saturating_mul(height);
    if pixels > MOST_PIXELS {
        return Err(format!("{width} x {height} pixels are more than the {MOST_PIXELS} supported"));
    }
    if pixels.saturating_mul(bits_per_pixel) / 8 > bytes.len() as u64 * TIGHTEST {
        return Err(format!("{width} x {height} pixels cannot come from a file of this size"));
    }
    Ok(())
}
