//! Denoising, where the library is there; messages, where it is not.

use rotund_denoise::{DenoiseError, Denoiser, Guides};
use rotund_image::Image;
use std::ffi::OsStr;

/// Two grey halves with an edge between them.
fn truth() -> Image {
    Image::from_fn(64, 48, |x, _| if x < 32 { [0.2, 0.2, 0.2, 1.0] } else { [0.7, 0.7, 0.7, 0.5] })
}

/// The same with noise of a known amount.
fn noisy() -> Image {
    let mut state = 1_u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut image = truth();
    for pixel in &mut image.pixels {
        let factor = 2.0 * random();
        pixel[..3].iter_mut().for_each(|channel| *channel *= factor);
    }
    image
}

fn error(image: &Image) -> f64 {
    let pairs = image.pixels.iter().zip(truth().pixels);
    pairs.map(|(a, b)| f64::from(a[0] - b[0]).powi(2)).sum::<f64>() / image.pixels.len() as f64
}

#[test]
fn a_denoised_picture_is_nearer_to_the_truth_and_keeps_alpha() {
    // Without the library there is nothing to test but its absence, below.
    let Ok(denoiser) = Denoiser::load() else { return };
    assert!(denoiser.version().starts_with("2."), "{}", denoiser.version());
    let noisy = noisy();
    let color = |[r, g, b, _]: &[f32; 4]| [*r, *g, *b];
    let albedo: Vec<_> = truth().pixels.iter().map(color).collect();
    let guides = Guides { normal: vec![[0.0, 0.0, 1.0]; albedo.len()], albedo };
    for guides in [Guides::default(), guides] {
        let clean = denoiser.denoise(&noisy, &guides).expect("denoised");
        assert!(error(&clean) < 0.1 * error(&noisy), "{} of {}", error(&clean), error(&noisy));
        assert!(clean.pixels.iter().zip(&noisy.pixels).all(|(a, b)| a[3] == b[3]));
        assert_eq!(clean, denoiser.denoise(&noisy, &guides).expect("denoised"), "each time");
    }
    let short = Guides { albedo: vec![[0.0; 3]; 5], ..Guides::default() };
    let refused = denoiser.denoise(&noisy, &short).expect_err("another size").to_string();
    assert_eq!(refused, "the albedo has 5 pixels, the picture 64 x 48");
}

#[test]
fn a_library_that_is_missing_or_another_one_is_an_error_of_one_sentence() {
    let error = Denoiser::open(OsStr::new("no-such-library.so")).expect_err("missing");
    assert!(matches!(error, DenoiseError::Missing { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("ROTUND_OIDN") && !text.contains('\n'), "{text}");
    #[cfg(target_os = "linux")]
    {
        let error = Denoiser::open(OsStr::new("libc.so.6")).expect_err("another library");
        assert!(matches!(error, DenoiseError::Unsuitable { .. }), "{error}");
    }
}
