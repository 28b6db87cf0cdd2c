//! Pictures as commands compare them: linear RGB read from any image file.

use crate::color::linear_from_srgb;
use crate::{Image, write_with};
use anyhow::{Context, Result, bail};
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use glam::Vec3;
use image::RgbImage;
use std::path::Path;

/// An image in linear RGB, row by row from the top; alpha is dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` of them.
    pub pixels: Vec<Vec3>,
}

impl Picture {
    /// Reads an EXR or HDR file as it is, a PNG or JPEG through the sRGB transfer function.
    pub fn read(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        let picture = match extension.as_str() {
            "exr" => read_exr(path),
            "hdr" | "png" | "jpg" | "jpeg" => read_with_image(path, extension == "hdr"),
            _ => bail!("{}: not an image this command reads (exr, hdr, png, jpg)", path.display()),
        };
        picture.with_context(|| format!("{}: cannot be read as an image", path.display()))
    }
}

impl From<&Image> for Picture {
    fn from(image: &Image) -> Self {
        let pixels = image.pixels.iter().map(|&[r, g, b, _]| Vec3::new(r, g, b)).collect();
        Self { width: image.width as usize, height: image.height as usize, pixels }
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

/// Writes an 8-bit PNG: to another name first, renamed when complete.
pub fn write_png(path: &Path, image: &RgbImage) -> Result<()> {
    write_with(path, |file| image.write_with_encoder(image::codecs::png::PngEncoder::new(file)))?;
    Ok(())
}
