//! OBJ and MTL files as other programs write them, and polygons of any outline.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec3, Vec4, vec2, vec3};
use rotund_scene::{Elements, LoadOptions, Loaded, Shape, load_bytes};
use std::borrow::Cow;

/// Loads the first of these files, beside which the others are.
fn loaded(files: &[(&str, &str)]) -> Loaded {
    let find = |path: &str| {
        files.iter().find(|(name, _)| *name == path).map(|(_, text)| Cow::Borrowed(text.as_bytes()))
    };
    let (name, text) = files[0];
    load_bytes(name, text.as_bytes(), &find, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn obj(text: &str) -> Loaded {
    loaded(&[("thing.obj", text)])
}

/// Returns the shapes of the file, after the floor.
fn shapes(loaded: &Loaded) -> &[Shape] {
    &loaded.scene.shapes[1..]
}

fn assert_warns(why: &str, loaded: &Loaded, parts: &[&str]) {
    let [warning] = &loaded.warnings[..] else {
        panic!("{why}: one warning, not {:?}", loaded.warnings)
    };
    for part in parts {
        assert!(warning.contains(part), "{why}: {part:?} is not in {warning:?}");
    }
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn colours_stand_behind_the_coordinates() {
    let table = [
        ("three numbers", "v 0 0 0 1 0 0.5\n", [1.0, 0.0, 0.214_041, 1.0], 0),
        ("with opacity", "v 0 0 0 1 0 0.5 0.25\n", [1.0, 0.0, 0.214_041, 0.25], 0),
        ("bytes", "v 0 0 0 255 0 188\n", [1.0, 0.0, 0.502_886, 1.0], 1),
    ];
    for (why, text, color, warnings) in table {
        let found = obj(text);
        let shape = &shapes(&found)[0];
        assert!(shape.colors[0].distance(Vec4::from(color)) < 1e-5, "{why}: {:?}", shape.colors);
        assert_eq!(found.warnings.len(), warnings, "{why}");
    }
    let of_zbrush = obj("#MRGB ff00ff00ffff0000\nv 0 0 0\nv 1 0 0\n#MRGB ff0000ff\nv 2 0 0\n");
    let expected = [vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0)];
    assert_eq!(shapes(&of_zbrush)[0].colors, expected.map(|color| color.extend(1.0)));
    assert_warns("too few", &obj("#MRGB ff00ff00\nv 0 0 0\nv 1 0 0\n"), &["MRGB", "1 for 2"]);
    assert!(shapes(&obj("v 0 0 0 1.0\n"))[0].colors.is_empty(), "a weight is no colour");
    let some = obj("v 0 0 0\nv 1 0 0 1 0 0\nv 2 0 0\n");
    assert_eq!(shapes(&some)[0].colors[0], Vec4::ONE, "those without are white");
}

#[test]
fn loose_edges_and_points_beside_faces_are_shapes_of_their_own() {
    let text = format!("o Roof\n{SQUARE}v 0 2 0\nv 1 2 0\nf 1 2 3\nl 2 5\nl 5 6\np 4 1\n");
    let found = obj(&text);
    let [faces, lines] = shapes(&found) else { panic!("two shapes") };
    assert_eq!(faces.elements, Elements::Triangles(vec![[0, 1, 2]]));
    assert!(faces.radii.is_empty());
    // Points beside lines are balls of the same body.
    let expected = vec![[0, 1], [1, 2], [3, 3], [4, 4]];
    assert_eq!(lines.elements, Elements::Lines(expected));
    let places = [Vec3::X, vec3(0.0, 2.0, 0.0), vec3(1.0, 2.0, 0.0), Vec3::Y, Vec3::ZERO];
    assert_eq!(lines.positions, places);
    assert_eq!(lines.radii.len(), 5);
    let found = obj(&format!("{SQUARE}f 1 2 3\np 4\n"));
    let [_, points] = shapes(&found) else { panic!("two shapes") };
    assert_eq!((&points.elements, points.positions[0]), (&Elements::Points(1), Vec3::Y));
    assert_eq!(found.warnings, Vec::<String>::new());
}

#[test]
fn a_scene_has_an_instance_of_every_shape_of_a_file() {
    let scene = r#"{ "materials": [{}, {}], "shapes": [{ "name": "a", "uri": "thing.obj" },
        { "name": "b", "uri": "plain.obj" }], "instances": [{ "shape": 0, "material": 1 },
        { "shape": 1, "material": 0 }, { "shape": 0, "material": 0,
          "frame": [1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 0, 0] }] }"#;
    let thing = format!("{SQUARE}f 1 2 3\nl 1 4\n");
    let plain = format!("{SQUARE}f 1 2 3\n");
    let found = loaded(&[("scene.json", scene), ("thing.obj", &thing), ("plain.obj", &plain)]);
    let of = |i: usize| {
        let instance = &found.scene.instances[i];
        (instance.shape, instance.material, instance.world_from_object.translation.x)
    };
    assert_eq!(found.scene.shapes.len(), 3);
    assert_eq!([of(3), of(4)], [(2, 1, 0.0), (2, 0, 5.0)]);
    assert!(matches!(found.scene.shapes[2].elements, Elements::Lines(_)));
    assert_eq!(found.scene.shapes[2].name, "a");
}

