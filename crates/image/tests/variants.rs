//! Variants of HDR and EXR files that this crate does not write.

#![cfg(feature = "codecs")]

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, IntegerBounds, Layer,
    LayerAttributes, SmallVec, Text, WritableImage as _,
};
use rotund_image::{DecodeError, Format, Image, decode};

/// The pixels of a picture of 3 x 2 pixels, `[r, g, b]` of column `x` and row `y` from the top.
fn pixel(x: usize, y: usize) -> [u8; 3] {
    [128 + 10 * x as u8, 130 + 50 * y as u8, 200]
}

/// Returns the picture as an HDR file, with the axes of `size` as its scanlines.
fn hdr(header: &str, size: &str) -> Vec<u8> {
    let mut bytes = format!("{header}\n\n{size}\n").into_bytes();
    let words: Vec<&str> = size.split(' ').collect();
    let count = |axis: &str| if axis.ends_with('X') { 3 } else { 2 };
    // Where a step along an axis leads.
    let place = |axis: &str, step: usize| match axis {
        "+X" => step,
        "-X" => 2 - step,
        "-Y" => step,
        _ => 1 - step,
    };
    for i in 0..count(words[0]) {
        for j in 0..count(words[2]) {
            let [first, second] = [place(words[0], i), place(words[2], j)];
            let (x, y) = if words[0].ends_with('X') { (first, second) } else { (second, first) };
            bytes.extend(pixel(x, y));
            bytes.push(129);
        }
    }
    bytes
}

fn assert_is_picture(why: &str, image: &Image, scale: f32) {
    assert_eq!((image.width, image.height), (3, 2), "{why}");
    for (x, y) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)] {
        let [r, g, b] = pixel(x, y).map(|mantissa| scale * f32::from(mantissa) / 128.0);
        let found = image.pixel(x as u32, y as u32);
        let close = found.iter().zip([r, g, b, 1.0]).all(|(a, b)| (a - b).abs() < 0.02 * scale);
        assert!(close, "{why}: {found:?} at {x}, {y} is not {r} {g} {b}");
    }
}

const FORMAT: &str = "FORMAT=32-bit_rle_rgbe";

#[test]
fn an_hdr_file_may_have_any_signature_order_of_axes_and_exposure() {
    let usual = format!("#?RADIANCE\n{FORMAT}");
    for size in [
        "-Y 2 +X 3",
        "-Y 2 -X 3",
        "+Y 2 +X 3",
        "+Y 2 -X 3",
        "+X 3 -Y 2",
        "+X 3 +Y 2",
        "-X 3 -Y 2",
        "-X 3 +Y 2",
    ] {
        let image =
            decode(&hdr(&usual, size), Format::Hdr).unwrap_or_else(|e| panic!("{size}: {e}"));
        assert_is_picture(size, &image.into(), 1.0);
    }
    for (header, scale) in [
        (format!("#?RGBE\n{FORMAT}"), 1.0),
        (format!("#?RGBE\r\n# a=b\r\n{FORMAT}\r"), 1.0),
        ("#?RADIANCE\nSOFTWARE=x".to_owned(), 1.0),
        (format!("#?RADIANCE\nEXPOSURE=4.0\n{FORMAT}"), 0.25),
        (format!("#?RADIANCE\nEXPOSURE= 4\nEXPOSURE=0.5\n{FORMAT}"), 0.5),
        (format!("#?RADIANCE\nCOLORCORR=2 2 2\n{FORMAT}"), 0.5),
    ] {
        let bytes = hdr(&header, "-Y 2 +X 3");
        assert_eq!(Format::of_content(&bytes), Ok(Format::Hdr));
        let image = decode(&bytes, Format::Hdr).unwrap_or_else(|e| panic!("{header}: {e}"));
        assert_is_picture(&header, &image.into(), scale);
    }
    // Equal X, Y and Z are not white but about its colour with slightly more red.
    let xyz = decode(&hdr("#?RADIANCE\nFORMAT=32-bit_rle_xyze", "-Y 2 +X 3"), Format::Hdr);
    let [r, g, ..] = Image::from(xyz.expect("XYZE")).pixel(0, 0);
    let [x, y, z] = [128.0, 130.0, 200.0_f32].map(|mantissa| (mantissa + 0.5) / 128.0);
    assert!((r - (3.2406 * x - 1.5372 * y - 0.4986 * z)).abs() < 0.02, "{r}");
    assert!((g - (-0.9689 * x + 1.8758 * y + 0.0415 * z)).abs() < 0.02, "{g}");
}

