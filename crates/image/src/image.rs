//! The image type of the workspace.

use crate::color::{linear_from_srgb_table, srgb_from_linear};

/// An image in linear RGB with BT.709 primaries, row by row from the top.
///
/// Channels have no upper limit: 1 is the white of a screen, and light sources are brighter. Alpha
/// is coverage, 1 where the image is opaque. No function of this crate multiplies or divides
/// colours by alpha: what a pixel holds is what a file gets.
///
/// The fields are public and may be set freely. Functions that can fail refuse an image that does
/// not hold `width * height` pixels; those that say so panic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// `width * height` pixels: red, green, blue and alpha.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    /// Returns an opaque black image.
    ///
    /// # Panics
    ///
    /// If a vector cannot hold so many pixels, as [`Vec::with_capacity`].
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self::from_fn(width, height, |_, _| [0.0, 0.0, 0.0, 1.0])
    }

    /// Returns the image whose pixel in column `x` and row `y` is `pixel(x, y)`.
    ///
    /// # Panics
    ///
    /// If a vector cannot hold so many pixels, as [`Vec::with_capacity`].
    #[must_use]
    pub fn from_fn(width: u32, height: u32, mut pixel: impl FnMut(u32, u32) -> [f32; 4]) -> Self {
        let mut pixels = Vec::with_capacity(area(width, height));
        for y in 0..height {
            pixels.extend((0..width).map(|x| pixel(x, y)));
        }
        Self { width, height, pixels }
    }

    /// Returns the opaque image whose 8-bit sRGB colour in column `x` and row `y` is `srgb(x, y)`.
    ///
    /// [`Self::srgb_bytes`] gives the same bytes back.
    ///
    /// # Panics
    ///
    /// If a vector cannot hold so many pixels, as [`Vec::with_capacity`].
    #[must_use]
    pub fn from_srgb_fn(
        width: u32,
        height: u32,
        mut srgb: impl FnMut(u32, u32) -> [u8; 3],
    ) -> Self {
        let linear = linear_from_srgb_table();
        Self::from_fn(width, height, |x, y| {
            let [r, g, b] = srgb(x, y).map(|byte| linear[usize::from(byte)]);
            [r, g, b, 1.0]
        })
    }

    /// Returns the pixel in column `x` and row `y`.
    ///
    /// # Panics
    ///
    /// If the image has no such pixel.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        assert!(x < self.width && y < self.height, "no pixel at {x}, {y}");
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Returns all pixels in 8-bit sRGB, as a screen or a PNG file gets them: values are clipped to
    /// `0.0..=1.0`, and NaN becomes 0. Alpha is not encoded by sRGB but only scaled.
    #[must_use]
    pub fn srgb_bytes(&self) -> Vec<[u8; 4]> {
        // The cast of a NaN gives 0.
        let byte = |x: f32| (x * 255.0).round() as u8;
        let pixel = |&[r, g, b, a]: &[f32; 4]| {
            let [r, g, b] = [r, g, b].map(|channel| byte(srgb_from_linear(channel)));
            [r, g, b, byte(a.clamp(0.0, 1.0))]
        };
        self.pixels.iter().map(pixel).collect()
    }

    /// Returns the opaque image of these pixels before a background, with red, green and blue that
    /// are premultiplied by alpha, as in films.
    #[must_use]
    pub fn before(&self, background: [f32; 3]) -> Self {
        let pixel = |&[r, g, b, a]: &[f32; 4]| {
            let share = 1.0 - a.clamp(0.0, 1.0);
            let [behind_r, behind_g, behind_b] = background.map(|channel| share * channel);
            [r + behind_r, g + behind_g, b + behind_b, 1.0]
        };
        Self { pixels: self.pixels.iter().map(pixel).collect(), ..*self }
    }

    /// Returns the part with its upper left corner at `(left, top)`, cut where the image ends.
    ///
    /// # Panics
    ///
    /// If this image does not hold `width * height` pixels.
    #[must_use]
    pub fn crop(&self, left: u32, top: u32, width: u32, height: u32) -> Self {
        self.assert_whole();
        let (left, top) = (left.min(self.width), top.min(self.height));
        let (width, height) = (width.min(self.width - left), height.min(self.height - top));
        Self::from_fn(width, height, |x, y| self.pixel(left + x, top + y))
    }

    /// Returns the image scaled down to `width` by `height` pixels. Each pixel is the mean, in
    /// linear light, of the area that it covers. A side that would grow repeats pixels instead.
    ///
    /// # Panics
    ///
    /// If this image has no pixels but the result should, or does not hold `width * height` pixels,
    /// or a vector cannot hold those of the result.
    #[must_use]
    pub fn resized(&self, width: u32, height: u32) -> Self {
        self.assert_whole();
        if width == 0 || height == 0 {
            return Self { width, height, pixels: Vec::new() };
        }
        assert!(self.width > 0 && self.height > 0, "no pixels to resize");
        let columns = coverage(self.width, width);
        let rows = coverage(self.height, height);
        // The filter is separable: along the rows first, then along the columns.
        let mut narrow = Vec::with_capacity(area(width, self.height));
        for y in 0..self.height as usize {
            let row = &self.pixels[y * self.width as usize..][..self.width as usize];
            narrow.extend(columns.iter().map(|weights| mean(weights, |x| row[x])));
        }
        let mut pixels = Vec::with_capacity(area(width, height));
        for weights in &rows {
            let columns = 0..width as usize;
            pixels.extend(columns.map(|x| mean(weights, |y| narrow[y * width as usize + x])));
        }
        Self { width, height, pixels }
    }

    /// Returns true if there are as many pixels as width and height say.
    pub(crate) fn is_whole(&self) -> bool {
        self.pixels.len() as u64 == u64::from(self.width) * u64::from(self.height)
    }

    fn assert_whole(&self) {
        let Self { width, height, pixels } = self;
        assert!(self.is_whole(), "an image of {width} x {height} holds {} pixels", pixels.len());
    }
}