const TWO: &str = "mtllib my colours.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\n\
    usemtl red #1\nf 1/1 2/1 3/1\nusemtl blue\nf 1/1 3/1 4/1\n";
const MTL: &str = "# made by hand\nnewmtl red #1\r\nKa 1 1 1\nKd 0.9 0.05 0.05\nd 1.0\nillum 2\n\n\
    newmtl blue\nKd 0 0 0.5\nNs 96\nKe 0 0 0\n";

#[test]
fn faces_have_the_colours_of_their_materials() {
    let found = loaded(&[("thing.obj", TWO), ("my colours.mtl", MTL)]);
    assert_eq!(found.warnings, Vec::<String>::new());
    assert_eq!(found.files.len(), 2);
    let materials: Vec<_> = found.scene.instances[1..]
        .iter()
        .map(|instance| &found.scene.materials[instance.material as usize])
        .map(|material| (material.name.as_str(), material.color))
        .collect();
    let expected = [("red #1", vec3(0.9, 0.05, 0.05)), ("blue", vec3(0.0, 0.0, 0.5))];
    assert_eq!(materials, expected);
    // A scene has its own material, which these colours scale.
    let scene = r#"{ "materials": [{}], "shapes": [{ "uri": "thing.obj" }],
        "instances": [{ "shape": 0, "material": 0 }] }"#;
    let found = loaded(&[("s.json", scene), ("thing.obj", TWO), ("my colours.mtl", MTL)]);
    assert_eq!((found.scene.shapes.len(), found.warnings.len()), (1, 0));
    assert_eq!(found.files.len(), 3);
    let shape = &found.scene.shapes[0];
    let Elements::Triangles(triangles) = &shape.elements else { panic!("triangles") };
    let color = |face: usize, corner: usize| shape.colors[triangles[face][corner] as usize];
    assert_eq!(color(0, 0), expected[0].1.extend(1.0));
    assert_eq!(color(1, 0), expected[1].1.extend(1.0));
}

#[test]
fn what_materials_miss_or_hold_more_is_a_warning() {
    let with = |mtl: &str| loaded(&[("thing.obj", TWO), ("my colours.mtl", mtl)]);
    let more = MTL.replace("Ke 0 0 0", "Ke 1 0 0\nmap_Bump -bm 0.5 b.png\nmap_Bump b.png");
    assert_warns("more", &with(&more), &["my colours.mtl", "Ke, map_Bump"]);
    let bad = MTL.replace("0 0 0.5", "spectral a.rfl");
    let found = with(&bad);
    assert!(found.warnings[0].contains("line 9"), "{:?}", found.warnings);
    let unnamed = obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl\nf 1 2 3\n");
    assert_eq!(unnamed.warnings, Vec::<String>::new(), "no material");
    let quoted = TWO.replace("my colours.mtl", "\"my colours.mtl\"");
    let found = loaded(&[("thing.obj", &quoted), ("my colours.mtl", MTL)]);
    assert_eq!(found.warnings, Vec::<String>::new(), "a name in quotes");
    let absent = obj(TWO);
    assert!(absent.warnings.iter().any(|w| w.contains("my")), "{:?}", absent.warnings);
    let last = absent.warnings.last().expect("a warning");
    assert!(last.contains("red #1, blue"), "{last}");
    let scene = r#"{ "shapes": [{ "uri": "thing.obj" }] }"#;
    let one = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl gold\nf 1 2 3\n";
    let found =
        loaded(&[("s.json", scene), ("thing.obj", one), ("m.mtl", "newmtl gold\nKd 1 1 0")]);
    assert_warns("the scene decides", &found, &["thing.obj", "gold", "the scene"]);
}

#[test]
fn lines_have_the_colours_of_their_materials() {
    let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2\nusemtl red\nl 2 3\nf 1 2 3\n";
    let found = loaded(&[("thing.obj", text), ("m.mtl", "newmtl red\nKd 0.9 0.1 0.1\n")]);
    assert_eq!(found.warnings, Vec::<String>::new());
    let shape = &shapes(&found)[1];
    let Elements::Lines(lines) = &shape.elements else { panic!("lines") };
    let colors = |line: usize| lines[line].map(|end| shape.colors[end as usize].truncate());
    assert_eq!(colors(0), [Vec3::ONE; 2]);
    assert_eq!(colors(1), [vec3(0.9, 0.1, 0.1); 2]);
}

