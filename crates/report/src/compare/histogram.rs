//! Histograms in SVG.

use rotund_image::{Image, Plane, luminance, srgb_from_linear};

const BINS: usize = 64;
/// Size of the drawing in its own units, and the room below and to the left for numbers.
const SIZE: (f64, f64) = (600.0, 200.0);
const FOOT: f64 = 24.0;
const SIDE: f64 = 56.0;

/// Draws the histograms of the sRGB lightness of two pictures, from black to white.
pub(super) fn of_lightness([first, second]: [&Image; 2]) -> String {
    let lightness = |picture: &Image| {
        let shown = |&pixel| f64::from(srgb_from_linear(luminance(pixel)));
        count(picture.pixels.iter().map(shown))
    };
    let curves = [("first", lightness(first)), ("second", lightness(second))];
    draw(&curves, ["0", "0.5", "1"])
}

/// Draws the histogram of the FLIP error of all pixels.
pub(super) fn of_flip(flip: &Plane) -> String {
    draw(&[("flip", count(flip.values.iter().map(|&value| f64::from(value))))], ["0", "0.5", "1"])
}

/// Returns the number of values in each of [`BINS`] parts of `0.0..=1.0`.
fn count(values: impl Iterator<Item = f64>) -> [u32; BINS] {
    let mut bins = [0; BINS];
    for value in values {
        // The cast of a NaN gives 0, so it counts in the first bin.
        bins[((value * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    bins
}

/// Draws steps over the bins. The scale of counts is logarithmic, so that few pixels are visible
/// beside many.
fn draw(curves: &[(&str, [u32; BINS])], ticks: [&str; 3]) -> String {
    let (width, height) = SIZE;
    let most = curves.iter().flat_map(|(_, bins)| bins).copied().max().unwrap_or(0).max(1);
    let level = |count: u32| height * (1.0 - f64::from(count).ln_1p() / f64::from(most).ln_1p());
    let mut svg = format!(
        "<svg class=\"histogram\" viewBox=\"-{SIDE} -8 {} {}\" role=\"img\" \
         aria-label=\"Histogram\">",
        SIDE + width + 4.0,
        height + FOOT + 8.0
    );
    // Grid lines at powers of ten.
    let mut power = 1_u32;
    while power <= most {
        let y = level(power);
        svg += &format!(
            "<line class=\"grid\" x1=\"0\" x2=\"{width}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>\
             <text x=\"-6\" y=\"{:.1}\" text-anchor=\"end\">{power}</text>",
            y + 5.0
        );
        let Some(next) = power.checked_mul(10) else { break };
        power = next;
    }
    for (name, bins) in curves {
        let mut path = format!("M0 {height}");
        for (bin, &count) in bins.iter().enumerate() {
            path += &format!("V{:.1}H{:.1}", level(count), width * (bin + 1) as f64 / BINS as f64);
        }
        svg += &format!("<path class=\"{name}\" d=\"{path}V{height}Z\"/>");
    }
    for (tick, (x, anchor)) in
        ticks.into_iter().zip([(0.0, "start"), (0.5 * width, "middle"), (width, "end")])
    {
        let y = height + FOOT - 6.0;
        svg += &format!("<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">{tick}</text>");
    }
    svg + "</svg>"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_once_and_those_beyond_the_ends_at_the_ends() {
        let bins = count([0.0, -1.0, f64::NAN, 0.5, 1.0, 7.0, 0.999].into_iter());
        assert_eq!((bins[0], bins[BINS / 2], bins[BINS - 1]), (3, 1, 3));
        assert_eq!(bins.iter().sum::<u32>(), 7);
    }

    #[test]
    fn an_empty_histogram_is_a_complete_drawing() {
        let svg = of_flip(&Plane { width: 0, height: 0, values: Vec::new() });
        assert!(
            svg.starts_with("<svg") && svg.ends_with("</svg>") && !svg.contains("NaN"),
            "{svg}"
        );
    }
}
