//! Image files: what is written comes back, and what is no image is refused by name.

#![cfg(feature = "codecs")]

use rotund_image::{Format, Image, Samples, decode, encode};
use std::error::Error;

/// An image with values beyond white and a transparent pixel.
fn example() -> Image {
    Image::from_fn(7, 5, |x, y| {
        let alpha = if (x, y) == (0, 0) { 0.25 } else { 1.0 };
        [0.15 * x as f32, 0.2 * y as f32, if x == y { 20.0 } else { 0.5 }, alpha]
    })
}

#[test]
fn what_is_written_comes_back_as_exactly_as_the_format_can_hold() {
    let folder = tempfile::tempdir().unwrap();
    let image = example();
    let table = [
        // Name, largest error relative to 1 or the value, keeps what is beyond 1, keeps alpha.
        ("a.exr", 0.0, true, true),
        ("a.hdr", 1.0 / 128.0, true, false),
        ("A.PNG", 0.005, false, true),
        ("a.jpg", 0.35, false, false),
    ];
    for (name, allowed, hdr, alpha) in table {
        let path = folder.path().join(name);
        image.write(&path).unwrap();
        let back = Image::read(&path).unwrap();
        assert_eq!((back.width, back.height), (image.width, image.height), "{name}");
        for (&expected, &found) in image.pixels.iter().zip(&back.pixels) {
            for channel in 0..3 {
                let limit = if hdr { f32::INFINITY } else { 1.0 };
                let expected = expected[channel].min(limit);
                // HDR files share the exponent of the largest channel.
                let scale = if hdr { 20.0 } else { 1.0 };
                let off = (expected - found[channel]).abs();
                assert!(off <= allowed * scale, "{name}: {found:?} for {expected:?}");
            }
            let expected = if alpha { expected[3] } else { 1.0 };
            assert!((found[3] - expected).abs() < 0.003, "{name}");
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), table.len());
}

#[test]
fn an_hdr_file_clips_what_it_cannot_hold() {
    let largest = 255.0 * 2.0_f32.powi(119);
    let table = [
        (f32::INFINITY, largest),
        (f32::MAX, largest),
        (2.0_f32.powi(127), largest),
        (largest, largest),
        (2.0_f32.powi(126), 2.0_f32.powi(126)),
        (f32::NAN, 0.0),
        (-1.0, 0.0),
        (f32::NEG_INFINITY, 0.0),
        (2.0_f32.powi(-126), 2.0_f32.powi(-126)),
        (2.0_f32.powi(-128), 2.0_f32.powi(-128)),
        (2.0_f32.powi(-130), 0.0),
        (1e-45, 0.0),
    ];
    for (written, expected) in table {
        for channel in 0..3 {
            let mut pixel = [0.0, 0.0, 0.0, 1.0];
            pixel[channel] = written;
            let image = Image { width: 1, height: 1, pixels: vec![pixel] };
            let bytes = encode(&image, Format::Hdr).unwrap();
            pixel[channel] = expected;
            let back = Image::from(decode(&bytes, Format::Hdr).unwrap());
            assert_eq!(back.pixels, [pixel], "{written}");
        }
    }
}

#[test]
fn the_content_of_a_file_decides_on_its_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("named.png");
    std::fs::write(&path, encode(&example(), Format::Exr).unwrap()).unwrap();
    assert_eq!(Image::read(&path).unwrap(), example());
}

#[test]
fn formats_are_known_by_their_content_or_named() {
    for format in [Format::Png, Format::Jpeg, Format::Hdr, Format::Exr] {
        assert_eq!(Format::of_content(&encode(&example(), format).unwrap()), Ok(format));
    }
    let bitmap = image::RgbImage::from_pixel(2, 1, image::Rgb([9, 8, 7]));
    for (kind, format) in
        [(image::ImageFormat::Bmp, Format::Bmp), (image::ImageFormat::Tga, Format::Tga)]
    {
        let mut bytes = std::io::Cursor::new(Vec::new());
        bitmap.write_to(&mut bytes, kind).unwrap();
        let bytes = bytes.into_inner();
        assert_eq!(Format::of_content(&bytes), Ok(format));
        let expected = Samples::Srgb8(vec![[9, 8, 7, 255]; 2]);
        assert_eq!(decode(&bytes, format).unwrap().samples, expected);
        assert!(encode(&example(), format).is_err(), "only read");
    }
    for (bytes, words) in [
        (&b"GIF89a"[..], "is a GIF image, expected PNG"),
        (b"RIFF\x01\0\0\0WEBPVP8 ", "is a WebP image"),
        (b"II*\0abcd", "is a TIFF image"),
        (b"\0\0\0\x18ftypavif", "is an AVIF image"),
        (b"", "is empty"),
        (b"<!DOCTYPE html><html>", "is no image"),
        (&[0; 64], "is no image"),
    ] {
        let error = Format::of_content(bytes).unwrap_err();
        assert!(error.problem.contains(words), "{error}");
    }
}

