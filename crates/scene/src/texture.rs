//! Textures: images that are repeated over the plane and filtered bilinearly.

use crate::{SceneError, tiles::Tiles};
use glam::{Vec2, Vec3, Vec4};
use rotund_image::{linear_from_srgb, linear_from_srgb_table};

/// An image of RGBA pixels with row 0 at `v = 0`, repeated over the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name for messages; may be empty.
    pub name: String,
    /// Pixels in a row, at least one.
    pub width: u32,
    /// Number of rows, at least one.
    pub height: u32,
    /// The pixels, row by row from the top or in tiles.
    pub pixels: Pixels,
}

impl Default for Texture {
    /// One white pixel.
    fn default() -> Self {
        let pixels = Pixels::Bytes(vec![[255; 4]]);
        Self { name: String::new(), width: 1, height: 1, pixels }
    }
}

/// Formats of pixels. `load` and [`Texture::from_rgba8`] convert rows to tiles where that saves
/// memory or cache misses.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// 8 bits a channel: sRGB where the texture is a colour, and linear where it is data.
    Bytes(Vec<[u8; 4]>),
    /// 16 bits a channel, as [`Self::Bytes`]. Look-ups of colours are slower.
    Words(Vec<[u16; 4]>),
    /// Linear channels.
    Floats(Vec<[f32; 4]>),
    /// The format of [`Self::Bytes`], in tiles.
    TiledBytes(Tiles),
    /// Linear and opaque, in the format of Radiance HDR files: three mantissas and an exponent `e`,
    /// which scales the mantissas by `2^(e - 136)`. It takes a quarter of the memory of floats, so
    /// that more of an environment fits into the caches.
    SharedExponent(Tiles),
}

impl Pixels {
    /// Converts to tiles, without a change of any value, where that saves memory or cache misses.
    pub(crate) fn packed(self, width: u32) -> Self {
        let width = width as usize;
        let tiled = match &self {
            Self::Bytes(bytes) => Tiles::new(width, bytes).map(Self::TiledBytes),
            Self::Floats(floats) => shared_exponents(floats)
                .and_then(|pixels| Tiles::new(width, &pixels))
                .map(Self::SharedExponent),
            Self::Words(_) | Self::TiledBytes(_) | Self::SharedExponent(_) => None,
        };
        tiled.unwrap_or(self)
    }
}

/// Returns the pixels of [`Pixels::SharedExponent`] that represent these exactly, if all have one.
fn shared_exponents(floats: &[[f32; 4]]) -> Option<Vec<[u8; 4]>> {
    // Collecting into an `Option` would grow the vector step by step.
    let mut packed = Vec::with_capacity(floats.len());
    for &pixel in floats {
        packed.push(shared_exponent(pixel)?);
    }
    Some(packed)
}

/// Returns the pixel of [`Pixels::SharedExponent`] that represents these numbers exactly, if there
/// is one.
fn shared_exponent(pixel @ [r, g, b, _]: [f32; 4]) -> Option<[u8; 4]> {
    let largest = r.max(g).max(b);
    // The largest mantissa is 128 to 255. A number from 2^k up has an exponent field of k + 127.
    let exponent = if largest == 0.0 { 0 } else { (largest.to_bits() >> 23) + 2 };
    // Negative numbers do not fit, nor do those that the decoder would scale to infinity.
    let exponent = u8::try_from(exponent).ok().filter(|&e| e < u8::MAX)?;
    // 2^(128 - e), by the bits of its exponent, brings the largest channel to between 0.5 and 1. A
    // channel so much smaller that it loses digits does not fit anyway. If the largest is zero, the
    // factor is infinite: zeros become NaN and then 0, and a negative number does not fit.
    let scale = f32::from_bits((255 - u32::from(exponent)) << 23);
    let [r, g, b] = [r, g, b].map(|channel| (channel * scale * 256.0) as u8);
    let packed = [r, g, b, exponent];
    let same = unpacked(packed).to_array().map(f32::to_bits) == pixel.map(f32::to_bits);
    same.then_some(packed)
}

fn unpacked([r, g, b, exponent]: [u8; 4]) -> Vec4 {
    // 2^(e - 127) by its bits, then the remaining factor. An exponent field of 0 gives the number
    // 0.
    let scale = f32::from_bits(u32::from(exponent) << 23) * (1.0 / 512.0);
    (Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * scale).extend(1.0)
}