#[test]
fn options_of_an_image_that_would_move_it_are_named() {
    let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";
    let of = |options: &str| {
        let mtl = format!("newmtl a\nKd 1 1 1\nmap_Kd {options} a b.hdr\n");
        loaded(&[("thing.obj", text), ("m.mtl", &mtl), ("a b.hdr", IMAGE)])
    };
    assert_warns("moved", &of("-s 2 2 1 -o 0 0 0 -bm 2"), &["not used", "-s of map_Kd"]);
    for neutral in ["", "-s 1 1 1 -o 0 0 -mm 0 1", "-clamp off -bm 1.0"] {
        let found = of(neutral);
        assert_eq!(found.warnings, Vec::<String>::new(), "{neutral}");
        assert_eq!(
            found.scene.textures.len(),
            3,
            "{neutral}: those of floor and sky, and the image"
        );
    }
}

/// An image of one red pixel, a Radiance file in text and bytes below 128.
const IMAGE: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n@\0\0|";

#[test]
fn images_of_materials_are_found_by_the_path_of_any_machine() {
    let elsewhere = ["C:", "work", "red skin", "skin.hdr"].join("\\");
    let absolute = ["", "home", "someone", "skin.hdr"].join("/");
    for path in [
        "skin.hdr",
        "-s 1 1 -mm 0 1 skin.hdr",
        "-clamp off skin.hdr",
        "tex\\skin.hdr",
        &elsewhere,
        &absolute,
    ] {
        let mtl = format!("newmtl red #1\nKd 0.5 1 1\nmap_Kd {path}\nnewmtl blue\nKd 0 0 1\n");
        let inside = if path.starts_with("tex") { "tex/skin.hdr" } else { "skin.hdr" };
        let files = [("thing.obj", TWO), ("my colours.mtl", mtl.as_str()), (inside, IMAGE)];
        let found = loaded(&files);
        assert_eq!(found.warnings, Vec::<String>::new(), "{path}");
        let material = &found.scene.materials[found.scene.instances[1].material as usize];
        assert_eq!(material.color, vec3(0.5, 1.0, 1.0), "{path}");
        let image = material.color_tex.expect(path);
        assert_eq!(found.scene.textures[image as usize].width, 1, "{path}");
    }
}

#[test]
fn faces_may_come_before_their_vertices() {
    let found = obj("f 1 2 3\nf 1 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n");
    let expected = Elements::Triangles(vec![[0, 1, 2], [0, 2, 3]]);
    assert_eq!(shapes(&found)[0].elements, expected);
    assert_eq!(found.warnings, Vec::<String>::new());
}

#[test]
fn bad_elements_and_corners_are_left_out_and_counted() {
    let found = obj(&format!("{SQUARE}f 1 2 3\nf 1 2\nf 4\nl 2\n"));
    assert_eq!(shapes(&found)[0].elements, Elements::Triangles(vec![[0, 1, 2]]));
    assert_eq!(found.warnings.len(), 3, "{:?}", found.warnings);
    assert!(found.warnings.iter().any(|w| w.contains("1 of 4 vertices")), "{:?}", found.warnings);
    assert!(found.warnings.iter().any(|w| w.contains("2 faces")), "{:?}", found.warnings);
    assert!(found.warnings.iter().any(|w| w.contains("1 lines")), "{:?}", found.warnings);
    let found = obj(&format!("{SQUARE}f 1/1 2/2 3/3 4/4\n"));
    assert!(shapes(&found)[0].texcoords.is_empty());
    assert_warns("no texture coordinates", &found, &["line 5", "there are 0", "4 corners"]);
    let found = obj(&format!("{SQUARE}vt 0.5 0\nf 1/1 2/1 3/9\nf 1 3 4\n"));
    let texcoords = &shapes(&found)[0].texcoords;
    assert_eq!(texcoords[..3], [vec2(0.5, 1.0), vec2(0.5, 1.0), vec2(0.0, 0.0)]);
    assert_warns("one is missing", &found, &["texture coordinate 9", "1 corners"]);
    let found = obj("v 0 0 0\nv nan 0 0\nv 1 0 0\n");
    assert_eq!(shapes(&found)[0].positions, [Vec3::ZERO, Vec3::X]);
}

