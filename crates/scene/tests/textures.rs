//! Textures of all supported formats, depths and channels.

#![cfg(feature = "load")]

use exr::prelude::{AnyChannel, AnyChannels, Image, Layer, WritableImage as _};
use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgb, Rgba};
use rotund_geometry::glam::{Vec4, vec2, vec4};
use rotund_scene::{LoadOptions, Pixels, Texture, load};
use std::{fs, path::Path};

/// Loads the texture that `write` stores in the file `name`.
fn texture(name: &str, write: impl FnOnce(&Path)) -> Result<Texture, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&folder.path().join(name));
    let scene = folder.path().join("scene.json");
    fs::write(&scene, format!(r#"{{ "textures": [{{ "uri": "{name}" }}] }}"#)).expect("writes");
    let loaded = load(&scene, &LoadOptions::default()).map_err(|error| error.to_string())?;
    Ok(loaded.scene.textures.into_iter().next().expect("a texture"))
}

fn assert_is(why: &str, texture: &Texture, expected: Vec4, error: f32) {
    assert_eq!((texture.width, texture.height), (2, 1), "{why}");
    for x in 0..2 {
        let color = texture.color_at(x, 0);
        assert!(color.distance(expected) <= error, "{why}: {color} is not {expected}");
    }
}

/// 128 of 255 in sRGB.
const HALF: f32 = 0.215_860_5;

#[test]
fn png_of_any_depth_and_channels_is_srgb() {
    let table: Vec<(&str, DynamicImage, Vec4)> = vec![
        ("grey", ImageBuffer::from_pixel(2, 1, Luma([128_u8])).into(), vec4(HALF, HALF, HALF, 1.0)),
        (
            "grey with alpha",
            ImageBuffer::from_pixel(2, 1, LumaA([128_u8, 51])).into(),
            vec4(HALF, HALF, HALF, 0.2),
        ),
        (
            "colour",
            ImageBuffer::from_pixel(2, 1, Rgb([255_u8, 128, 0])).into(),
            vec4(1.0, HALF, 0.0, 1.0),
        ),
        (
            "colour with alpha",
            ImageBuffer::from_pixel(2, 1, Rgba([255_u8, 128, 0, 51])).into(),
            vec4(1.0, HALF, 0.0, 0.2),
        ),
        (
            "grey of 16 bits",
            ImageBuffer::from_pixel(2, 1, Luma([128 * 257_u16])).into(),
            vec4(HALF, HALF, HALF, 1.0),
        ),
        (
            "colour with alpha of 16 bits",
            ImageBuffer::from_pixel(2, 1, Rgba([u16::MAX, 128 * 257, 0, 51 * 257])).into(),
            vec4(1.0, HALF, 0.0, 0.2),
        ),
    ];
    for (why, image, expected) in table {
        let texture = texture("image.png", |path| image.save(path).expect("writes the image"));
        assert_is(why, &texture.expect(why), expected, 1e-6);
    }
}

#[test]
fn jpeg_is_colour_or_grey() {
    let grey: DynamicImage = ImageBuffer::from_pixel(2, 1, Luma([128_u8])).into();
    let color: DynamicImage = ImageBuffer::from_pixel(2, 1, Rgb([128_u8, 128, 128])).into();
    for (why, image) in [("grey", grey), ("colour", color)] {
        for name in ["image.jpg", "image.jpeg", "image.JPG"] {
            let texture = texture(name, |path| image.save(path).expect("writes the image"));
            assert_is(why, &texture.expect(why), vec4(HALF, HALF, HALF, 1.0), 0.01);
        }
    }
}

#[test]
fn exr_is_colour_or_grey() {
    type Channels<'a> = &'a [(&'a str, f32)];
    let write = |channels: Channels<'_>| {
        let list = channels.iter().map(|&(name, value)| {
            AnyChannel::new(name, exr::prelude::FlatSamples::F32(vec![value; 2]))
        });
        let channels = AnyChannels::sort(list.collect());
        texture("image.exr", |path| {
            let layer = Layer::new(
                (2, 1),
                exr::prelude::LayerAttributes::named("it"),
                exr::prelude::Encoding::SMALL_LOSSLESS,
                channels,
            );
            Image::from_layer(layer).write().to_file(path).expect("writes the image");
        })
    };
    let table: &[(&str, Channels<'_>, Vec4)] = &[
        ("colour", &[("R", 3.0), ("G", 2.0), ("B", 0.5)], vec4(3.0, 2.0, 0.5, 1.0)),
        (
            "with alpha",
            &[("R", 3.0), ("G", 2.0), ("B", 0.5), ("A", 0.25)],
            vec4(3.0, 2.0, 0.5, 0.25),
        ),
        ("luminance", &[("Y", 3.0)], vec4(3.0, 3.0, 3.0, 1.0)),
        ("luminance with alpha", &[("Y", 3.0), ("A", 0.25)], vec4(3.0, 3.0, 3.0, 0.25)),
        ("a lone channel of any name", &[("height", 0.5)], vec4(0.5, 0.5, 0.5, 1.0)),
        ("luminance among others", &[("Y", 3.0), ("Z", 9.0)], vec4(3.0, 3.0, 3.0, 1.0)),
    ];
    for (why, channels, expected) in table {
        assert_is(why, &write(channels).expect(why), *expected, 0.0);
    }
    for channels in [&[("A", 1.0)][..], &[("U", 1.0), ("V", 1.0)], &[("R", 1.0), ("G", 1.0)]] {
        let message = write(channels).expect_err("no colour");
        assert!(message.contains("image.exr"), "{channels:?}: {message}");
    }
}

#[test]
fn hdr_is_read_flat_and_in_runs() {
    let header = |width: u32| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X {width}\n");
    let pixel = [128_u8, 64, 32, 129];
    let flat = [header(2).as_bytes(), &pixel, &pixel].concat();
    let mut runs = header(8).into_bytes();
    runs.extend([2, 2, 0, 8]);
    for value in pixel {
        runs.extend([128 + 8, value]);
    }
    // The oldest encoding: a pixel of ones with a count repeats the previous one.
    let old = [header(2).as_bytes(), &pixel, &[1, 1, 1, 1]].concat();
    for (why, bytes) in [("flat", flat), ("in runs", runs), ("in runs of old", old)] {
        let texture = texture("image.hdr", |path| fs::write(path, &bytes).expect("writes"));
        let texture = texture.unwrap_or_else(|error| panic!("{why}: {error}"));
        for x in 0..texture.width {
            assert_eq!(texture.color_at(x, 0), vec4(1.0, 0.5, 0.25, 1.0), "{why}");
        }
    }
}

#[test]
fn sizes_in_headers_do_not_cause_allocations() {
    let header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 40000 +X 40000\n";
    let message = texture("image.hdr", |path| fs::write(path, header).expect("writes"));
    let message = message.expect_err("refused");
    assert!(message.contains("40000 x 40000") && message.contains("image.hdr"), "{message}");
}

#[test]
fn the_content_of_a_file_decides_on_its_format() {
    let image: DynamicImage = ImageBuffer::from_pixel(2, 1, Rgb([128_u8, 128, 128])).into();
    for format in [
        image::ImageFormat::Png,
        image::ImageFormat::Jpeg,
        image::ImageFormat::Bmp,
        image::ImageFormat::Tga,
    ] {
        for name in ["image.png", "image.hdr", "image.jpe", "image"] {
            let texture = texture(name, |path| {
                image.save_with_format(path, format).expect("writes the image");
            });
            assert_is(name, &texture.expect(name), vec4(HALF, HALF, HALF, 1.0), 0.01);
        }
    }
    for (bytes, words) in [(&b"GIF89a"[..], "a GIF"), (b"<html>", "no image"), (b"", "is empty")] {
        let message = texture("image.png", |path| fs::write(path, bytes).expect("writes"));
        let message = message.expect_err("refused");
        assert!(message.contains(words) && message.contains("image.png"), "{message}");
    }
}

/// Loads a scene that names a ramp of 16 bits, in which neighbours differ by one, by `fields` of
/// its material and of a subdivision of a square of sixteen.
fn with_ramp(material: &str, subdiv: &str) -> rotund_scene::Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let ramp = ImageBuffer::from_fn(16, 16, |x, _| Luma([30_000 + x as u16]));
    DynamicImage::from(ramp).save(folder.path().join("ramp.png")).expect("writes the image");
    let scene = folder.path().join("scene.json");
    let json = format!(
        r#"{{ "textures": [{{ "name": "first" }}, {{ "uri": "ramp.png", "name": "ramp" }}],
        "materials": [{{ "color": [1, 1, 1] {material} }}],
        "shapes": [{{ "generator": {RECTANGLE} }}],
        "subdivs": [{{ "shape": 0, "generator": {RECTANGLE} {subdiv} }}] }}"#
    );
    let json = json.replace(r#"{ "name": "first" }"#, r#"{ "name": "first", "uri": "ramp.png" }"#);
    fs::write(&scene, json).expect("writes the scene");
    load(&scene, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")).scene
}

const RECTANGLE: &str = r#"{ "rectangle": { "size": [1, 1], "steps": [16, 16] } }"#;

#[test]
fn data_of_16_bits_keep_them_and_colours_take_8() {
    for field in ["normal_tex", "roughness_tex"] {
        let scene = with_ramp(&format!(r#", "{field}": "ramp""#), "");
        assert!(matches!(scene.textures[1].pixels, Pixels::Words(_)), "{field}");
        assert!(matches!(scene.textures[0].pixels, Pixels::TiledBytes(_)), "unused: {field}");
        for x in 0..16_u8 {
            let data = scene.textures[1].data(vec2(f32::from(x) / 16.0, 0.5));
            let expected = (30_000.0 + f32::from(x)) / 65_535.0;
            assert!((data.x - expected).abs() < 1e-6 && data.w == 1.0, "{field} {x}: {data}");
            let color = scene.textures[1].color_at(x.into(), 3).x;
            assert!((color - rotund_image_linear(expected)).abs() < 1e-5, "{field} {x}: {color}");
        }
        assert!(scene.textures[1].is_opaque());
        rotund_scene::Trees::build(&scene).expect("valid");
    }
    let scene = with_ramp(r#", "color_tex": 1"#, "");
    assert!(matches!(scene.textures[1].pixels, Pixels::TiledBytes(_)), "a colour");
}

/// The transfer function of sRGB above its linear part.
fn rotund_image_linear(srgb: f32) -> f32 {
    ((srgb + 0.055) / 1.055).powf(2.4)
}

#[test]
fn heights_of_16_bits_are_no_terraces() {
    let scene = with_ramp("", r#", "displacement": 65535, "displacement_tex": "ramp""#);
    // Steps of one in the file are steps of 3/4 in the mean of grey and alpha.
    let mut heights: Vec<f32> =
        scene.shapes[0].positions.iter().map(|p| p.length() / 0.75).map(f32::round).collect();
    heights.sort_by(f32::total_cmp);
    heights.dedup();
    assert!(heights.len() >= 16, "{heights:?}");
}

#[test]
fn a_file_that_several_textures_name_is_the_same_in_each() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let noise = |x: u32, y: u32| Rgb([x, y, x * y].map(|i| (i * 37 % 251) as u8));
    let image: DynamicImage = ImageBuffer::from_fn(40, 40, noise).into();
    image.save(folder.path().join("image.png")).expect("writes the image");
    let items: Vec<String> =
        (0..12).map(|i| format!(r#"{{ "name": "t{i}", "uri": "image.png" }}"#)).collect();
    let scene = folder.path().join("scene.json");
    fs::write(&scene, format!(r#"{{ "textures": [{}] }}"#, items.join(", "))).expect("writes");
    let textures = load(&scene, &LoadOptions::default()).expect("loads").scene.textures;
    assert_eq!(textures.len(), 12);
    for (i, texture) in textures.iter().enumerate() {
        assert_eq!(texture.name, format!("t{i}"));
        assert_eq!(texture.pixels, textures[0].pixels);
    }
    // One that cannot be read is reported once.
    fs::write(folder.path().join("image.png"), "no image").expect("writes");
    let options = LoadOptions { keep_going: true, ..LoadOptions::default() };
    let loaded = load(&scene, &options).expect("loads");
    assert_eq!((loaded.scene.textures.len(), loaded.warnings.len()), (12, 1));
}