#[test]
fn sixteen_bits_of_a_png_are_kept() {
    let words: Vec<u16> = (0..12).map(|i| 5000 * i).collect();
    let buffer = image::ImageBuffer::<image::Rgb<u16>, _>::from_raw(4, 1, words).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::DynamicImage::ImageRgb16(buffer).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let decoded = decode(&bytes.into_inner(), Format::Png).unwrap();
    let expected = vec![
        [0, 5000, 10_000, 65_535],
        [15_000, 20_000, 25_000, 65_535],
        [30_000, 35_000, 40_000, 65_535],
        [45_000, 50_000, 55_000, 65_535],
    ];
    assert_eq!(decoded.samples, Samples::Srgb16(expected));
    let linear = Image::from(decoded).pixels[1][0];
    assert!((linear - rotund_image::linear_from_srgb(15_000.0 / 65_535.0)).abs() < 1e-7);
}

/// The message of an error and of all its causes.
fn all_words(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        words = format!("{words}: {error}");
        cause = error.source();
    }
    words
}

#[test]
fn errors_name_the_file_and_each_cause_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for format in ["png", "jpg", "hdr", "exr"] {
        let name = format!("cut.{format}");
        example().write(path(&name)).unwrap();
        let bytes = std::fs::read(path(&name)).unwrap();
        std::fs::write(path(&name), &bytes[..bytes.len() / 2]).unwrap();
        let text = all_words(&Image::read(path(&name)).unwrap_err());
        assert!(text.contains(&name), "{text}");
        let causes: Vec<&str> = text.split(": ").collect();
        let once = causes.iter().enumerate().all(|(i, cause)| !causes[..i].contains(cause));
        assert!(once, "{text}");
        std::fs::write(path(&name), b"no image").unwrap();
        assert!(Image::read(path(&name)).is_err(), "{name}");
    }
    let missing = all_words(&Image::read(path("missing.png")).unwrap_err());
    assert!(missing.contains("missing.png") && missing.contains("os error 2"), "{missing}");
    for name in ["a.tiff", "a.bmp", "a.tga"] {
        let text = all_words(&example().write(path(name)).unwrap_err());
        assert!(text.contains(name) && text.contains("png, jpg, hdr and exr"), "{text}");
    }
    let nowhere = all_words(&example().write(path("no/such/folder.png")).unwrap_err());
    assert!(nowhere.contains("folder.png"), "{nowhere}");
}

#[test]
fn an_image_that_is_not_whole_is_refused_and_the_old_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let short = Image { width: 9, ..example() };
    for name in ["a.png", "a.jpg", "a.hdr", "a.exr"] {
        let path = folder.path().join(name);
        example().write(&path).unwrap();
        let before = std::fs::read(&path).unwrap();
        for image in [&short, &Image::default()] {
            let text = all_words(&image.write(&path).unwrap_err());
            assert!(text.contains(name) && text.contains("pixels"), "{text}");
        }
        assert_eq!(std::fs::read(&path).unwrap(), before);
    }
}

#[test]
fn a_size_that_a_file_cannot_hold_is_refused_before_it_is_allocated() {
    let mut bytes = encode(&example(), Format::Hdr).unwrap();
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let at = text.find("-Y 5 +X 7").unwrap();
    bytes.splice(at..at + 9, b"-Y 16000 +X 16000".iter().copied());
    let error = decode(&bytes, Format::Hdr).unwrap_err();
    assert!(error.problem.contains("16000 x 16000"), "{error}");
}
