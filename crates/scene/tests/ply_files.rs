//! PLY files as other programs write them: what is used, what is left out, and what is said of it.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec2, Vec3, Vec4, vec2, vec3};
use rotund_scene::{Elements, LoadOptions, Loaded, Shape, load_bytes};
use std::borrow::Cow;

fn loaded_of(bytes: &[u8]) -> Result<Loaded, String> {
    let nothing = |_: &str| None;
    load_bytes("thing.ply", bytes, &nothing, &LoadOptions::default())
        .map_err(|error| error.to_string())
}

/// Loads a text file with these lines of the header and this data.
fn loaded(header: &str, data: &str) -> Loaded {
    let text = format!("ply\nformat ascii 1.0\n{header}\nend_header\n{data}\n");
    loaded_of(text.as_bytes()).unwrap_or_else(|error| panic!("{header}: {error}"))
}

/// Returns the shapes of the file, after the floor.
fn shapes(loaded: &Loaded) -> &[Shape] {
    &loaded.scene.shapes[1..]
}

/// Asserts that there is one warning, with all of these parts.
fn assert_warns(why: &str, loaded: &Loaded, parts: &[&str]) {
    let [warning] = &loaded.warnings[..] else {
        panic!("{why}: one warning, not {:?}", loaded.warnings)
    };
    for part in parts {
        assert!(warning.contains(part), "{why}: {part:?} is not in {warning:?}");
    }
}

fn element(name: &str, count: usize, properties: &[&str]) -> String {
    let lines: Vec<String> =
        properties.iter().map(|property| format!("\nproperty {property}")).collect();
    format!("element {name} {count}{}", lines.concat())
}

fn vertices(count: usize, more: &[&str]) -> String {
    element("vertex", count, &[&["float x", "float y", "float z"], more].concat())
}

const THREE: &str = "0 0 0\n1 0 0\n1 1 0\n";
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

#[test]
fn edges_are_lines_however_they_are_written() {
    let ends = |a, b| [format!("int {a}"), format!("int {b}")];
    let list = || ["list uchar int vertex_indices".to_owned(), "float crease".to_owned()];
    let table = [
        ("of Blender and MeshLab", "edge", ends("vertex1", "vertex2"), "0 1\n1 2", ""),
        ("numbered from zero", "edge", ends("vertex0", "vertex1"), "0 1\n1 2", ""),
        ("in the plural", "edges", ends("v1", "v2"), "0 1\n1 2", ""),
        ("lists with a crease", "edge", list(), "2 0 1 0.5\n2 1 2 1", "crease"),
    ];
    for (why, name, properties, data, unused) in table {
        let properties = properties.each_ref().map(String::as_str);
        let header = format!("{}\n{}", vertices(3, &[]), element(name, 2, &properties));
        let loaded = loaded(&header, &format!("{THREE}{data}"));
        assert_eq!(shapes(&loaded)[0].elements, Elements::Lines(vec![[0, 1], [1, 2]]), "{why}");
        if unused.is_empty() {
            assert_eq!(loaded.warnings, Vec::<String>::new(), "{why}");
        } else {
            assert_warns(why, &loaded, &[name, unused]);
        }
    }
    let faces = element("face", 2, &["list uint8 int32 vertex_indices"]);
    let header = format!("{}\n{faces}", vertices(4, &[]));
    let two = loaded(&header, &format!("{SQUARE}2 0 1\n2 2 3"));
    assert_eq!(shapes(&two)[0].elements, Elements::Lines(vec![[0, 1], [2, 3]]), "as faces");
}

