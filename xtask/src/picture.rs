//! Pictures as commands compare them: linear RGB read from any image file.

use anyhow::{Context, Result, bail};
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use glam::Vec3;
use std::path::Path;

/// An image in linear RGB, row by row from the top; alpha is dropped.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Picture {
    /// Pixels in a row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// `width * height` of them.
    pub(crate) pixels: Vec<Vec3>,
}

impl Picture {
    /// Reads an EXR or HDR file as it is, a PNG or JPEG through the sRGB transfer function.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        let picture = match extension.as_str() {
            "exr" => read_exr(path),
            "hdr" | "png" | "jpg" | "jpeg" => read_with_image(path, extension == "hdr"),
            _ => bail!("{}: not an image this command reads (exr, hdr, png, jpg)", path.display()),
        };
        picture.with_context(|| format!("{}: cannot be read as an image", path.display()))
    }
}

fn read_exr(path: &Path) -> Result<Picture> {
    // The exr crate reports a missing file as an error like any other, but opening it here keeps
    // the message of the operating system.
    let file = std::fs::File::open(path)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Picture {
                width: size.width(),
                height: size.height(),
                pixels: vec![Vec3::ZERO; size.area()],
            },
            |picture: &mut Picture, position, (r, g, b): (f32, f32, f32)| {
                picture.pixels[position.y() * picture.width + position.x()] = Vec3::new(r, g, b);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::BufReader::new(file))?;
    Ok(image.layer_data.channel_data.pixels)
}

fn read_with_image(path: &Path, linear: bool) -> Result<Picture> {
    let image = image::ImageReader::open(path)?.with_guessed_format()?.decode()?.into_rgb32f();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let pixels = image
        .pixels()
        .map(|pixel| Vec3::from(pixel.0))
        .map(|color| if linear { color } else { linear_from_srgb(color) })
        .collect();
    Ok(Picture { width, height, pixels })
}

/// IEC 61966-2-1, decoded.
pub(crate) fn linear_from_srgb(color: Vec3) -> Vec3 {
    map_channels(color, |c| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) })
}

/// IEC 61966-2-1, encoded; values outside `0.0..=1.0` are clamped and NaN becomes black.
pub(crate) fn srgb_from_linear(color: Vec3) -> Vec3 {
    map_channels(color, |c| {
        let c = if c > 0.0 { c.min(1.0) } else { 0.0 };
        if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
    })
}

/// Relative luminance with the weights of ITU-R BT.709.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn map_channels(color: Vec3, f: impl Fn(f32) -> f32) -> Vec3 {
    Vec3::new(f(color.x), f(color.y), f(color.z))
}