#[test]
fn a_header_of_hdr_that_makes_no_sense_is_refused_with_its_line() {
    for (header, size, words) in [
        ("#?RADIANCE\nEXPOSURE=0", "-Y 2 +X 3", "EXPOSURE is \"0\""),
        ("#?RADIANCE\nEXPOSURE=bright", "-Y 2 +X 3", "EXPOSURE is \"bright\""),
        ("#?RADIANCE\nFORMAT=float", "-Y 2 +X 3", "\"float\""),
        ("#?RADIANCE", "-Y 2 +Y 3", "\"-Y 2 +Y 3\""),
        ("#?RADIANCE", "3 x 2 pixels", "\"3 x 2 pixels\""),
    ] {
        let mut bytes = hdr(header, "-Y 2 +X 3");
        let text = format!("{header}\n\n{size}\n");
        bytes.splice(..header.len() + 12, text.into_bytes());
        let error = decode(&bytes, Format::Hdr).expect_err(header);
        assert!(error.problem.contains(words), "{error}");
    }
}

/// Returns an EXR file with one value for each channel. `windows` are start and size of the data
/// and of the display.
fn exr(channels: &[(&str, f32)], windows: [([i32; 2], [usize; 2]); 2]) -> Vec<u8> {
    let [(start, size), (display_start, display_size)] = windows;
    let list: SmallVec<[_; 4]> = channels
        .iter()
        .map(|&(name, value)| {
            AnyChannel::new(name, FlatSamples::F32(vec![value; size[0] * size[1]]))
        })
        .collect();
    let attributes = LayerAttributes {
        layer_position: exr::math::Vec2(start[0], start[1]),
        ..LayerAttributes::named(Text::from("it"))
    };
    let channels = AnyChannels::sort(list);
    let layer = Layer::new((size[0], size[1]), attributes, Encoding::SMALL_LOSSLESS, channels);
    let display = IntegerBounds::new(
        exr::math::Vec2(display_start[0], display_start[1]),
        exr::math::Vec2(display_size[0], display_size[1]),
    );
    let attributes = exr::meta::header::ImageAttributes::new(display);
    let image = ExrImage::empty(attributes).with_layer(layer);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).expect("an EXR file");
    bytes.into_inner()
}

const SAME: [([i32; 2], [usize; 2]); 2] = [([0, 0], [2, 2]); 2];

#[test]
fn an_exr_file_fills_its_display_window() {
    const OPAQUE: &[(&str, f32)] = &[("R", 1.0), ("G", 2.0), ("B", 3.0)];
    const CLEAR: &[(&str, f32)] = &[("R", 1.0), ("G", 2.0), ("B", 3.0), ("A", 0.5)];
    let inside = [1.0, 2.0, 3.0, 1.0];
    let black = [0.0, 0.0, 0.0, 1.0];
    // Padded on all sides; the display window may start anywhere.
    let image = decode(&exr(OPAQUE, [([11, 21], [2, 1]), ([10, 20], [4, 3])]), Format::Exr);
    let image = Image::from(image.expect("padded"));
    assert_eq!((image.width, image.height), (4, 3));
    for (x, y) in (0..3).flat_map(|y| (0..4).map(move |x| (x, y))) {
        let expected = if y == 1 && (1..3).contains(&x) { inside } else { black };
        assert_eq!(image.pixel(x, y), expected, "{x}, {y}");
    }
    // Overscan is cut.
    let image = decode(&exr(OPAQUE, [([-2, -2], [6, 6]), ([0, 0], [2, 2])]), Format::Exr);
    assert_eq!(Image::from(image.expect("cut")).pixels, [inside; 4]);
    let image = decode(&exr(CLEAR, [([5, 5], [1, 1]), ([0, 0], [2, 1])]), Format::Exr);
    assert_eq!(Image::from(image.expect("apart")).pixels, [[0.0; 4]; 2], "transparent outside");
}