#[test]
fn colours_of_edges_and_faces_become_those_of_vertices() {
    let color = ["uchar red", "uchar green", "uchar blue"];
    let edges = element("edge", 2, &[&["int vertex1", "int vertex2"], &color[..]].concat());
    let header = format!("{}\n{edges}", vertices(4, &[]));
    let found = loaded(&header, &format!("{SQUARE}0 1 255 0 0\n1 2 0 0 255"));
    let shape = &shapes(&found)[0];
    let Elements::Lines(lines) = &shape.elements else { panic!("lines") };
    let (red, blue) = (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0));
    assert!(lines[0].iter().all(|&v| shape.colors[v as usize] == red));
    assert!(lines[1].iter().all(|&v| shape.colors[v as usize] == blue));
    assert_eq!(shape.positions[lines[1][0] as usize], Vec3::X, "a copy where colours meet");

    let list = ["list uchar int vertex_indices"];
    let faces = element("face", 2, &[&list, &color[..], &["uchar alpha"]].concat());
    let data = format!("{SQUARE}3 0 1 2 255 0 0 255\n3 0 2 3 0 0 255 51");
    let found = loaded(&format!("{}\n{faces}", vertices(4, &[])), &data);
    let shape = &shapes(&found)[0];
    let Elements::Triangles(triangles) = &shape.elements else { panic!("triangles") };
    assert!(triangles[0].iter().all(|&v| shape.colors[v as usize] == red));
    let faint = blue.with_w(0.2);
    assert!(triangles[1].iter().all(|&v| shape.colors[v as usize] == faint));
    assert_eq!((shape.positions.len(), found.warnings.len()), (6, 0));

    let header = format!("{}\n{faces}", vertices(3, &color));
    let data = "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 9 9 9\n3 0 1 2 255 0 0 255\n3 0 2 1 0 0 255 51";
    assert_warns("vertices come first", &loaded(&header, data), &["colours of faces", "vertices"]);
    let found = loaded(&header, &data.replace("9 9 9", "1 2 3"));
    assert_eq!(shapes(&found)[0].colors[0], red, "unless they are all the same");

    let floats = ["list uchar int vertices", "float r", "float g", "float b"];
    let header = format!("{}\n{}", vertices(3, &[]), element("face", 1, &floats));
    let found = loaded(&header, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0");
    assert_eq!(shapes(&found)[0].colors, [red; 3]);
    assert_warns("as floats", &found, &["0 to 255"]);
}

