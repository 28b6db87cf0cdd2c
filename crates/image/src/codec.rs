//! Image files: PNG for eyes, EXR and HDR for numbers.

use crate::Image;
use exr::prelude::{
    Encoding, Image as ExrImage, Layer, LayerAttributes, LineOrder, SpecificChannels, WritableImage,
};
use std::{
    error::Error,
    fs, io,
    io::{BufWriter, Seek, Write},
    path::{Path, PathBuf},
};

/// Why a picture was not written. The file that stood at the path before, if any, is untouched.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum OutputError {
    #[error("cannot write {}: an image is named *.png, *.exr or *.hdr", path.display())]
    UnknownFormat { path: PathBuf },
    #[error("cannot write {}: its folder cannot be written to", path.display())]
    Create { path: PathBuf, source: io::Error },
    #[error("cannot write {}", path.display())]
    Encode { path: PathBuf, source: Box<dyn Error + Send + Sync> },
}

/// Writes a picture in the format that the name ends with: `png` (sRGB, 8 bits, clipped to
/// `0.0..=1.0`), `exr` (linear, 32 bits) or `hdr` (linear, shared exponent, no alpha).
///
/// The file appears under its name when it is complete, never before.
///
/// # Errors
///
/// If the name ends otherwise, or the file cannot be written. Each error names the path.
pub fn write_image(path: impl AsRef<Path>, image: &Image) -> Result<(), OutputError> {
    let path = path.as_ref();
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "png" => write_with(path, |file| encode_png(file, image)),
        "exr" => write_with(path, |file| encode_exr(file, image)),
        "hdr" => write_with(path, |file| encode_hdr(file, image)),
        _ => Err(OutputError::UnknownFormat { path: path.into() }),
    }
}

/// Writes a file under another name in the same folder and renames it when it is complete, so a
/// reader sees the old content or the new, and a failure leaves nothing behind.
///
/// # Errors
///
/// If the folder cannot be written to, or `encode` fails.
pub fn write_with<E: Into<Box<dyn Error + Send + Sync>>>(
    path: impl AsRef<Path>,
    encode: impl FnOnce(&mut BufWriter<&fs::File>) -> Result<(), E>,
) -> Result<(), OutputError> {
    let path = path.as_ref();
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let create = |source| OutputError::Create { path: path.into(), source };
    let encode_error = |source| OutputError::Encode { path: path.into(), source };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rotund-").suffix(".part");
    // A temporary file is its owner's alone unless told otherwise; a picture is as any new file.
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

/// The sRGB encoding of a linear value, clipped to `0.0..=1.0`; NaN stays NaN.
///
/// Source: IEC 61966-2-1:1999.
#[must_use]
pub fn srgb_from_linear(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

fn encode_png(file: impl Write, image: &Image) -> Result<(), image::ImageError> {
    use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
    let byte = |x: f32| (x * 255.0).round() as u8;
    let bytes: Vec<u8> = image
        .pixels
        .iter()
        .flat_map(|&[r, g, b, a]| {
            let [r, g, b] = [r, g, b].map(|c| byte(srgb_from_linear(c)));
            [r, g, b, byte(a.clamp(0.0, 1.0))]
        })
        .collect();
    PngEncoder::new(file).write_image(&bytes, image.width, image.height, ExtendedColorType::Rgba8)
}

fn encode_hdr(file: impl Write, image: &Image) -> Result<(), image::ImageError> {
    let pixels: Vec<_> = image.pixels.iter().map(|&[r, g, b, _]| image::Rgb([r, g, b])).collect();
    image::codecs::hdr::HdrEncoder::new(file).encode(
        &pixels,
        image.width as usize,
        image.height as usize,
    )
}

/// Tiles in order: else they are written as threads finish them, and the bytes of a file are other ones
/// each time.
pub const ENCODING: Encoding =
    Encoding { line_order: LineOrder::Increasing, ..Encoding::FAST_LOSSLESS };

fn encode_exr(file: impl Write + Seek, image: &Image) -> Result<(), exr::error::Error> {
    let size = (image.width as usize, image.height as usize);
    let channels = SpecificChannels::rgba(|at: exr::math::Vec2<usize>| {
        let [r, g, b, a] = image.pixels[at.y() * size.0 + at.x()];
        (r, g, b, a)
    });
    let layer = Layer::new(size, LayerAttributes::default(), ENCODING, channels);
    ExrImage::from_layer(layer).write().to_buffered(file)
}
