//! Colours of a background on the command line.

use rotund_image::linear_from_srgb;

/// A colour in linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Background(pub(crate) [f32; 3]);

/// Parses a name or the hexadecimal digits of an sRGB colour.
pub(crate) fn parse(text: &str) -> Result<Background, String> {
    let word = text.to_ascii_lowercase();
    let digits = match word.as_str() {
        "white" => "ffffff",
        "black" => "000000",
        "grey" | "gray" => "808080",
        other => other.strip_prefix('#').unwrap_or(other),
    };
    let nibbles: Option<Vec<u32>> = digits.chars().map(|digit| digit.to_digit(16)).collect();
    let bytes = match nibbles.as_deref() {
        Some(&[r, g, b]) => [17 * r, 17 * g, 17 * b],
        Some(&[r, s, g, h, b, c]) => [16 * r + s, 16 * g + h, 16 * b + c],
        _ => return Err("a colour is white, black, grey, #rgb or #rrggbb".to_owned()),
    };
    Ok(Background(bytes.map(|byte| linear_from_srgb(byte as f32 / 255.0))))
}

#[cfg(test)]
mod tests {
    use super::{Background, parse};

    #[test]
    fn a_colour_has_a_name_or_three_or_six_digits() {
        for (text, expected) in [
            ("white", [1.0; 3]),
            ("Black", [0.0; 3]),
            ("#f00", [1.0, 0.0, 0.0]),
            ("00ff00", [0.0, 1.0, 0.0]),
            ("grey", [0.215_860_5; 3]),
            ("#808080", [0.215_860_5; 3]),
        ] {
            let Background(found) = parse(text).expect(text);
            let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(close, "{text}: {found:?}");
        }
        for text in ["", "#", "#12", "#12345", "#1234567", "mauve", "#ggg", "ééé"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
