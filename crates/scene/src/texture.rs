//! Images on surfaces.

use glam::{Vec2, Vec3, Vec4};
use std::sync::LazyLock;

/// An image of RGBA pixels, row 0 at `v = 0`, repeated over the plane.
#[derive(Clone, Debug)]
pub struct Texture {
    /// For messages.
    pub name: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row.
    pub pixels: Pixels,
}

/// Pixels as they are stored in files of each kind.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// 8 bits a channel: sRGB where a colour is meant, else read as it is.
    Bytes(Vec<[u8; 4]>),
    /// Linear.
    Floats(Vec<[f32; 4]>),
    /// Linear and opaque, as Radiance HDR files hold them: the channels are `r g b` times `2^(e - 136)`. A
    /// quarter of the memory of floats, so that more of a sky stays near the processor.
    SharedExponent(Vec<[u8; 4]>),
}

impl Pixels {
    /// The same numbers, to the bit, in the least memory.
    pub(crate) fn packed(self) -> Self {
        if let Self::Floats(floats) = &self
            && let Some(packed) = floats.iter().map(|&pixel| shared_exponent(pixel)).collect()
        {
            return Self::SharedExponent(packed);
        }
        self
    }
}

/// A pixel of [`Pixels::SharedExponent`], if it holds these numbers exactly.
fn shared_exponent(pixel @ [r, g, b, _]: [f32; 4]) -> Option<[u8; 4]> {
    let largest = r.max(g).max(b);
    // The largest channel becomes 128 to 255. A number of 2^k and more has an exponent field of k + 127.
    let exponent = if largest == 0.0 { 0 } else { (largest.to_bits() >> 23) + 2 };
    // Numbers so large that the decoder would make an infinity of them, or negative ones, do not fit.
    let exponent = u8::try_from(exponent).ok().filter(|&e| e < u8::MAX)?;
    let steps = (136.0 - f64::from(exponent)).exp2();
    let [r, g, b] = [r, g, b].map(|channel| (f64::from(channel) * steps) as u8);
    let packed = [r, g, b, exponent];
    let same = unpacked(packed).to_array().map(f32::to_bits) == pixel.map(f32::to_bits);
    same.then_some(packed)
}

fn unpacked([r, g, b, exponent]: [u8; 4]) -> Vec4 {
    // 2^(e - 127), then the rest; a field of 0 is the number 0, as it should be.
    let scale = f32::from_bits(u32::from(exponent) << 23) * (1.0 / 512.0);
    (Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * scale).extend(1.0)
}

impl Texture {
    /// One white pixel.
    pub(crate) fn white() -> Self {
        let pixels = Pixels::Bytes(vec![[255; 4]]);
        Self { name: String::new(), width: 1, height: 1, pixels }
    }

    /// The linear colour and the opacity at `uv`: bytes are sRGB.
    ///
    /// Bilinear between the four nearest pixels; pixel `i` stands at `uv = i / size`, without a shift
    /// of half a pixel. A coordinate that is not finite reads row or column 0, an image without
    /// pixels is white.
    #[must_use]
    pub fn color(&self, uv: Vec2) -> Vec4 {
        match &self.pixels {
            Pixels::Bytes(bytes) => {
                let linear = &*LINEAR_FROM_SRGB;
                self.filtered(uv, |index| linear_color(linear, bytes[index]))
            }
            _ => self.data(uv),
        }
    }

    /// The numbers at `uv`: bytes are divided by 255 and nothing else. Filtered as [`Self::color`].
    #[must_use]
    pub fn data(&self, uv: Vec2) -> Vec4 {
        match &self.pixels {
            Pixels::Bytes(bytes) => self.filtered(uv, |index| {
                Vec4::from_array(bytes[index].map(|byte| f32::from(byte) / 255.0))
            }),
            Pixels::Floats(floats) => self.filtered(uv, |index| Vec4::from_array(floats[index])),
            Pixels::SharedExponent(packed) => self.filtered(uv, |index| unpacked(packed[index])),
        }
    }

    /// The linear colour of one pixel, `x < width` and `y < height`.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    #[must_use]
    pub fn color_at(&self, x: u32, y: u32) -> Vec4 {
        let index = y as usize * self.width as usize + x as usize;
        match &self.pixels {
            Pixels::Bytes(bytes) => linear_color(&LINEAR_FROM_SRGB, bytes[index]),
            Pixels::Floats(floats) => Vec4::from_array(floats[index]),
            Pixels::SharedExponent(packed) => unpacked(packed[index]),
        }
    }

    /// `at` gives the pixel of an index.
    #[inline]
    fn filtered(&self, uv: Vec2, at: impl Fn(usize) -> Vec4) -> Vec4 {
        if self.width == 0 || self.height == 0 {
            return Vec4::ONE;
        }
        let (x0, x1, s) = neighbours(uv.x, self.width);
        let (y0, y1, t) = neighbours(uv.y, self.height);
        let (row0, row1) = (y0 * self.width as usize, y1 * self.width as usize);
        at(row0 + x0) * ((1.0 - s) * (1.0 - t))
            + at(row1 + x0) * ((1.0 - s) * t)
            + at(row0 + x1) * (s * (1.0 - t))
            + at(row1 + x1) * (s * t)
    }
}

/// A pixel of bytes as a colour.
#[inline]
fn linear_color(linear: &[f32; 256], [r, g, b, a]: [u8; 4]) -> Vec4 {
    let [r, g, b] = [r, g, b].map(|byte| linear[usize::from(byte)]);
    Vec4::new(r, g, b, f32::from(a) / 255.0)
}

/// The two pixels around a coordinate, and how far it is on the way from the first to the second.
#[inline]
fn neighbours(coordinate: f32, size: u32) -> (usize, usize, f32) {
    let place = (coordinate - coordinate.floor()) * size as f32;
    // A NaN becomes 0 here; a fraction that rounds up to 1 stays in the last pixel.
    let first = (place as u32).min(size - 1);
    let fraction = place - first as f32;
    let second = if first + 1 < size { first + 1 } else { 0 };
    (first as usize, second as usize, if fraction.is_finite() { fraction } else { 0.0 })
}

/// Of each byte.
pub(crate) static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0)));

/// The sRGB transfer function (IEC 61966-2-1), from encoded to linear.
pub(crate) fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`linear_from_srgb`].
pub(crate) fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
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
        let fits = [0.5, 0.25, 2.0, 1.0];
        assert!(matches!(Pixels::Floats(vec![fits; 3]).packed(), Pixels::SharedExponent(_)));
        let mixed = Pixels::Floats(vec![fits, [0.1, 0.2, 0.3, 1.0]]).packed();
        assert!(matches!(mixed, Pixels::Floats(floats) if floats[0] == fits));
    }
}
