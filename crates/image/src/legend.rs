//! A scale of colours with words, drawn below a map.

use font8x8::UnicodeFonts as _;
use image::{Rgb, RgbImage};

/// Side of a glyph of the font, in pixels.
const GLYPH: u32 = 8;
const WHITE: Rgb<u8> = Rgb([255; 3]);
const BLACK: Rgb<u8> = Rgb([0; 3]);

/// Puts a legend below `map`: a title, the colours of a scale from left to right, and three labels
/// at its start, middle and end. Narrow maps get a white margin to the right of them.
pub fn below(
    map: RgbImage,
    title: &str,
    labels: &[String; 3],
    color: fn(f64) -> [u8; 3],
) -> RgbImage {
    // Letters grow with the picture, so that they can be read when it is shown to fit a screen.
    let scale = (map.width() / 600).max(1);
    let unit = GLYPH * scale;
    let words = labels.iter().map(String::len).sum::<usize>() + 4;
    let narrowest = (words.max(title.len()) as u32 + 2) * unit;
    let (width, height) = (map.width().max(narrowest), map.height());
    let mut image = RgbImage::from_pixel(width, height + 7 * unit, WHITE);
    image::imageops::replace(&mut image, &map, 0, 0);

    let bar = Bar { left: unit, right: width - unit, top: height + 2 * unit + unit / 2 };
    text(&mut image, title, bar.left, height + unit, scale);
    for y in bar.top..bar.top + 2 * unit {
        for x in bar.left..bar.right {
            let t = f64::from(x - bar.left) / f64::from(bar.right - 1 - bar.left);
            image.put_pixel(x, y, Rgb(color(t)));
        }
    }
    let [start, middle, end] = labels;
    let label_top = bar.top + 2 * unit + unit / 2;
    let wide = |label: &str| label.len() as u32 * unit;
    text(&mut image, start, bar.left, label_top, scale);
    text(&mut image, middle, (bar.left + bar.right - wide(middle)) / 2, label_top, scale);
    text(&mut image, end, bar.right - wide(end), label_top, scale);
    image
}

/// Where the scale of colours is drawn.
struct Bar {
    left: u32,
    right: u32,
    top: u32,
}

/// Draws ASCII text with its upper left corner at `(left, top)`.
fn text(image: &mut RgbImage, text: &str, left: u32, top: u32, scale: u32) {
    for (index, character) in text.chars().enumerate() {
        let Some(rows) = font8x8::BASIC_FONTS.get(character) else { continue };
        for y in 0..GLYPH * scale {
            for x in 0..GLYPH * scale {
                if rows[(y / scale) as usize] >> (x / scale) & 1 == 1 {
                    image.put_pixel(left + index as u32 * GLYPH * scale + x, top + y, BLACK);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_a_map_of_one_pixel_gets_a_whole_legend_and_keeps_its_pixel() {
        let red = Rgb([255, 0, 0]);
        let labels = ["-0.5", "0", "+0.5"].map(str::to_owned);
        let map = RgbImage::from_pixel(1, 1, red);
        let image = below(map, "a title", &labels, |t| [(t * 255.0) as u8; 3]);
        assert_eq!(*image.get_pixel(0, 0), red);
        let black = |pixels: &RgbImage| pixels.pixels().filter(|&&pixel| pixel == BLACK).count();
        assert!(image.width() > 80 && black(&image) > 100, "{} wide", image.width());
    }
}
