//! Images with the precision of their files.

use crate::{Image, linear_from_srgb, linear_from_srgb_table};

/// An image with the precision of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Decoded {
    /// Number of columns, at least 1.
    pub width: u32,
    /// Number of rows, at least 1.
    pub height: u32,
    /// The pixels, row by row from the top.
    pub samples: Samples,
}

/// Red, green, blue and alpha of each pixel. Alpha is the largest value where the file has none.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// sRGB with 8 bits per channel, from PNG, JPEG, BMP and TGA files.
    Srgb8(Vec<[u8; 4]>),
    /// sRGB with 16 bits per channel, from PNG files.
    Srgb16(Vec<[u16; 4]>),
    /// Linear, from HDR and EXR files.
    Linear(Vec<[f32; 4]>),
}

impl From<Decoded> for Image {
    /// Converts to linear values. Alpha is scaled to `0.0..=1.0` only.
    fn from(decoded: Decoded) -> Self {
        let Decoded { width, height, samples } = decoded;
        let pixels = match samples {
            Samples::Srgb8(pixels) => {
                let linear = linear_from_srgb_table();
                let pixel = |[r, g, b, a]: [u8; 4]| {
                    let [r, g, b] = [r, g, b].map(|byte| linear[usize::from(byte)]);
                    [r, g, b, f32::from(a) / 255.0]
                };
                pixels.into_iter().map(pixel).collect()
            }
            Samples::Srgb16(pixels) => {
                let pixel = |pixel: [u16; 4]| {
                    let [r, g, b, a] = pixel.map(|word| f32::from(word) / 65_535.0);
                    let [r, g, b] = [r, g, b].map(linear_from_srgb);
                    [r, g, b, a]
                };
                pixels.into_iter().map(pixel).collect()
            }
            Samples::Linear(pixels) => pixels,
        };
        Self { width, height, pixels }
    }
}