impl Texture {
    /// Creates a texture of 8 bits a channel from red, green, blue and alpha of each pixel, row by
    /// row from the top. Red, green and blue are sRGB where the texture is a colour; alpha is
    /// linear and not premultiplied.
    ///
    /// # Errors
    ///
    /// [`SceneError::ByteCount`] if there are not four bytes for each pixel.
    pub fn from_rgba8(width: u32, height: u32, bytes: &[u8]) -> Result<Self, SceneError> {
        let (pixels, rest) = bytes.as_chunks();
        let count = u64::from(width) * u64::from(height);
        if !rest.is_empty() || pixels.len() as u64 != count {
            return Err(SceneError::ByteCount { width, height, bytes: bytes.len() });
        }
        let pixels = Pixels::Bytes(pixels.to_vec()).packed(width);
        Ok(Self { name: String::new(), width, height, pixels })
    }

    /// Returns linear colour and opacity at `uv`, with integers decoded from sRGB.
    ///
    /// The filter is bilinear between the four nearest pixels. Pixel `i` is centred at `uv = i /
    /// size`, without the usual shift by half a pixel, as in yocto-gl. A coordinate that is not
    /// finite reads row or column 0; an image without pixels is white.
    ///
    /// # Panics
    ///
    /// If there are fewer pixels than width and height say, which [`crate::Scene::validate`]
    /// refuses.
    #[must_use]
    pub fn color(&self, uv: Vec2) -> Vec4 {
        match &self.pixels {
            Pixels::Bytes(bytes) => {
                let (linear, width) = (linear_from_srgb_table(), self.width as usize);
                self.filtered(uv, |x, y| linear_color(linear, bytes[y * width + x]))
            }
            Pixels::TiledBytes(tiles) => {
                let linear = linear_from_srgb_table();
                self.filtered(uv, |x, y| linear_color(linear, tiles.at(x, y)))
            }
            Pixels::Words(words) => {
                let width = self.width as usize;
                self.filtered(uv, |x, y| linear_words(words[y * width + x]))
            }
            Pixels::Floats(_) | Pixels::SharedExponent(_) => self.data(uv),
        }
    }

    /// Returns the channels at `uv` as data: integers are divided by the largest one and not
    /// decoded from sRGB.
    /// The filter and the panics are those of [`Self::color`].
    #[must_use]
    pub fn data(&self, uv: Vec2) -> Vec4 {
        let width = self.width as usize;
        match &self.pixels {
            Pixels::Bytes(bytes) => self.filtered(uv, |x, y| shares(bytes[y * width + x])),
            Pixels::Words(words) => self.filtered(uv, |x, y| word_shares(words[y * width + x])),
            Pixels::Floats(floats) => {
                self.filtered(uv, |x, y| Vec4::from_array(floats[y * width + x]))
            }
            Pixels::TiledBytes(tiles) => self.filtered(uv, |x, y| shares(tiles.at(x, y))),
            Pixels::SharedExponent(tiles) => self.filtered(uv, |x, y| unpacked(tiles.at(x, y))),
        }
    }

    /// Returns the linear colour of one pixel, `x < width` and `y < height`.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    #[must_use]
    pub fn color_at(&self, x: u32, y: u32) -> Vec4 {
        assert!(x < self.width && y < self.height, "no pixel at {x}, {y}");
        let (x, y) = (x as usize, y as usize);
        let index = y * self.width as usize + x;
        match &self.pixels {
            Pixels::Bytes(bytes) => linear_color(linear_from_srgb_table(), bytes[index]),
            Pixels::Words(words) => linear_words(words[index]),
            Pixels::Floats(floats) => Vec4::from_array(floats[index]),
            Pixels::TiledBytes(tiles) => linear_color(linear_from_srgb_table(), tiles.at(x, y)),
            Pixels::SharedExponent(tiles) => unpacked(tiles.at(x, y)),
        }
    }

    /// Calls `visit` with the linear colour of each pixel, row by row from the top. This is faster
    /// than [`Self::color_at`] for each.
    pub fn for_each_color(&self, mut visit: impl FnMut(Vec4)) {
        let linear = linear_from_srgb_table();
        match &self.pixels {
            Pixels::Bytes(bytes) => bytes.iter().for_each(|&p| visit(linear_color(linear, p))),
            Pixels::Words(words) => words.iter().for_each(|&p| visit(linear_words(p))),
            Pixels::Floats(floats) => floats.iter().for_each(|&p| visit(Vec4::from_array(p))),
            Pixels::TiledBytes(tiles) => tiles.for_each(|p| visit(linear_color(linear, p))),
            Pixels::SharedExponent(tiles) => tiles.for_each(|p| visit(unpacked(p))),
        }
    }

