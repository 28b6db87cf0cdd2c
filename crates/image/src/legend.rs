//! A scale of colours with labels, drawn below a map.

use crate::Image;
use font8x8::UnicodeFonts as _;

/// Side of a glyph of the font, in pixels.
const GLYPH: u32 = 8;
const WHITE: [f32; 4] = [1.0; 4];
const BLACK: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Returns `map` with a legend below: a title, the colours of a scale from left to right, and
/// labels at the start, the middle and the end of the scale. Narrow maps get a white margin at
/// their right.
pub(crate) fn below(
    map: &Image,
    title: &str,
    labels: &[String; 3],
    color: fn(f64) -> [u8; 3],
) -> Image {
    // Letters grow with the picture, so that they stay legible when it is scaled to fit a screen.
    let scale = (map.width / 600).max(1);
    let unit = GLYPH * scale;
    let length = |text: &str| text.chars().count() as u32;
    let words = labels.iter().map(|label| length(label)).sum::<u32>() + 4;
    let narrowest = (words.max(length(title)) + 2) * unit;
    let (width, height) = (map.width.max(narrowest), map.height);
    let (left, right, top) = (unit, width - unit, height + 2 * unit + unit / 2);
    let bar = Image::from_srgb_fn(right - left, 1, |x, _| {
        color(f64::from(x) / f64::from(right - 1 - left))
    });
    let mut image = Image::from_fn(width, height + 7 * unit, |x, y| {
        if x < map.width && y < map.height {
            map.pixel(x, y)
        } else if (left..right).contains(&x) && (top..top + 2 * unit).contains(&y) {
            bar.pixel(x - left, 0)
        } else {
            WHITE
        }
    });
    let [start, middle, end] = labels;
    let label_top = top + 2 * unit + unit / 2;
    let wide = |label: &str| length(label) * unit;
    text(&mut image, title, left, height + unit, scale);
    text(&mut image, start, left, label_top, scale);
    text(&mut image, middle, (left + right - wide(middle)) / 2, label_top, scale);
    text(&mut image, end, right - wide(end), label_top, scale);
    image
}

/// Draws ASCII text with its upper left corner at `(left, top)`.
fn text(image: &mut Image, text: &str, left: u32, top: u32, scale: u32) {
    for (index, character) in text.chars().enumerate() {
        let Some(rows) = font8x8::BASIC_FONTS.get(character) else { continue };
        for y in 0..GLYPH * scale {
            for x in 0..GLYPH * scale {
                if rows[(y / scale) as usize] >> (x / scale) & 1 == 1 {
                    let (x, y) = (left + index as u32 * GLYPH * scale + x, top + y);
                    image.pixels[(y * image.width + x) as usize] = BLACK;
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
        let red = [1.0, 0.0, 0.0, 1.0];
        let labels = ["-0.5", "0", "+0.5"].map(str::to_owned);
        let map = Image { width: 1, height: 1, pixels: vec![red] };
        let image = below(&map, "a title", &labels, |t| [(t * 255.0) as u8; 3]);
        assert_eq!(image.pixel(0, 0), red);
        let black = image.pixels.iter().filter(|&&pixel| pixel == BLACK).count();
        assert!(image.width > 80 && black > 100, "{} wide", image.width);
    }
}
