//! The format of an image file by its content.

use super::error::DecodeError;
use super::format::Format;

impl Format {
    /// Returns the format of the content of a file, whatever its name.
    ///
    /// # Errors
    ///
    /// If it is in none of these formats. The message names the format if it is a common one.
    pub fn of_content(bytes: &[u8]) -> Result<Self, DecodeError> {
        let signatures: [(&[u8], Self); 5] = [
            (b"\x89PNG\r\n\x1a\n", Self::Png),
            (b"\xff\xd8\xff", Self::Jpeg),
            (b"#?", Self::Hdr),
            (b"\x76\x2f\x31\x01", Self::Exr),
            (b"BM", Self::Bmp),
        ];
        if let Some((_, format)) = signatures.into_iter().find(|(s, _)| bytes.starts_with(s)) {
            return Ok(format);
        }
        let others: [(usize, &[u8], &str); 11] = [
            (0, b"GIF8", "a GIF"),
            (0, b"II*\0", "a TIFF"),
            (0, b"MM\0*", "a TIFF"),
            (0, b"8BPS", "a Photoshop"),
            (0, b"DDS ", "a DDS"),
            (0, b"\xabKTX", "a KTX"),
            (0, b"qoif", "a QOI"),
            (8, b"WEBP", "a WebP"),
            (4, b"ftypavif", "an AVIF"),
            (4, b"ftyphei", "an HEIC"),
            (0, b"\0\0\0\x0cjP  ", "a JPEG 2000"),
        ];
        let has = |at: usize, start| bytes.get(at..).is_some_and(|rest| rest.starts_with(start));
        if let Some((_, _, name)) = others.into_iter().find(|(at, start, _)| has(*at, start)) {
            let problem = format!("is {name} image, expected PNG, JPEG, HDR, EXR, BMP or TGA");
            return Err(DecodeError { problem });
        }
        if may_be_tga(bytes) {
            return Ok(Self::Tga);
        }
        let what = if bytes.is_empty() { "is empty" } else { "is no image" };
        let problem = format!("{what}, expected PNG, JPEG, HDR, EXR, BMP or TGA");
        Err(DecodeError { problem })
    }
}

/// Returns true if the content may be a TGA file, which has no signature: all fields of its header
/// have one of few values.
fn may_be_tga(bytes: &[u8]) -> bool {
    let Some((header, _)) = bytes.split_first_chunk::<18>() else { return false };
    let [_, map, kind, _, _, map_low, map_high, map_bits, ..] = *header;
    let [.., width_low, width_high, height_low, height_high, bits, _] = *header;
    let mapped = matches!(kind, 1 | 9)
        && map == 1
        && [map_low, map_high] != [0; 2]
        && matches!(map_bits, 15 | 16 | 24 | 32)
        && matches!(bits, 8 | 16);
    let plain =
        matches!(kind, 2 | 3 | 10 | 11) && map <= 1 && matches!(bits, 8 | 15 | 16 | 24 | 32);
    let has_pixels = [width_low, width_high] != [0; 2] && [height_low, height_high] != [0; 2];
    (mapped || plain) && has_pixels
}