/// Returns the number of pixels, or the largest number if that is larger.
fn area(width: u32, height: u32) -> usize {
    (width as usize).saturating_mul(height as usize)
}

/// For each of `to` intervals that divide `from` pixels evenly: the pixels that it covers, and
/// their shares.
fn coverage(from: u32, to: u32) -> Vec<Vec<(usize, f32)>> {
    let scale = f64::from(from) / f64::from(to);
    let interval = |i: u32| {
        let (start, end) = (f64::from(i) * scale, f64::from(i + 1) * scale);
        let last = (end.ceil() as usize).clamp(start as usize + 1, from as usize);
        let share = |x: usize| {
            let (left, right) = (start.max(x as f64), end.min((x + 1) as f64));
            (x, ((right - left) / (end - start)) as f32)
        };
        (start as usize..last).map(share).collect()
    };
    (0..to).map(interval).collect()
}

fn mean(weights: &[(usize, f32)], pixel: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
    let mut sum = [0.0; 4];
    for &(index, weight) in weights {
        let pixel = pixel(index);
        for (sum, channel) in sum.iter_mut().zip(pixel) {
            *sum += weight * channel;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_bit_srgb_value_comes_back() {
        let image = Image::from_srgb_fn(256, 1, |x, _| [x as u8; 3]);
        for (x, pixel) in image.srgb_bytes().into_iter().enumerate() {
            assert_eq!(pixel, [x as u8, x as u8, x as u8, 255]);
        }
    }

    #[test]
    fn srgb_bytes_are_clipped_and_nan_is_black() {
        let pixels = vec![[f32::NAN, 7.0, -1.0, 2.0], [0.0, 0.5, 1.0, f32::NAN]];
        let image = Image { width: 2, height: 1, pixels };
        assert_eq!(image.srgb_bytes(), [[0, 255, 0, 255], [0, 188, 255, 0]]);
    }

    #[test]
    fn a_resized_image_keeps_its_light() {
        let value = |x: u32, y: u32| (3 * x + 7 * y) as f32;
        let image = Image::from_fn(10, 9, |x, y| [value(x, y), 1.0, 0.0, 1.0]);
        for (width, height) in [(10, 9), (5, 3), (4, 2), (1, 1), (7, 20)] {
            let small = image.resized(width, height);
            assert_eq!((small.width, small.height), (width, height));
            let light = |image: &Image| {
                let sum: f32 = image.pixels.iter().map(|pixel| pixel[0]).sum();
                sum / image.pixels.len() as f32
            };
            assert!((light(&small) - light(&image)).abs() < 1e-3, "{width} x {height}");
            assert!(small.pixels.iter().all(|pixel| (pixel[1] - 1.0).abs() < 1e-5));
        }
        assert_eq!(image.resized(10, 9), image);
        assert_eq!(image.resized(5, 9).pixel(1, 2)[0], 0.5 * (value(2, 2) + value(3, 2)));
    }

    #[test]
    fn a_crop_ends_where_the_image_does() {
        let image = Image::from_fn(4, 3, |x, y| [x as f32, y as f32, 0.0, 1.0]);
        let crop = image.crop(3, 1, 5, 1);
        assert_eq!((crop.width, crop.height), (1, 1));
        assert_eq!(crop.pixels, [[3.0, 1.0, 0.0, 1.0]]);
        assert!(image.crop(9, 9, 2, 2).pixels.is_empty());
    }

    #[test]
    #[should_panic(expected = "an image of 4 x 3 holds 11 pixels")]
    fn an_image_with_missing_pixels_has_no_part() {
        let mut image = Image::new(4, 3);
        image.pixels.pop();
        let _ = image.crop(0, 0, 1, 1);
    }
}
