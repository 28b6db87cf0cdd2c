//! Images inside an HTML page, as data URIs.

use base64::Engine as _;
use rotund_image::{EncodeError, Format, Image, encode};

/// Longest side of a photo. Larger images are scaled down, so that a page stays a few MB.
const PHOTO_SIDE: u32 = 1920;
/// Largest PNG that is embedded as it is. Beyond that, a JPEG takes its place.
const LARGEST_PNG: usize = 400_000;
/// Width of a thumbnail in pixels.
const THUMBNAIL: u32 = 400;

/// Returns the data URI of an image that may lose pixels and digits to keep a page small: sides
/// beyond 1920 pixels are scaled down, and a PNG of more than 400 kB becomes a JPEG.
///
/// # Errors
///
/// If the image has no pixels, or not as many as width and height say.
pub fn photo(image: &Image) -> Result<String, EncodeError> {
    let longest = image.width.max(image.height);
    let smaller;
    let image = if longest > PHOTO_SIDE {
        let scale =
            |side: u32| (u64::from(side) * u64::from(PHOTO_SIDE) / u64::from(longest)) as u32;
        smaller = image.resized(scale(image.width).max(1), scale(image.height).max(1));
        &smaller
    } else {
        image
    };
    let png = encode(image, Format::Png)?;
    if png.len() <= LARGEST_PNG {
        return Ok(data_uri("image/png", &png));
    }
    Ok(data_uri("image/jpeg", &encode(image, Format::Jpeg)?))
}

/// Returns the data URI of a copy that is 400 pixels wide, as a JPEG.
///
/// # Errors
///
/// If the image has no pixels, or not as many as width and height say.
pub fn thumbnail(image: &Image) -> Result<String, EncodeError> {
    let height = u64::from(image.height) * u64::from(THUMBNAIL);
    let height = height.div_ceil(u64::from(image.width).max(1)) as u32;
    // An image without pixels is left for the encoder to refuse.
    let small = if image.pixels.is_empty() { image } else { &image.resized(THUMBNAIL, height) };
    Ok(data_uri("image/jpeg", &encode(small, Format::Jpeg)?))
}

/// Returns the data URI of an image as a PNG: every pixel as it is, in 8-bit sRGB.
///
/// # Errors
///
/// If the image has no pixels, or not as many as width and height say.
pub fn exact(image: &Image) -> Result<String, EncodeError> {
    Ok(data_uri("image/png", &encode(image, Format::Png)?))
}

fn data_uri(mime: &str, bytes: &[u8]) -> String {
    format!("data:{mime};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns an image that no lossless format packs well.
    fn noise(width: u32, height: u32) -> Image {
        let mut state = 1_u32;
        Image::from_srgb_fn(width, height, |_, _| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            [(state >> 24) as u8, (state >> 16) as u8, (state >> 8) as u8]
        })
    }

    #[test]
    fn a_small_photo_is_lossless_and_a_large_one_is_not() {
        assert!(photo(&Image::new(30, 20)).unwrap().starts_with("data:image/png;base64,"));
        assert!(photo(&noise(500, 400)).unwrap().starts_with("data:image/jpeg;base64,"));
        assert!(exact(&noise(500, 400)).unwrap().starts_with("data:image/png;base64,"));
    }

    #[test]
    fn an_image_without_pixels_is_an_error() {
        let empty = Image::default();
        assert!(photo(&empty).is_err() && thumbnail(&empty).is_err() && exact(&empty).is_err());
    }
}
