//! Shapes without a scene file, and all encodings of PLY.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec2, Vec3, Vec4, vec2, vec3};
use rotund_scene::{Elements, LoadOptions, Loaded, Shape, Trees, load};

/// Loads these bytes as a PLY file by itself.
fn loaded(bytes: &[u8], options: &LoadOptions) -> Loaded {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("thing.ply");
    std::fs::write(&path, bytes).expect("writes the file");
    load(&path, options).unwrap_or_else(|error| panic!("{error}"))
}

fn shape(bytes: &[u8]) -> Shape {
    loaded(bytes, &LoadOptions::default()).scene.shapes.swap_remove(1)
}

fn ascii(header: &str, data: &str) -> Vec<u8> {
    format!("ply\nformat ascii 1.0\n{header}\nend_header\n{data}").into_bytes()
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z";

#[test]
fn any_order_and_type_of_properties_means_the_same_in_every_encoding() {
    let header = "element vertex 2\nproperty uchar blue\nproperty double z\nproperty float u\n\
        property short x\nproperty list uchar ushort junk\nproperty float y\nproperty uchar red\n\
        property float radius\nproperty uchar green\nproperty float v\n\
        element material 1\nproperty int64 kd\n\
        element line 1\nproperty int flags\nproperty list int ulong vertex_index";
    let text = ascii(
        header,
        "255 3 0.25 1 2 7 8 2 0 0.5 128 0.75\n0 6 0.5 -4 0 5 255 0.125 0 1\n42\n9 2 1 0\n",
    );
    let binary = |name: &str, big: bool| {
        let mut bytes = format!("ply\nformat {name} 1.0\n{header}\nend_header\n").into_bytes();
        macro_rules! put {
            ($($value:expr),*) => {
                $(bytes.extend(if big {
                    $value.to_be_bytes().to_vec()
                } else {
                    $value.to_le_bytes().to_vec()
                });)*
            };
        }
        put!(
            255_u8, 3_f64, 0.25_f32, 1_i16, 2_u8, 7_u16, 8_u16, 2_f32, 0_u8, 0.5_f32, 128_u8,
            0.75_f32
        );
        put!(0_u8, 6_f64, 0.5_f32, -4_i16, 0_u8, 5_f32, 255_u8, 0.125_f32, 0_u8, 1_f32);
        put!(42_i64, 9_i32, 2_i32, 1_u64, 0_u64);
        bytes
    };
    for bytes in [text, binary("binary_little_endian", false), binary("binary_big_endian", true)] {
        let shape = shape(&bytes);
        assert_eq!(shape.positions, [vec3(1.0, 2.0, 3.0), vec3(-4.0, 5.0, 6.0)]);
        assert_eq!(shape.elements, Elements::Lines(vec![[1, 0]]));
        assert_eq!(shape.radii, [0.5, 0.125]);
        // In PLY files v runs up.
        assert_eq!(shape.texcoords, [vec2(0.25, 0.25), vec2(0.5, 0.0)]);
        // Bytes are decoded from sRGB.
        let expected = [Vec4::new(0.0, 0.215_860_5, 1.0, 1.0), Vec4::new(1.0, 0.0, 0.0, 1.0)];
        for (color, expected) in shape.colors.iter().zip(expected) {
            assert!(color.distance(expected) < 1e-6, "{color} is not {expected}");
        }
    }
}

#[test]
fn faces_stay_triangles_until_there_is_a_quad() {
    let faces = |count: u32, lists: &str| {
        let header = format!(
            "element face {count}\nproperty list uchar int vertex_indices\nelement vertex 6\n{XYZ}"
        );
        let vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 2 0\n2 0 0\n";
        shape(&ascii(&header, &format!("{lists}\n{vertices}"))).elements
    };
    let table = [
        ("triangles", 2, "3 0 1 2 3 2 3 0", Elements::Triangles(vec![[0, 1, 2], [2, 3, 0]])),
        ("a quad", 1, "4 0 1 2 3", Elements::Quads(vec![[0, 1, 2, 3]])),
        (
            "a quad after a triangle",
            2,
            "3 0 1 2 4 0 1 2 3",
            Elements::Quads(vec![[0, 1, 2, 2], [0, 1, 2, 3]]),
        ),
        (
            "a triangle after a quad",
            2,
            "4 0 1 2 3 3 0 1 2",
            Elements::Quads(vec![[0, 1, 2, 3], [0, 1, 2, 2]]),
        ),
        (
            "a pentagon is a fan",
            1,
            "5 0 1 2 3 4",
            Elements::Triangles(vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
        ),
        (
            "a pentagon among quads",
            2,
            "4 0 1 2 3 5 0 1 2 3 4",
            Elements::Quads(vec![[0, 1, 2, 3], [0, 1, 2, 2], [0, 2, 3, 3], [0, 3, 4, 4]]),
        ),
    ];
    for (why, count, lists, expected) in table {
        assert_eq!(faces(count, lists), expected, "{why}");
    }
}

#[test]
fn polylines_are_consecutive_pairs_and_points_may_be_listed_in_any_order() {
    let list = |kind: &str, lists: &str| {
        let header = format!(
            "element vertex 3\n{XYZ}\nelement {kind} 2\nproperty list uchar int vertex_indices"
        );
        shape(&ascii(&header, &format!("0 0 0 1 0 0 2 0 0\n{lists}\n")))
    };
    let lines = list("line", "3 0 1 2 2 2 0");
    assert_eq!(lines.elements, Elements::Lines(vec![[0, 1], [1, 2], [2, 0]]));
    let points = list("point", "1 2 2 0 2");
    assert_eq!(points.elements, Elements::Points(3));
    assert_eq!(points.positions, [2.0 * Vec3::X, Vec3::ZERO, 2.0 * Vec3::X]);
}

#[test]
fn vertices_alone_are_points_that_just_touch() {
    let mut data = String::new();
    for i in 0..100 {
        data.push_str(&format!("{} {} 0\n", f64::from(i % 10) * 0.5, f64::from(i / 10) * 0.5));
    }
    let cloud = ascii(&format!("element vertex 100\n{XYZ}"), &data);
    let found = shape(&cloud);
    assert_eq!(found.elements, Elements::Points(100));
    assert_eq!(found.radii, vec![0.25; 100]);
    let options = LoadOptions { radius: Some(0.125), ..LoadOptions::default() };
    assert_eq!(loaded(&cloud, &options).scene.shapes[1].radii, vec![0.125; 100]);
}

#[test]
fn invalid_normals_and_texture_coordinates_are_replaced_with_a_warning() {
    let header = format!(
        "element vertex 1\n{XYZ}\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v"
    );
    let loaded = loaded(&ascii(&header, "0 0 0 nan 0 0 inf 0\n"), &LoadOptions::default());
    assert_eq!(loaded.scene.shapes[1].normals, [Vec3::ZERO]);
    assert_eq!(loaded.scene.shapes[1].texcoords, [Vec2::ZERO]);
    assert!(
        loaded.warnings[0].contains("2 normals or texture coordinates"),
        "{:?}",
        loaded.warnings
    );
}

#[test]
fn the_camera_of_a_lone_shape_sees_it_above_its_floor() {
    for (why, x, y, z) in [
        ("at the origin", "0 0 0", "0 1 0", "1 0 0"),
        ("far away", "1000 500 -20", "1000 501 -20", "1001 500 -20"),
        ("tiny", "0 0 0", "0 1e-4 0", "1e-4 0 0"),
        ("a single place", "1 1 1", "1 1 1", "1 1 1"),
    ] {
        let bytes = ascii(&format!("element vertex 3\n{XYZ}"), &format!("{x}\n{y}\n{z}\n"));
        let scene = loaded(&bytes, &LoadOptions::default()).scene;
        let trees = Trees::build(&scene).expect("the scene is valid");
        let seen = |u: f32, v: f32| {
            let ray = scene.cameras[0].ray(vec2(u, v), Vec2::ZERO);
            trees.closest(&scene, &ray).map(|hit| hit.instance)
        };
        let mut counts = [0, 0];
        for i in 0..100 {
            for j in 0..100 {
                if let Some(instance) = seen(i as f32 / 99.0, j as f32 / 99.0) {
                    counts[instance as usize] += 1;
                }
            }
        }
        assert!(counts[0] > 3000, "{why}: the floor fills much of the picture: {counts:?}");
        assert!(counts[1] > 0, "{why}: the shape is in the picture: {counts:?}");
        for border in [seen(0.0, 0.5), seen(1.0, 0.5), seen(0.5, 0.0), seen(0.5, 1.0)] {
            assert_ne!(border, Some(1), "{why}: and not cut by its border");
        }
    }
}

#[test]
fn every_name_in_use_for_a_property_is_known() {
    let header = |names: &str| {
        let properties: String =
            names.split(' ').map(|name| format!("\nproperty float {name}")).collect();
        format!("element vertex 1\n{XYZ}{properties}")
    };
    for (u, v) in [("u", "v"), ("s", "t"), ("texture_u", "texture_v")] {
        let shape = shape(&ascii(&header(&format!("{u} {v}")), "0 0 0 0.25 0.25\n"));
        assert_eq!(shape.texcoords, [vec2(0.25, 0.75)], "{u} {v}");
    }
    for names in ["red green blue", "r g b", "diffuse_red diffuse_green diffuse_blue"] {
        let shape = shape(&ascii(&header(names), "0 0 0 0.25 0.5 2\n"));
        assert_eq!(shape.colors, [Vec4::new(0.25, 0.5, 2.0, 1.0)], "{names}: floats are linear");
    }
    for alpha in ["alpha", "a"] {
        let shape = shape(&ascii(&header(&format!("red green blue {alpha}")), "0 0 0 1 1 1 0.5\n"));
        assert_eq!(shape.colors, [Vec4::new(1.0, 1.0, 1.0, 0.5)], "{alpha}");
    }
    let normal = shape(&ascii(&header("nx ny nz"), "0 0 0 0 1 0\n"));
    assert_eq!(normal.normals, [Vec3::Y]);
    let half = shape(&ascii(&header("u"), "0 0 0 0.25\n"));
    assert!(half.texcoords.is_empty(), "one of two is none");
}

#[cfg(unix)]
#[test]
fn a_pipe_as_a_shape_is_refused_without_waiting() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["pipe.ply", "pipe.obj", "pipe.json"] {
        let pipe = folder.path().join(name);
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        if !made.is_ok_and(|status| status.success()) {
            // Skip the test on systems without the tool.
            return;
        }
        let message = load(&pipe, &LoadOptions::default()).expect_err("refused").to_string();
        assert!(message.contains(name) && message.contains("pipe or device"), "{message}");
    }
}

#[test]
fn a_radius_has_to_be_a_length_and_is_for_lone_shapes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("thing.ply");
    std::fs::write(&path, ascii(&format!("element vertex 1\n{XYZ}"), "0 0 0\n")).expect("writes");
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let options = LoadOptions { radius: Some(radius), ..LoadOptions::default() };
        let message = load(&path, &options).expect_err("refused").to_string();
        assert!(message.contains("radius") && message.contains("positive"), "{message}");
    }
    let scene = folder.path().join("scene.json");
    std::fs::write(&scene, "{}").expect("writes the scene");
    let options = LoadOptions { radius: Some(1.0), ..LoadOptions::default() };
    let warnings = load(&scene, &options).expect("loads").warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("changes nothing"), "{warnings:?}");
}