    /// Returns the largest red, green and blue of all pixels, as linear colours.
    #[must_use]
    pub fn brightest(&self) -> Vec3 {
        let linear = linear_from_srgb_table();
        let bytes = |pixel: [u8; 4]| linear_color(linear, pixel);
        let most = |sum: Vec3, color: Vec4| sum.max(color.truncate());
        match &self.pixels {
            Pixels::Bytes(pixels) => pixels.iter().map(|&p| bytes(p)).fold(Vec3::ZERO, most),
            Pixels::Words(pixels) => pixels.iter().map(|&p| linear_words(p)).fold(Vec3::ZERO, most),
            Pixels::Floats(pixels) => {
                pixels.iter().map(|&p| Vec4::from_array(p)).fold(Vec3::ZERO, most)
            }
            Pixels::TiledBytes(tiles) => tiles.pixels().map(bytes).fold(Vec3::ZERO, most),
            Pixels::SharedExponent(tiles) => tiles.pixels().map(unpacked).fold(Vec3::ZERO, most),
        }
    }

    /// Returns true if the alpha of every pixel is at least 1.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        match &self.pixels {
            Pixels::Bytes(pixels) => pixels.iter().all(|&[.., alpha]| alpha == u8::MAX),
            Pixels::Words(pixels) => pixels.iter().all(|&[.., alpha]| alpha == u16::MAX),
            Pixels::Floats(pixels) => pixels.iter().all(|&[.., alpha]| alpha >= 1.0),
            Pixels::TiledBytes(tiles) => tiles.pixels().all(|[.., alpha]| alpha == u8::MAX),
            Pixels::SharedExponent(_) => true,
        }
    }

    /// Filters bilinearly; `at` returns the pixel of a column and a row.
    #[inline]
    fn filtered(&self, uv: Vec2, at: impl Fn(usize, usize) -> Vec4) -> Vec4 {
        if self.width == 0 || self.height == 0 {
            return Vec4::ONE;
        }
        let (x0, x1, s) = neighbours(uv.x, self.width);
        let (y0, y1, t) = neighbours(uv.y, self.height);
        at(x0, y0) * ((1.0 - s) * (1.0 - t))
            + at(x0, y1) * ((1.0 - s) * t)
            + at(x1, y0) * (s * (1.0 - t))
            + at(x1, y1) * (s * t)
    }
}

/// Converts a pixel of bytes to data.
#[inline]
fn shares(pixel: [u8; 4]) -> Vec4 {
    Vec4::from_array(pixel.map(|byte| f32::from(byte) / 255.0))
}

/// Converts a pixel of 16 bits to data.
fn word_shares(pixel: [u16; 4]) -> Vec4 {
    Vec4::from_array(pixel.map(|word| f32::from(word) / 65_535.0))
}

/// Converts a pixel of 16 bits to a linear colour.
fn linear_words(pixel: [u16; 4]) -> Vec4 {
    let [r, g, b, a] = word_shares(pixel).to_array();
    Vec4::from_array([linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), a])
}

/// Converts a pixel of bytes to a linear colour.
#[inline]
fn linear_color(linear: &[f32; 256], [r, g, b, a]: [u8; 4]) -> Vec4 {
    let [r, g, b] = [r, g, b].map(|byte| linear[usize::from(byte)]);
    Vec4::new(r, g, b, f32::from(a) / 255.0)
}