#[test]
fn vertices_that_no_element_names_are_counted() {
    assert_warns("faces", &obj(&format!("{SQUARE}f 1 2 3\n")), &["1 of 4 vertices", "not drawn"]);
    assert_eq!(obj(SQUARE).warnings, Vec::<String>::new(), "points");
    let pole = format!("{SQUARE}v 1 1 0\nf 1 2 3 4\n");
    assert_eq!(obj(&pole).warnings, Vec::<String>::new(), "one is at the same place");
}

#[test]
fn statements_that_are_not_used_are_named_with_their_number() {
    let found = obj(&format!("{SQUARE}vp 0 1\nvp 1 1\ncurv 0 1 1 2\ns off\ng a\nf 1 2 3 4\n"));
    assert_warns("free forms", &found, &["curv (1)", "vp (2)"]);
}

/// Returns the area of a flat polygon by the formula of its corners.
fn area_by_corners(corners: &[Vec3]) -> f64 {
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let sum: f64 =
        pairs.map(|(a, b)| f64::from(a.x) * f64::from(b.y) - f64::from(b.x) * f64::from(a.y)).sum();
    0.5 * sum
}

/// Returns the signed areas of the triangles of a shape, seen along z; a quad is two.
fn areas(shape: &Shape) -> Vec<f64> {
    let area = |[a, b, c]: [u32; 3]| {
        area_by_corners(&[a, b, c].map(|vertex| shape.positions[vertex as usize]))
    };
    match &shape.elements {
        Elements::Triangles(triangles) => triangles.iter().map(|t| area(*t)).collect(),
        Elements::Quads(quads) => {
            quads.iter().flat_map(|&[a, b, c, d]| [area([a, b, c]), area([a, c, d])]).collect()
        }
        other => panic!("faces, not {other:?}"),
    }
}

#[test]
fn concave_polygons_are_covered_once() {
    let table: [(&str, &[[f32; 2]]); 6] = [
        ("an arrow", &[[0., 0.], [2., -1.], [1., 0.], [2., 1.]]),
        ("an arrow from its notch", &[[1., 0.], [2., 1.], [0., 0.], [2., -1.]]),
        ("an L", &[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]),
        (
            "a star, seen from a notch",
            &[[1., 1.], [3., 0.], [2., 2.], [3., 3.], [2., 2.5], [0., 4.]],
        ),
        (
            "a comb",
            &[
                [0., 0.],
                [5., 0.],
                [5., 3.],
                [4., 3.],
                [4., 1.],
                [3., 1.],
                [3., 3.],
                [2., 3.],
                [2., 1.],
                [1., 1.],
                [1., 3.],
                [0., 3.],
            ],
        ),
        (
            "a frame around a hole, with a cut of no width",
            &[
                [0., 0.],
                [4., 0.],
                [4., 4.],
                [0., 4.],
                [0., 0.],
                [1., 1.],
                [1., 3.],
                [3., 3.],
                [3., 1.],
                [1., 1.],
            ],
        ),
    ];
    for (why, corners) in table {
        for turned in [false, true] {
            let mut corners: Vec<Vec3> = corners.iter().map(|c| vec3(c[0], c[1], 0.0)).collect();
            if turned {
                corners.reverse();
            }
            let text: String = corners.iter().map(|c| format!("v {} {} 0\n", c.x, c.y)).collect();
            let names: String = (1..=corners.len()).map(|i| format!(" {i}")).collect();
            let found = obj(&format!("{text}f{names}\n"));
            let (areas, whole) = (areas(&shapes(&found)[0]), area_by_corners(&corners));
            let sum: f64 = areas.iter().sum();
            assert!((sum - whole).abs() < 1e-6, "{why}: {sum} is not {whole}");
            assert!(
                areas.iter().all(|a| a * whole >= 0.0),
                "{why}: none is turned over: {areas:?}"
            );
        }
    }
}

#[test]
fn only_flat_quads_with_a_notch_are_divided() {
    let table = [
        ("convex", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", 1),
        ("an arrow", "v 0 0 0\nv 2 -1 0\nv 1 0 0\nv 2 1 0\n", 2),
        ("an arrow with few digits", "v 0 0 0\nv 2 -1 0\nv 1 0 0.001\nv 2 1 0\n", 2),
        ("an arrow that is not flat", "v 0 0 0\nv 2 -1 0\nv 1 0 1\nv 2 1 0\n", 1),
        ("a bow tie", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\n", 1),
    ];
    for (why, vertices, count) in table {
        let found = obj(&format!("{vertices}f 1 2 3 4\n"));
        assert_eq!(shapes(&found)[0].elements.count(), count, "{why}");
        assert!(matches!(shapes(&found)[0].elements, Elements::Quads(_)), "{why}");
    }
}