#[test]
fn a_display_window_that_a_file_cannot_fill_is_refused() {
    let bytes = exr(&[("Y", 1.0)], [([0, 0], [1, 1]), ([0, 0], [15_000, 15_000])]);
    let error = decode(&bytes, Format::Exr).expect_err("refused");
    assert!(error.problem.contains("display window") && error.problem.contains("15000"), "{error}");
}

#[test]
fn the_colours_of_an_exr_file_may_be_in_a_layer() {
    let of = |channels: &[(&str, f32)]| -> Result<[f32; 4], DecodeError> {
        decode(&exr(channels, SAME), Format::Exr).map(|decoded| Image::from(decoded).pixel(0, 0))
    };
    type Channels<'a> = &'a [(&'a str, f32)];
    let table: [(&str, Channels<'_>, [f32; 4]); 6] = [
        (
            "Blender",
            &[
                ("ViewLayer.Combined.A", 0.5),
                ("ViewLayer.Combined.B", 3.0),
                ("ViewLayer.Combined.G", 2.0),
                ("ViewLayer.Combined.R", 1.0),
                ("ViewLayer.Depth.Z", 9.0),
                ("ViewLayer.Normal.X", 7.0),
                ("ViewLayer.DiffCol.R", 7.0),
                ("ViewLayer.DiffCol.G", 7.0),
                ("ViewLayer.DiffCol.B", 7.0),
            ],
            [1.0, 2.0, 3.0, 0.5],
        ),
        (
            "channels without a layer come first",
            &[
                ("R", 1.0),
                ("G", 2.0),
                ("B", 3.0),
                ("x.Combined.R", 7.0),
                ("x.Combined.G", 7.0),
                ("x.Combined.B", 7.0),
            ],
            [1.0, 2.0, 3.0, 1.0],
        ),
        (
            "the only layer with colours",
            &[("main.R", 1.0), ("main.G", 2.0), ("main.B", 3.0), ("depth.Z", 4.0)],
            [1.0, 2.0, 3.0, 1.0],
        ),
        (
            "beauty among others",
            &[
                ("a.R", 7.0),
                ("a.G", 7.0),
                ("a.B", 7.0),
                ("beauty.R", 1.0),
                ("beauty.G", 2.0),
                ("beauty.B", 3.0),
            ],
            [1.0, 2.0, 3.0, 1.0],
        ),
        ("small letters", &[("r", 1.0), ("g", 2.0), ("b", 3.0), ("a", 0.5)], [1.0, 2.0, 3.0, 0.5]),
        ("luminance", &[("Y", 2.0), ("Z", 7.0)], [2.0, 2.0, 2.0, 1.0]),
    ];
    for (why, channels, expected) in table {
        assert_eq!(of(channels).unwrap_or_else(|e| panic!("{why}: {e}")), expected, "{why}");
    }
    for (channels, words) in [
        (&[("X", 1.0), ("Y", 1.0), ("Z", 1.0)][..], "channels X, Y, Z, expected R, G and B"),
        (&[("U", 1.0), ("V", 1.0)], "channels U, V"),
        (
            &[("a.R", 7.0), ("a.G", 7.0), ("a.B", 7.0), ("b.R", 1.0), ("b.G", 2.0), ("b.B", 3.0)],
            "layers a, b",
        ),
    ] {
        let error = of(channels).expect_err(words);
        assert!(error.problem.contains(words), "{error}");
    }
}
