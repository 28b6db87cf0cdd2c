//! From radiance to the colours of a screen, and to bytes.

use crate::settings::Settings;
use rotund_image::{EncodeError, Format, Image, encode};
use std::borrow::Cow;

/// How radiance becomes colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tone {
    /// Factor of the radiance.
    scale: f32,
    filmic: bool,
}

impl Tone {
    pub(crate) fn of(settings: &Settings) -> Self {
        Self { scale: settings.exposure.exp2(), filmic: settings.filmic }
    }

    /// Returns the image as it is shown: a copy, if exposure or curve change it.
    pub(crate) fn apply(self, image: &Image) -> Cow<'_, Image> {
        if self == (Self { scale: 1.0, filmic: false }) {
            return Cow::Borrowed(image);
        }
        let mut image = image.clone();
        for [r, g, b, _] in &mut image.pixels {
            for channel in [r, g, b] {
                *channel *= self.scale;
                if self.filmic {
                    *channel = filmic(*channel);
                }
            }
        }
        Cow::Owned(image)
    }
}

/// Maps radiance to `0.0..1.0` by a curve that is steep in the middle and flat for highlights: the
/// rational fit of the reference curve of ACES by Narkowicz (2015), which is scaled such that a
/// middle grey stays one.
fn filmic(x: f32) -> f32 {
    let x = 0.6 * x.max(0.0);
    // From here on the curve is flat, and the squares would overflow.
    if x > 1e6 { 1.0 } else { (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0) }
}

/// Encodes a picture for a screen, exactly or in fewer bytes; returns the bytes and their media
/// type. Pictures with transparent pixels are always exact, since JPEG has none.
pub(crate) fn encoded(image: &Image, exact: bool) -> Result<(Vec<u8>, &'static str), EncodeError> {
    let exact = exact || image.pixels.iter().any(|pixel| pixel[3] < 1.0);
    if exact {
        Ok((encode(image, Format::Png)?, "image/png"))
    } else {
        Ok((encode(image, Format::Jpeg)?, "image/jpeg"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_without_exposure_and_curve_is_the_film_to_the_bit() {
        let image = Image::from_fn(3, 2, |x, y| [x as f32 * 0.3, y as f32, 7.5, 0.5]);
        assert_eq!(*Tone::of(&Settings::default()).apply(&image), image);
    }

    #[test]
    fn a_stop_doubles_radiance_and_keeps_alpha() {
        let image = Image::from_fn(1, 1, |_, _| [0.1, 0.2, 0.3, 0.4]);
        let tone = Tone::of(&Settings { exposure: 1.0, ..Settings::default() });
        assert_eq!(tone.apply(&image).pixels, [[0.2, 0.4, 0.6, 0.4]]);
    }

    #[test]
    fn the_filmic_curve_rises_from_black_to_at_most_white() {
        assert_eq!(filmic(0.0), 0.0);
        let mut last = 0.0;
        for step in 1..2000 {
            let value = filmic(1.01_f32.powi(step - 1000));
            assert!(value >= last && value <= 1.0, "{step}: {value} after {last}");
            last = value;
        }
        assert!((filmic(0.18) - 0.18).abs() < 0.06, "{}", filmic(0.18));
        assert_eq!(filmic(f32::INFINITY), 1.0);
    }

    #[test]
    fn transparent_pictures_are_encoded_exactly() {
        let opaque = Image::from_fn(4, 4, |_, _| [0.5, 0.5, 0.5, 1.0]);
        let clear = Image::from_fn(4, 4, |x, _| [0.5, 0.5, 0.5, x as f32 / 3.0]);
        for (image, exact, media) in [
            (&opaque, false, "image/jpeg"),
            (&opaque, true, "image/png"),
            (&clear, false, "image/png"),
        ] {
            assert_eq!(encoded(image, exact).expect("an image").1, media);
        }
    }
}
