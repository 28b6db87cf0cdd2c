//! Textures from PNG, JPEG, HDR and EXR files.

use super::{
    error::NamedBy,
    file::{extension, read},
};
use crate::{LoadError, Pixels, Texture};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::{io::Cursor, path::Path};

const SUPPORTED: &str = "png, jpg, hdr and exr";

/// No compression in these formats packs tighter than this: Deflate, the tightest, reaches 1032 : 1.
const LARGEST_RATIO: u64 = 1100;

/// What a small file may unfold to in any case.
const SMALLEST_LIMIT: u64 = 1 << 24;

/// Reads an image; the kind is told by the extension, as in yocto-gl.
pub(super) fn load(path: &Path, named_by: &NamedBy) -> Result<Texture, LoadError> {
    let format = match extension(path).as_str() {
        "png" => Some(ImageFormat::Png),
        "jpg" | "jpeg" => Some(ImageFormat::Jpeg),
        "hdr" => Some(ImageFormat::Hdr),
        "exr" => None,
        other => {
            return Err(LoadError::Unsupported {
                path: path.to_owned(),
                named_by: named_by.clone(),
                extension: other.to_owned(),
                supported: SUPPORTED,
            });
        }
    };
    let bytes = read(path, named_by)?;
    decode(&bytes, format).map_err(|problem| LoadError::Image { path: path.to_owned(), problem })
}

/// `None` means EXR.
pub(super) fn decode(bytes: &[u8], format: Option<ImageFormat>) -> Result<Texture, String> {
    let limit = (bytes.len() as u64 * LARGEST_RATIO).max(SMALLEST_LIMIT);
    let texture = match format {
        Some(format) => decode_with_image(bytes, format, limit)?,
        None => decode_exr(bytes, limit)?,
    };
    if texture.width == 0 || texture.height == 0 {
        return Err("the image has no pixels".to_owned());
    }
    Ok(texture)
}

fn decode_with_image(bytes: &[u8], format: ImageFormat, limit: u64) -> Result<Texture, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(limit);
    reader.limits(limits);
    let (width, height) = ImageReader::with_format(Cursor::new(bytes), format)
        .into_dimensions()
        .map_err(|error| error.to_string())?;
    check_size(u64::from(width), u64::from(height), limit)?;
    let image = reader.decode().map_err(|error| error.to_string())?;
    let pixels = match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Pixels::Floats(image.into_rgba32f().pixels().map(|pixel| pixel.0).collect())
        }
        _ => Pixels::Bytes(image.into_rgba8().pixels().map(|pixel| pixel.0).collect()),
    };
    Ok(Texture { name: String::new(), width, height, pixels })
}

fn decode_exr(bytes: &[u8], limit: u64) -> Result<Texture, String> {
    use exr::prelude::{MetaData, ReadChannels, ReadLayers, read};

    // The dimensions first: the library allocates what a header claims.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| error.to_string())?;
    for header in &meta.headers {
        check_size(header.layer_size.0 as u64, header.layer_size.1 as u64, limit)?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.0, vec![[0.0_f32; 4]; size.0 * size.1]),
            |(width, pixels): &mut (usize, Vec<[f32; 4]>),
             position,
             (r, g, b, a): (f32, f32, f32, f32)| {
                pixels[position.1 * *width + position.0] = [r, g, b, a];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    let size = image.layer_data.size;
    let (_, pixels) = image.layer_data.channel_data.pixels;
    Ok(Texture {
        name: String::new(),
        width: u32::try_from(size.0).map_err(|error| error.to_string())?,
        height: u32::try_from(size.1).map_err(|error| error.to_string())?,
        pixels: Pixels::Floats(pixels),
    })
}

fn check_size(width: u64, height: u64, limit: u64) -> Result<(), String> {
    if width.saturating_mul(height) > limit {
        return Err(format!("{width} x {height} pixels cannot come from a file of this size"));
    }
    Ok(())
}