/// Returns the two pixels around a coordinate, and the weight of the second.
#[inline]
fn neighbours(coordinate: f32, size: u32) -> (usize, usize, f32) {
    // The coordinate minus its floor, which is a library call without SSE 4.1. The cast rounds
    // towards zero and saturates: a coordinate beyond its range, or a NaN, is outside of 0 to 1.
    let rest = coordinate - coordinate as i32 as f32;
    let rest = if rest < 0.0 { rest + 1.0 } else { rest };
    let place = if (0.0..=1.0).contains(&rest) { rest * size as f32 } else { 0.0 };
    // A fraction that rounds up to 1 stays in the last pixel.
    let first = (place as u32).min(size - 1);
    let second = if first + 1 < size { first + 1 } else { 0 };
    (first as usize, second as usize, place - first as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_that_share_an_exponent_are_packed_and_come_back_to_the_bit() {
        let tiny = f32::MIN_POSITIVE;
        let table = [
            ("black", [0.0, 0.0, 0.0, 1.0], Some([0, 0, 0, 0])),
            ("one", [1.0, 1.0, 1.0, 1.0], Some([128, 128, 128, 129])),
            ("a sun", [65_280.0, 256.0, 0.0, 1.0], Some([255, 1, 0, 144])),
            (
                "eight bits and a smaller channel",
                [0.498_046_88, 0.25, 0.125, 1.0],
                Some([255, 128, 64, 127]),
            ),
            ("the least that is normal", [tiny, 0.0, 0.0, 1.0], Some([128, 0, 0, 3])),
            ("nine bits", [1.003_906_3, 0.0, 0.0, 1.0], None),
            ("a channel that is too small beside the largest", [1.0, 0.001, 0.0, 1.0], None),
            ("transparent", [1.0, 1.0, 1.0, 0.5], None),
            ("less than nothing", [1.0, -1.0, 0.0, 1.0], None),
            ("less than nothing beside nothing", [-1.0, 0.0, 0.0, 1.0], None),
            ("nothing from below", [1.0, -0.0, 0.0, 1.0], None),
            ("not normal", [0.25 * tiny, 0.0, 0.0, 1.0], Some([64, 0, 0, 2])),
            ("the largest", [f32::MAX, 0.0, 0.0, 1.0], None),
            ("infinite", [f32::INFINITY, 0.0, 0.0, 1.0], None),
            ("not a number", [f32::NAN, 0.0, 0.0, 1.0], None),
        ];
        for (why, pixel, expected) in table {
            assert_eq!(shared_exponent(pixel), expected, "{why}");
            if let Some(packed) = expected {
                assert_eq!(unpacked(packed).to_array(), pixel, "{why}");
            }
        }
        for e in 3..u8::MAX {
            for m in 128..=u8::MAX {
                let packed = [m, m / 2, 1, e];
                assert_eq!(
                    shared_exponent(unpacked(packed).to_array()),
                    Some(packed),
                    "{packed:?}"
                );
            }
        }
    }

    #[test]
    fn one_pixel_that_does_not_fit_keeps_all_as_floats() {
        let mut pixels = vec![[0.5, 0.25, 2.0, 1.0]; 64];
        let packed = Pixels::Floats(pixels.clone()).packed(8);
        assert!(matches!(packed, Pixels::SharedExponent(_)));
        pixels[63] = [0.1, 0.2, 0.3, 1.0];
        let mixed = Pixels::Floats(pixels.clone()).packed(8);
        assert!(matches!(mixed, Pixels::Floats(floats) if floats == pixels));
    }

    #[test]
    fn packed_images_look_as_they_did() {
        let (width, height) = (21, 10);
        let byte = |i: u32| [i as u8, (3 * i) as u8, (i / 7) as u8, (255 - i) as u8];
        let float =
            |i: u32| unpacked([128 + (i % 128) as u8, i as u8 / 2, 9, 120 + (i % 20) as u8]);
        let bytes = (0..width * height).map(byte).collect();
        let floats = (0..width * height).map(|i| float(i).to_array()).collect();
        for pixels in [Pixels::Bytes(bytes), Pixels::Floats(floats)] {
            let plain = Texture { name: String::new(), width, height, pixels };
            let packed = Texture { pixels: plain.pixels.clone().packed(width), ..plain.clone() };
            let tiled = matches!(packed.pixels, Pixels::TiledBytes(_) | Pixels::SharedExponent(_));
            assert!(tiled, "{:?}", packed.pixels);
            assert_eq!(plain.is_opaque(), packed.is_opaque());
            let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let colors: Vec<Vec4> = places.map(|(x, y)| plain.color_at(x, y)).collect();
            for texture in [&plain, &packed] {
                let mut visited = Vec::new();
                texture.for_each_color(|color| visited.push(color));
                assert_eq!(visited, colors);
                let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                assert!(places.map(|(x, y)| texture.color_at(x, y)).eq(visited));
            }
            for i in 0..1000 {
                let uv = Vec2::new(i as f32 * 0.618_034, i as f32 * 0.137 - 3.0);
                assert_eq!(plain.color(uv), packed.color(uv), "{uv}");
                assert_eq!(plain.data(uv), packed.data(uv), "{uv}");
            }
        }
    }
}
