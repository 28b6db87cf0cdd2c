//! Subdivision surfaces, and OBJ files.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec2, Vec3, vec2};
use rotund_scene::{Elements, LoadOptions, Shape, load};
use std::{collections::HashMap, fs};

/// Loads a scene with these fields of a subdivision, whose control mesh is this OBJ file.
fn subdivided(obj: &str, fields: &str) -> Result<Shape, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("control.obj"), obj).expect("writes the mesh");
    let scene = format!(
        r#"{{ "shapes": [{{ "name": "s" }}],
        "textures": [{{ "generator": {{ "bumps": {{ "size": 8, "bumps": 8, "height": 1,
            "displacement": true }} }} }}],
        "subdivs": [{{ "shape": "s", "uri": "control.obj"{fields} }}] }}"#
    );
    fs::write(folder.path().join("scene.json"), scene).expect("writes the scene");
    load(folder.path().join("scene.json"), &LoadOptions::default())
        .map(|loaded| loaded.scene.shapes[0].clone())
        .map_err(|error| error.to_string())
}

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

fn quads(shape: &Shape) -> &[[u32; 4]] {
    match &shape.elements {
        Elements::Quads(quads) => quads,
        other => panic!("quads, not {other:?}"),
    }
}

#[test]
fn one_level_of_a_cube_follows_the_rule() {
    let shape = subdivided(CUBE, r#", "subdivisions": 1"#).expect("subdivides");
    assert_eq!((quads(&shape).len(), shape.positions.len()), (24, 26));
    let has = |p: Vec3| shape.positions.iter().any(|q| q.distance(p) < 1e-6);
    assert!(has(Vec3::Z), "a face point is the middle of the face");
    assert!(
        has(Vec3::new(0.75, 0.75, 0.0)),
        "an edge point is the mean of two ends and two face points"
    );
    // (F + 2 R) / 3 with F = (1, 1, 1) / 3 and R = (2, 2, 2) / 3.
    assert!(has(Vec3::splat(5.0 / 9.0)), "a vertex point");
}

#[test]
fn a_subdivided_cube_approaches_its_limit_and_stays_closed() {
    let shape = subdivided(CUBE, r#", "subdivisions": 4"#).expect("subdivides");
    assert_eq!(quads(&shape).len(), 6 * 4_usize.pow(4));
    let mut edges = HashMap::new();
    for quad in quads(&shape) {
        for i in 0..4 {
            let (a, b) = (quad[i], quad[(i + 1) % 4]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    assert!(edges.values().all(|&count| count == 2), "each edge has two sides");
    for (position, normal) in shape.positions.iter().zip(&shape.normals) {
        assert!(
            normal.dot(position.normalize()) > 0.9,
            "normals point out: {normal} at {position}"
        );
    }
    // The limit of a corner of valence n = 3 is (n² P + 4 ΣE + ΣF) / (n (n + 5)), which is 1/2 for
    // E and F the neighbours along edges and across faces: ((9 + 4 - 1) / 24).
    let corner = shape.positions.iter().map(|p| p.min_element()).fold(0.0, f32::max);
    assert!((corner - 0.5).abs() < 5e-3, "{corner}");
}

#[test]
fn a_flat_sheet_stays_flat_and_keeps_its_straight_borders() {
    let sheet =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    for catmull_clark in [true, false] {
        let fields = format!(r#", "subdivisions": 3, "catmullclark": {catmull_clark}"#);
        let shape = subdivided(sheet, &fields).expect("subdivides");
        assert_eq!(quads(&shape).len(), 64);
        assert!(shape.positions.iter().all(|p| p.z == 0.0 && p.min_element() >= 0.0));
        assert!(shape.normals.iter().all(|n| n.distance(Vec3::Z) < 1e-6), "the normal");
        assert!(shape.texcoords.contains(&vec2(0.5, 0.5)), "texture coordinates are interpolated");
        let corner = shape.positions.contains(&Vec3::ZERO);
        assert_eq!(corner, !catmull_clark, "a smooth border rounds its corners");
    }
}

#[test]
fn texture_coordinates_are_smoothed_inside_their_islands() {
    // Four quads about a point off the middle of the texture.
    let mut sheet = String::new();
    for y in 0..3_u8 {
        for x in 0..3_u8 {
            let (u, v) = if (x, y) == (1, 1) {
                (0.9, 0.7)
            } else {
                (0.5 * f32::from(x), 0.5 * f32::from(y))
            };
            sheet += &format!("v {x} {y} 0\nvt {u} {v}\n");
        }
    }
    for corner in [1, 2, 4, 5] {
        let [a, b, c, d] = [0, 1, 4, 3].map(|step| corner + step);
        sheet += &format!("f {a}/{a} {b}/{b} {c}/{c} {d}/{d}\n");
    }
    let once = |fields: &str| subdivided(&sheet, &format!(r#", "subdivisions": 1{fields}"#));
    let smooth = once("").expect("subdivides");
    let has = |shape: &Shape, uv: Vec2| shape.texcoords.iter().any(|own| own.distance(uv) < 1e-6);
    // (F + 2 R + P) / 4 with P = (0.9, 0.3) and each of its eight neighbours about (0.5, 0.5): F is
    // 0.25 of the way to P, R half of it.
    let off = vec2(0.4, -0.2);
    assert!(has(&smooth, vec2(0.5, 0.5) + 0.5625 * off), "a point inside: {:?}", smooth.texcoords);
    // A mean of two ends and two face points: (0.5, 0) and P, and two of a quarter of P.
    assert!(has(&smooth, vec2(0.5, 0.25) + 0.375 * off), "an edge inside");
    for (x, y) in [(0.0, 0.0), (0.25, 0.0), (0.5, 0.0), (1.0, 0.75), (1.0, 1.0)] {
        assert!(has(&smooth, vec2(x, y)), "the outline of an island stays: {x} {y}");
    }
    let split = once(r#", "catmullclark": false"#).expect("subdivides");
    assert!(has(&split, vec2(0.9, 0.3)), "only split, all stay");
}

#[test]
fn a_mesh_of_no_levels_keeps_the_normals_of_its_file_until_it_is_displaced() {
    let sheet = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 1 0\n\
        f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/1/1\n";
    let displaced = r#", "displacement": 0.5, "displacement_tex": 0"#;
    let flat = r#", "displacement": 0, "displacement_tex": 0"#;
    let table = [
        ("as it is", "", Vec3::Y),
        ("not smoothed", r#", "smooth": false"#, Vec3::Y),
        ("displaced by nothing", flat, Vec3::Y),
        ("displaced", displaced, Vec3::Z),
        ("displaced, not smoothed", &format!(r#"{displaced}, "smooth": false"#), Vec3::Z),
    ];
    for (why, fields, normal) in table {
        let shape = subdivided(sheet, fields).expect(why);
        assert_eq!(shape.normals, [normal; 4], "{why}");
        assert_eq!(quads(&shape), [[0, 1, 2, 2], [0, 2, 3, 3]], "{why}");
    }
    let split = subdivided(sheet, r#", "subdivisions": 1, "smooth": false"#).expect("splits");
    assert_eq!(split.normals, []);
}

#[test]
fn displacement_goes_along_the_normal_by_the_mean_of_all_four_channels_less_a_half() {
    // Eight bumps in eight pixels: all pixels lie at rims, which are black. Alpha is 1.
    let sheet =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let shape =
        subdivided(sheet, r#", "displacement": 0.5, "displacement_tex": 0"#).expect("displaces");
    assert!(shape.positions.iter().all(|p| p.z == 0.5 * (0.25 - 0.5)), "{:?}", shape.positions);
}

#[test]
fn invalid_subdivisions_are_refused() {
    let table: [(&str, &str, &str, &[&str]); 5] = [
        (
            "nowhere in the texture",
            CUBE,
            r#", "displacement": 1, "displacement_tex": 0"#,
            &["subdivs[0].displacement_tex", "no texture coordinates"],
        ),
        ("points", "v 0 0 0\np 1\n", "", &["subdivs[0].uri", "a mesh"]),
        (
            "too many",
            CUBE,
            r#", "subdivisions": 4000000000"#,
            &["subdivs[0].subdivisions", "4000000000"],
        ),
        (
            "no texture",
            CUBE,
            r#", "displacement_tex": 5"#,
            &["subdivs[0].displacement_tex", "1 textures"],
        ),
        (
            "infinite",
            CUBE,
            r#", "displacement": 1e99, "displacement_tex": 0"#,
            &["displacement", "inf"],
        ),
    ];
    for (why, obj, fields, parts) in table {
        let message = subdivided(obj, fields).expect_err(why);
        for part in parts {
            assert!(message.contains(part), "{why}: {part:?} is not in {message:?}");
        }
    }
}

fn lone(obj: &str) -> Result<Shape, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("thing.obj");
    fs::write(&path, obj).expect("writes the mesh");
    load(&path, &LoadOptions::default())
        .map(|mut loaded| loaded.scene.shapes.swap_remove(1))
        .map_err(|error| error.to_string())
}

#[test]
fn obj_faces_lines_and_points_keep_their_kind() {
    let vertices = "# four\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvt 0 1\n";
    let table = [
        ("triangles", "f 1 2 3\nf -4 -2 -1\n", Elements::Triangles(vec![[0, 1, 2], [0, 2, 3]])),
        ("quads", "f 1 2 3 4\n", Elements::Quads(vec![[0, 1, 2, 3]])),
        ("a polyline", "l 1 2 3 # along two sides\n", Elements::Lines(vec![[0, 1], [1, 2]])),
        ("points", "p 1 3\np 4\n", Elements::Points(3)),
        ("vertices alone", "usemtl gold\n", Elements::Points(4)),
    ];
    for (why, elements, expected) in table {
        assert_eq!(lone(&format!("{vertices}{elements}")).expect(why).elements, expected, "{why}");
    }
    let full = lone(&format!("{vertices}f 1/1/1 2/1/1 3/1/1\n")).expect("a full triangle");
    assert_eq!(full.normals, [Vec3::Z; 3]);
    assert_eq!(full.texcoords, [vec2(0.0, 0.0); 3], "v runs up in the file");
}

#[test]
fn a_missing_normal_in_an_obj_is_a_warning() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("thing.obj");
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/2 3/1/3\n";
    fs::write(&path, text).expect("writes the mesh");
    let loaded = load(&path, &LoadOptions::default()).expect("loads");
    assert_eq!(loaded.scene.shapes[1].normals, []);
    assert_eq!(loaded.scene.shapes[1].texcoords.len(), 3, "all else stays");
    let [warning] = &loaded.warnings[..] else { panic!("one warning: {:?}", loaded.warnings) };
    for part in ["thing.obj", "line 6", "normal 2", "there are 1"] {
        assert!(warning.contains(part), "{part:?} is not in {warning:?}");
    }
}

#[test]
fn bad_obj_lines_are_named() {
    let table: [(&str, &str, &[&str]); 7] = [
        ("too few numbers", "v 0 0\n", &["line 1", "3 numbers"]),
        ("a word", "v 0 0 zero\n", &["line 1", "\"zero\""]),
        ("no such vertex", "v 0 0 0\nf 1 1 2\n", &["line 2", "vertex 2", "there are 1"]),
        ("vertex zero", "v 0 0 0\np 0\n", &["line 2", "vertex 0"]),
        ("far back", "v 0 0 0\np -9223372036854775808\n", &["line 2", "-9223372036854775808"]),
        ("no vertex", "v 0 0 0\np /1\n", &["line 2", "no vertex"]),
        ("not a number", "v 0 nan 0\n", &["vertex 0", "NaN"]),
    ];
    for (why, obj, parts) in table {
        let message = lone(obj).expect_err(why);
        for part in parts {
            assert!(message.contains(part), "{why}: {part:?} is not in {message:?}");
        }
    }
}
