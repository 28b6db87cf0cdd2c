//! Radiance HDR files: the header, in all variants in use, before the scanlines that the library
//! decodes.
//!
//! Source: G. Ward, "Real Pixels", Graphics Gems II, 1991; the manual of Radiance, "File formats".

use super::decoded::{Decoded, Samples};
use super::size::check_size;
use ::image::{ImageDecoder as _, codecs::hdr::HdrDecoder};
use std::io::{Cursor, Read as _};

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, String> {
    let (header, scanlines) = Header::read(bytes)?;
    let [along, across] = header.axes;
    let (rows, columns) = if along.is_y { (along, across) } else { (across, along) };
    check_size(columns.length.into(), rows.length.into(), 32, bytes)?;
    // The library accepts a single signature and a single order of axes.
    let usual =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", along.length, across.length);
    let decoder =
        HdrDecoder::new(Cursor::new(usual).chain(scanlines)).map_err(|error| error.to_string())?;
    // Three floats for each pixel.
    let mut floats = vec![0; 12 * along.length as usize * across.length as usize];
    decoder.read_image(&mut floats).map_err(|error| error.to_string())?;
    let (channels, _) = floats.as_chunks::<4>().0.as_chunks::<3>();

    let [width, height] = [columns.length as usize, rows.length as usize];
    let mut pixels = Vec::with_capacity(width * height);
    let exposure = header.exposure;
    for y in 0..height {
        // -Y starts at the top, and +X at the left.
        let row = if rows.increases { height - 1 - y } else { y };
        for x in 0..width {
            let column = if columns.increases { x } else { width - 1 - x };
            let index = if along.is_y { row * width + column } else { column * height + row };
            let [r, g, b] = channels[index].map(f32::from_ne_bytes);
            let [r, g, b] = [r / exposure[0], g / exposure[1], b / exposure[2]];
            let [r, g, b] = if header.is_xyz { rgb_from_xyz([r, g, b]) } else { [r, g, b] };
            pixels.push([r, g, b, 1.0]);
        }
    }
    let samples = Samples::Linear(pixels);
    Ok(Decoded { width: columns.length, height: rows.length, samples })
}

/// What a header says.
struct Header {
    /// Pixels of the file per unit of radiance, for each channel.
    exposure: [f32; 3],
    /// True if the pixels are CIE XYZ.
    is_xyz: bool,
    /// The axis from scanline to scanline, and that along a scanline.
    axes: [Axis; 2],
}

#[derive(Clone, Copy)]
struct Axis {
    is_y: bool,
    increases: bool,
    length: u32,
}

impl Header {
    /// Returns the header and the bytes behind it.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut rest = bytes;
        let mut line = || {
            let end = rest.iter().position(|&byte| byte == b'\n').ok_or("the header has no end")?;
            let (line, after) = rest.split_at(end);
            rest = &after[1..];
            Ok::<_, String>(String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)))
        };
        let mut exposure = [1.0; 3];
        let mut is_xyz = false;
        loop {
            let line = line()?;
            if line.is_empty() {
                break;
            }
            let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with('#')) else {
                continue;
            };
            match key.trim() {
                "FORMAT" => {
                    is_xyz = match value.trim() {
                        "32-bit_rle_rgbe" => false,
                        "32-bit_rle_xyze" => true,
                        other => return Err(format!("the pixels are {other:?}, expected RGBE")),
                    };
                }
                // Each program that scaled the pixels has added a line.
                key @ ("EXPOSURE" | "COLORCORR") => {
                    let factors: Vec<f32> =
                        value.split_ascii_whitespace().filter_map(|x| x.parse().ok()).collect();
                    let factors = match factors[..] {
                        [factor] => [factor; 3],
                        [r, g, b] => [r, g, b],
                        _ => return Err(format!("{key} is {value:?}, expected numbers")),
                    };
                    if !factors.iter().all(|factor| factor.is_normal() && *factor > 0.0) {
                        return Err(format!("{key} is {value:?}, expected positive numbers"));
                    }
                    exposure = std::array::from_fn(|i| exposure[i] * factors[i]);
                }
                _ => {}
            }
        }
        let size = line()?;
        let axes = axes(&size).ok_or_else(|| {
            format!("the size of the image is {size:?}, expected two axes as in \"-Y 32 +X 64\"")
        })?;
        Ok((Self { exposure, is_xyz, axes }, rest))
    }
}

fn axes(size: &str) -> Option<[Axis; 2]> {
    let words: Vec<&str> = size.split_ascii_whitespace().collect();
    let axis = |name: &str, length: &str| {
        let (increases, is_y) = match name {
            "+X" => (true, false),
            "-X" => (false, false),
            "+Y" => (true, true),
            "-Y" => (false, true),
            _ => return None,
        };
        Some(Axis { is_y, increases, length: length.parse().ok()? })
    };
    let [first, first_length, second, second_length] = words[..] else { return None };
    let axes = [axis(first, first_length)?, axis(second, second_length)?];
    (axes[0].is_y != axes[1].is_y).then_some(axes)
}

/// Converts CIE XYZ to linear RGB with BT.709 primaries.
fn rgb_from_xyz([x, y, z]: [f32; 3]) -> [f32; 3] {
    [
        3.240_97 * x - 1.537_383_2 * y - 0.498_610_76 * z,
        -0.969_243_65 * x + 1.875_967_5 * y + 0.041_555_06 * z,
        0.055_630_08 * x - 0.203_976_96 * y + 1.056_971_5 * z,
    ]
}
