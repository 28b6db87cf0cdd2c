//! Images inside an HTML page.

use anyhow::Result;
use base64::Engine as _;
use image::codecs::{jpeg::JpegEncoder, png::PngEncoder};
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};

use rotund_image::Picture;
use rotund_image::color::srgb_bytes;

/// Larger pictures are shown smaller, so that a page stays a few MB; the files beside the page are
/// not.
const WIDEST: u32 = 1920;
/// A PNG up to this size is embedded as it is, else a JPEG takes its place.
const LARGEST_PNG: usize = 400_000;
const JPEG_QUALITY: u8 = 92;
/// Width of a thumbnail in pixels.
const THUMBNAIL: u32 = 400;

/// A picture as a screen shows it.
pub fn shown(picture: &Picture) -> RgbImage {
    RgbImage::from_fn(picture.width as u32, picture.height as u32, |x, y| {
        Rgb(srgb_bytes(picture.pixels[y as usize * picture.width + x as usize]))
    })
}

/// A data URI of a picture, which may lose pixels and digits to stay small.
pub fn photo(image: &RgbImage) -> Result<String> {
    let longest = image.width().max(image.height());
    let smaller;
    let image = if longest > WIDEST {
        let scale = |side: u32| (u64::from(side) * u64::from(WIDEST) / u64::from(longest)) as u32;
        let (width, height) = (scale(image.width()).max(1), scale(image.height()).max(1));
        smaller = imageops::resize(image, width, height, FilterType::Triangle);
        &smaller
    } else {
        image
    };
    let mut png = Vec::new();
    image.write_with_encoder(PngEncoder::new(&mut png))?;
    if png.len() <= LARGEST_PNG {
        return Ok(data_uri("image/png", &png));
    }
    let mut jpeg = Vec::new();
    image.write_with_encoder(JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY))?;
    Ok(data_uri("image/jpeg", &jpeg))
}

/// A data URI of a small copy of a picture.
pub fn thumbnail(picture: &Picture) -> Result<String> {
    let image = shown(picture);
    let height = (u64::from(image.height()) * u64::from(THUMBNAIL)).div_ceil(image.width().into());
    let small = imageops::resize(&image, THUMBNAIL, height as u32, FilterType::Triangle);
    let mut jpeg = Vec::new();
    small.write_with_encoder(JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY))?;
    Ok(data_uri("image/jpeg", &jpeg))
}

/// A data URI of a rectangle of a picture, to the last bit.
pub fn exact(image: &RgbImage, crop: &super::crops::Crop) -> Result<String> {
    let [x, y, width, height] = [crop.x, crop.y, crop.width, crop.height].map(|side| side as u32);
    let mut png = Vec::new();
    imageops::crop_imm(image, x, y, width, height)
        .to_image()
        .write_with_encoder(PngEncoder::new(&mut png))?;
    Ok(data_uri("image/png", &png))
}

fn data_uri(mime: &str, bytes: &[u8]) -> String {
    format!("data:{mime};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}