#[test]
fn triangle_strips_turn_every_second_triangle() {
    let strips = element("tristrips", 1, &["list int int vertex_indices"]);
    let header = format!("{}\n{strips}", vertices(4, &[]));
    // Two triangles in a zigzag, a new strip, and one more triangle.
    let found = loaded(&header, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n9 0 1 2 3 -1 0 1 2 -1");
    let expected = vec![[0, 1, 2], [2, 1, 3], [0, 1, 2]];
    let shape = &shapes(&found)[0];
    assert_eq!(shape.elements, Elements::Triangles(expected.clone()));
    for triangle in expected {
        let [a, b, c] = triangle.map(|v| shape.positions[v as usize]);
        assert!((b - a).cross(c - a).z > 0.0, "all face the same way");
    }
}

#[test]
fn faces_are_found_under_other_names() {
    let names =
        ["vertex_indices", "vertex_index", "vertices", "indices", "vertex_indexes", "verts"];
    for element_name in ["face", "polygon", "triangles"] {
        for name in names {
            let list = format!("list uchar int {name}");
            let header = format!("{}\n{}", vertices(3, &[]), element(element_name, 1, &[&list]));
            let found = loaded(&header, &format!("{THREE}3 0 1 2"));
            let expected = Elements::Triangles(vec![[0, 1, 2]]);
            assert_eq!(shapes(&found)[0].elements, expected, "{element_name} {name}");
            assert_eq!(found.warnings, Vec::<String>::new(), "{element_name} {name}");
        }
    }
    let header = element("points", 2, &["double x", "double y", "double z"]);
    assert_eq!(shapes(&loaded(&header, "0 0 0\n1 0 0"))[0].elements, Elements::Points(2));
}

#[test]
fn sizes_have_many_names() {
    for (name, radius) in [
        ("radius", 0.5),
        ("pscale", 0.5),
        ("scalar_radius", 0.5),
        ("scalar_Radius", 0.5),
        ("width", 0.25),
        ("size", 0.25),
        ("scalar_size", 0.25),
        ("diameter", 0.25),
        // Isotropic splats, by the logarithm.
        ("scale_0", 0.5_f32.exp()),
    ] {
        let property = format!("float {name}");
        for encoding in ["ascii", "binary_little_endian"] {
            let header = vertices(1, &[&property]);
            let mut bytes =
                format!("ply\nformat {encoding} 1.0\n{header}\nend_header\n").into_bytes();
            if encoding == "ascii" {
                bytes.extend(b"0 0 0 0.5\n");
            } else {
                bytes.extend([0.0, 0.0, 0.0, 0.5_f32].map(f32::to_le_bytes).concat());
            }
            let found = loaded_of(&bytes).expect("loads");
            assert_eq!(shapes(&found)[0].radii, [radius], "{name} {encoding}");
            assert_eq!(found.warnings, Vec::<String>::new(), "{name}");
        }
    }
}

#[test]
fn colours_have_many_names() {
    for names in ["Red Green Blue", "scalar_R scalar_G scalar_B", "Cd_r Cd_g Cd_b"] {
        let properties: Vec<_> = names.split(' ').map(|name| format!("float {name}")).collect();
        let properties: Vec<&str> = properties.iter().map(String::as_str).collect();
        let found = loaded(&vertices(1, &properties), "0 0 0 0.25 0.5 1");
        assert_eq!(shapes(&found)[0].colors, [Vec4::new(0.25, 0.5, 1.0, 1.0)], "{names}");
        assert_eq!(found.warnings, Vec::<String>::new(), "{names}");
    }
}

#[test]
fn a_colour_may_be_packed_into_one_number() {
    let bytes = [0xc0, 0xff, 0x80, 0x00];
    let bits = u32::from_be_bytes(bytes);
    let expected = |alpha| Vec4::new(1.0, 0.215_861, 0.0, alpha);
    let table = [
        ("float rgb", f32::from_bits(bits).to_string(), 1.0),
        ("uint rgb", bits.to_string(), 1.0),
        ("uint rgba", bits.to_string(), f32::from(bytes[0]) / 255.0),
        ("int rgb", bits.cast_signed().to_string(), 1.0),
    ];
    for (property, text, alpha) in table {
        let header = vertices(2, &[property]);
        let found = loaded(&header, &format!("0 0 0 {text}\n1 0 0 0"));
        let colors = &shapes(&found)[0].colors;
        assert!(colors[0].distance(expected(alpha)) < 1e-5, "{property}: {colors:?}");
        assert_eq!(colors[1].truncate(), Vec3::ZERO, "{property}");
        assert_eq!(found.warnings, Vec::<String>::new(), "{property}");
        for (encoding, bits) in [("little", bits.to_le_bytes()), ("big", bits.to_be_bytes())] {
            let header =
                format!("ply\nformat binary_{encoding}_endian 1.0\n{header}\nend_header\n");
            let rows = [[0; 12].as_slice(), &bits, &[0; 16]].concat();
            let found = loaded_of(&[header.as_bytes(), &rows].concat()).expect("loads");
            let color = shapes(&found)[0].colors[0];
            assert!(color.distance(expected(alpha)) < 1e-5, "{property}, {encoding}: {color}");
        }
    }
    // The channels count, if there are some.
    let found =
        loaded(&vertices(1, &["float rgb", "uchar r", "uchar g", "uchar b"]), "0 0 0 1 0 255 0");
    assert_eq!(shapes(&found)[0].colors, [Vec4::new(0.0, 1.0, 0.0, 1.0)]);
    assert_warns("both", &found, &["rgb"]);
}

#[test]
fn an_intensity_without_colours_is_grey() {
    for item in ["float", "double", "uchar", "short"] {
        let header = vertices(3, &[&format!("{item} scalar_Intensity")]);
        let found = loaded(&header, "0 0 0 10\n1 0 0 60\n2 0 0 110");
        let greys: Vec<f32> = shapes(&found)[0].colors.iter().map(|color| color.y).collect();
        assert_eq!(greys.len(), 3, "{item}");
        let off = Vec3::from_slice(&greys).distance(vec3(0.0, 0.214_041, 1.0));
        assert!(off < 1e-5, "{item}: {greys:?}");
        assert_eq!(found.warnings, Vec::<String>::new(), "{item}");
    }
}

#[test]
fn vertices_that_no_element_names_are_counted() {
    let faces = element("face", 1, &["list uchar int vertex_indices"]);
    let edges = element("edge", 1, &["int vertex1", "int vertex2"]);
    let corners =
        element("face", 1, &["list uchar int vertex_indices", "list uchar float texcoord"]);
    let table = [
        (faces, "3 0 1 2", "1 of 4 vertices"),
        (edges, "0 1", "2 of 4 vertices"),
        (corners, "3 0 1 2 6 0 0 1 0 1 1", "1 of 4 vertices"),
    ];
    for (elements, row, part) in table {
        let found = loaded(&format!("{}\n{elements}", vertices(4, &[])), &format!("{SQUARE}{row}"));
        assert_warns(row, &found, &[part, "not drawn"]);
    }
}

#[test]
fn splats_are_balls_of_their_colour_and_volume() {
    let properties = [
        "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "f_rest_1", "f_rest_2", "opacity", "scale_0",
        "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
    ];
    let properties = properties.map(|name| format!("float {name}"));
    let names: Vec<&str> = properties.iter().map(String::as_str).collect();
    // A white channel, a grey one of half the light, and a black one.
    let white = 0.5 / 0.282_094_79;
    let grey = (0.735_357 - 0.5) / 0.282_094_79;
    let data = format!("0 0 0 {white} {grey} -9 7 7 7 2 -1 -2 -3 1 0 0 0");
    let found = loaded(&vertices(1, &names), &data);
    let shape = &shapes(&found)[0];
    assert!((shape.radii[0] - (-2.0_f32).exp()).abs() < 1e-6, "{:?}", shape.radii);
    assert!(shape.colors[0].distance(Vec4::new(1.0, 0.5, 0.0, 1.0)) < 1e-3, "{:?}", shape.colors);
    assert_warns("the rest", &found, &["f_rest_0 to f_rest_2", "opacity", "rot_0 to rot_3"]);
}

#[test]
fn float_colours_from_0_to_255_are_divided() {
    let header = vertices(2, &["float red", "float green", "float blue"]);
    let found = loaded(&header, "0 0 0 255 0 188\n1 0 0 255 1 0");
    let colors = &shapes(&found)[0].colors;
    assert!(colors[0].distance(Vec4::new(1.0, 0.0, 0.502_886_5, 1.0)) < 1e-5, "{colors:?}");
    assert_warns("bytes as floats", &found, &["255", "0 to 255"]);
    let found = loaded(&header, "0 0 0 61.5 200.25 3\n1 0 0 255 254.5 0.5");
    assert!(shapes(&found)[0].colors[1].x == 1.0, "means of bytes, most beyond 1");
    let found = loaded(&header, "0 0 0 0.25 0.5 2\n1 0 0 1 1 0");
    assert_eq!(shapes(&found)[0].colors[0], Vec4::new(0.25, 0.5, 2.0, 1.0));
    assert_warns("light", &found, &["up to 2", "beyond white"]);
}

#[test]
fn bad_vertices_and_faces_are_left_out_and_counted() {
    let nans = ["nan nan nan", "NaN NaN NaN", "-nan(ind) 0 0", "1.#QNAN 0 0", "inf 0 0"];
    for nan in nans {
        let found = loaded(&vertices(3, &[]), &format!("0 0 1\n{nan}\n0 0 2"));
        assert_eq!(shapes(&found)[0].positions, [Vec3::Z, 2.0 * Vec3::Z], "{nan}");
        assert_warns(nan, &found, &["1 of 3 vertices", "not finite", "left out"]);
    }
    let faces = element("face", 5, &["list uchar int vertex_indices"]);
    let header = format!("{}\n{faces}", vertices(5, &["float radius"]));
    let data = "0 0 0 1\n1 0 0 1\nnan 1 0 1\n0 1 0 1\n0 2 0 1\n";
    let found = loaded(&header, &format!("{data}3 0 1 2\n3 0 1 3\n2 0 1\n0\n3 1 4 3"));
    let shape = &shapes(&found)[0];
    assert_eq!(shape.elements, Elements::Triangles(vec![[0, 1, 2], [1, 3, 2]]));
    assert_eq!(shape.positions[3], vec3(0.0, 2.0, 0.0));
    let [first, second] = &found.warnings[..] else { panic!("{:?}", found.warnings) };
    assert!(first.contains("2 faces have fewer than three vertices"), "{first}");
    assert!(second.contains("1 of 5 vertices") && second.contains("1 elements"), "{second}");
    let found = loaded(&vertices(2, &["float radius"]), "0 0 0 -1\n1 0 0 0.5");
    assert_eq!(shapes(&found)[0].radii, [0.5]);
    assert_warns("a negative radius", &found, &["1 of 2 vertices", "radius", "left out"]);
}

#[test]
fn what_is_not_used_is_named_once() {
    let table = [
        (
            "intensity beside colours",
            vertices(1, &["uchar red", "uchar green", "uchar blue", "float scalar_Intensity"]),
            "0 0 0 5 6 7 0.5",
            "Intensity",
        ),
        ("half a colour", vertices(1, &["uchar red", "uchar green"]), "0 0 0 5 6", "red, green"),
        ("half a texture", vertices(1, &["float s"]), "0 0 0 5", "s"),
        (
            "a grid of a scanner",
            format!(
                "{}\n{}",
                vertices(1, &[]),
                element("range_grid", 2, &["list uchar int vertex_indices"])
            ),
            "0 0 0\n1 0\n0",
            "range_grid",
        ),
        (
            "tetrahedra",
            format!("{}\n{}", vertices(1, &[]), element("tetra", 1, &["list uchar int vertices"])),
            "0 0 0\n4 0 0 0 0",
            "tetra is not used; its count is 1",
        ),
    ];
    for (why, header, data, part) in table {
        assert_warns(why, &loaded(&header, data), &["thing.ply", part]);
    }
    let header = vertices(1, &["uint packed_position"]).replace("property float x\n", "");
    let text = format!("ply\nformat ascii 1.0\n{header}\nend_header\n0 0 7\n");
    let message = loaded_of(text.as_bytes()).map(drop).expect_err("a compressed splat");
    assert!(message.contains("packed_position") && message.contains("x, y and z"), "{message}");
}

#[test]
fn headers_end_their_lines_in_any_way_before_binary_data() {
    for end in ["\n", "\r\n", "\r"] {
        // The first byte of the data looks like a line feed, the second like a carriage return.
        let x = f32::from_le_bytes([10, 13, 0, 64]);
        let header = format!("ply\nformat binary_little_endian 1.0\n{}", vertices(1, &[]));
        let mut bytes = format!("{header}\nend_header\n").replace('\n', end).into_bytes();
        bytes.extend([x, 1.0, 2.0].map(f32::to_le_bytes).concat());
        let found = loaded_of(&bytes).expect("loads");
        assert_eq!(shapes(&found)[0].positions, [vec3(x, 1.0, 2.0)], "{end:?}");
        let text = format!("ply\nformat ascii 1.0\n{}\nend_header\n1 2 3\n", vertices(1, &[]));
        let found = loaded_of(text.replace('\n', end).as_bytes()).expect("loads");
        assert_eq!(shapes(&found)[0].positions, [vec3(1.0, 2.0, 3.0)], "{end:?}");
    }
}

/// Returns a PNG file of one pixel.
fn pixel(color: [u8; 3]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbImage::from_pixel(1, 1, image::Rgb(color));
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("encodes");
    bytes.into_inner()
}

#[test]
fn texture_coordinates_of_corners_bring_their_image() {
    let list = ["list uchar int vertex_indices", "list uchar float texcoord", "int texnumber"];
    let header = format!(
        "comment TextureFile my skin.png\ncomment TextureFile other.png\n{}\n{}",
        vertices(4, &[]),
        element("face", 2, &list)
    );
    let data = format!("{SQUARE}3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 0.5 0 1 1 0 1 1");
    let text = format!("ply\nformat ascii 1.0\n{header}\nend_header\n{data}\n");
    let files = |path: &str| match path {
        "my skin.png" => Some(Cow::Owned(pixel([255, 0, 0]))),
        _ => None,
    };
    let found = load_bytes("thing.ply", text.as_bytes(), &files, &LoadOptions::default());
    let found = found.expect("loads");
    let [first, second] = shapes(&found) else { panic!("one shape for each image") };
    assert_eq!(first.texcoords, [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0)]);
    assert_eq!(second.texcoords, [vec2(0.5, 1.0), Vec2::X, Vec2::ZERO]);
    let material = |i: usize| &found.scene.materials[found.scene.instances[i].material as usize];
    let image = material(1).color_tex.expect("an image");
    assert_eq!(found.scene.textures[image as usize].name, "my skin.png");
    assert_eq!(material(2).color_tex, None);
    assert_warns("the other", &found, &["other.png", "not beside"]);
}