/// Returns a file of ten thousand vertices, more than one block.
fn many(encoding: &str, bad: Option<(usize, f32)>) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex 10000\nproperty double z\nproperty float x\n\
        property float y\nproperty float radius\nproperty ushort red\nproperty uchar green\n\
        property uchar blue\nproperty uchar alpha\nelement point 10000\n\
        property list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let mut number = |text: String, little: &[u8]| match encoding {
        "ascii" => bytes.extend(format!("{text} ").bytes()),
        "binary_little_endian" => bytes.extend(little),
        _ => bytes.extend(little.iter().rev()),
    };
    macro_rules! put {
        ($($value:expr),*) => {$(
            let value = $value;
            number(value.to_string(), &value.to_le_bytes());
        )*};
    }
    for i in 0..10_000_u16 {
        let x = f32::from(i);
        let radius = bad.filter(|(at, _)| *at == usize::from(i)).map_or(x * 0.25, |(_, bad)| bad);
        put!(f64::from(i) * 3.0, x, x * 0.5, radius, i, (i % 256) as u8, 255_u8, (i % 128) as u8);
    }
    for i in 0..10_000_i32 {
        put!(1_u8, i);
    }
    bytes
}

#[test]
fn a_cloud_of_many_blocks_is_the_same_in_every_encoding() {
    let encodings = ["ascii", "binary_little_endian", "binary_big_endian"];
    let shapes = encodings.map(|encoding| shape(&many(encoding, None)));
    for (shape, encoding) in shapes.iter().zip(encodings) {
        assert_eq!(shape.elements, Elements::Points(10_000), "{encoding}");
        for (i, (position, radius)) in (0_u16..).zip(shape.positions.iter().zip(&shape.radii)) {
            let x = f32::from(i);
            assert_eq!((*position, *radius), (vec3(x, 0.5 * x, 3.0 * x), 0.25 * x), "{encoding}");
            let color = shape.colors[usize::from(i)];
            assert_eq!((color.z, color.w), (1.0, f32::from(i % 128) / 255.0), "{encoding} {i}");
        }
        assert_eq!(shape.colors, shapes[0].colors, "{encoding}");
    }
}

#[test]
fn a_bad_value_in_any_block_is_left_out_and_a_file_that_is_cut_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("thing.ply");
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let found = loaded(&many(encoding, Some((9_001, -1.0))), &LoadOptions::default());
        let shape = &found.scene.shapes[1];
        assert_eq!(shape.positions.len(), 9_999, "{encoding}");
        assert_eq!(shape.positions[9_001].x, 9_002.0, "{encoding}");
        assert!(found.warnings[0].contains("1 of 10000 vertices"), "{:?}", found.warnings);
        if encoding == "ascii" {
            // A number that is cut is still a number.
            continue;
        }
        let whole = many(encoding, None);
        for (cut, part) in [(3, "point 9999 of 10000"), (60_000, "vertex 9600 of 10000")] {
            std::fs::write(&path, &whole[..whole.len() - cut]).expect("writes the file");
            let message = load(&path, &LoadOptions::default()).map(|_| ()).expect_err("refused");
            assert!(message.to_string().contains(part), "{encoding}: {message}");
        }
    }
}
