//! Images on surfaces.

use glam::{Vec2, Vec4};
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
        self.filtered(uv, |x, y| self.color_at(x, y))
    }

    /// The numbers at `uv`: bytes are divided by 255 and nothing else. Filtered as [`Self::color`].
    #[must_use]
    pub fn data(&self, uv: Vec2) -> Vec4 {
        self.filtered(uv, |x, y| self.data_at(x, y))
    }

    /// The linear colour of one pixel, `x < width` and `y < height`.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    #[must_use]
    pub fn color_at(&self, x: u32, y: u32) -> Vec4 {
        match &self.pixels {
            Pixels::Bytes(bytes) => {
                let [r, g, b, a] = bytes[self.index(x, y)];
                let linear = &*LINEAR_FROM_SRGB;
                Vec4::new(
                    linear[usize::from(r)],
                    linear[usize::from(g)],
                    linear[usize::from(b)],
                    f32::from(a) / 255.0,
                )
            }
            Pixels::Floats(floats) => Vec4::from_array(floats[self.index(x, y)]),
        }
    }

    fn data_at(&self, x: u32, y: u32) -> Vec4 {
        match &self.pixels {
            Pixels::Bytes(bytes) => {
                Vec4::from_array(bytes[self.index(x, y)].map(|byte| f32::from(byte) / 255.0))
            }
            Pixels::Floats(floats) => Vec4::from_array(floats[self.index(x, y)]),
        }
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    fn filtered(&self, uv: Vec2, at: impl Fn(u32, u32) -> Vec4) -> Vec4 {
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

/// The two pixels around a coordinate, and how far it is on the way from the first to the second.
fn neighbours(coordinate: f32, size: u32) -> (u32, u32, f32) {
    let place = (coordinate - coordinate.floor()) * size as f32;
    // A NaN becomes 0 here; a fraction that rounds up to 1 stays in the last pixel.
    let first = (place as u32).min(size - 1);
    let fraction = place - first as f32;
    (first, (first + 1) % size, if fraction.is_finite() { fraction } else { 0.0 })
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
