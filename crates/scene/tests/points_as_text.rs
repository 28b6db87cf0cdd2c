//! Points as text: tables of every custom, and molecules.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec3, Vec4, vec3};
use rotund_scene::{Elements, LoadOptions, Loaded, Shape, load_bytes};

fn result(name: &str, text: &str) -> Result<Loaded, String> {
    load_bytes(name, text.as_bytes(), &|_| None, &LoadOptions::default())
        .map_err(|error| error.to_string())
}

fn loaded(name: &str, text: &str) -> Loaded {
    result(name, text).unwrap_or_else(|error| panic!("{text:?}: {error}"))
}

/// Returns the points of a file, which is read without a warning.
fn points(name: &str, text: &str) -> Shape {
    let mut loaded = loaded(name, text);
    assert!(loaded.warnings.is_empty(), "{name} {text:?}: {:?}", loaded.warnings);
    loaded.scene.shapes.pop().expect("a shape")
}

const TWO: [Vec3; 2] = [vec3(1.5, 2.5, 3.5), vec3(-4.0, 0.25, 60.0)];

#[test]
fn rows_of_three_numbers_are_points_whatever_is_between_them() {
    for (name, text) in [
        ("a.xyz", "1.5 2.5 3.5\n-4 0.25 60\n"),
        ("a.xyz", "  1.5\t2.5   3.5  \n\n-4 .25 6e1"),
        ("a.txt", "1.5\t2.5\t3.5\n-4.0\t0.25\t60.\n"),
        ("a.csv", "1.5,2.5,3.5\n-4,0.25,60\n"),
        ("a.csv", "1.5, 2.5, 3.5\n-4, 0.25, 60\n"),
        ("a.csv", "1.5;2.5;3.5\n-4;0.25;60\n"),
        ("a.csv", "1,5;2,5;3,5\n-4;0,25;60\n"),
        ("a.txt", "1,5 2,5 3,5\n-4,0 0,25 60,0\n"),
        ("a.txt", "1,5\t2,5\t3,5\n-4\t0,25\t60\n"),
        ("a.csv", "\"1.5\",\"2.5\",\"3.5\"\n\"-4\",\"0.25\",\"60\"\n"),
        ("a.csv", "1.5,2.5,3.5,\n-4,0.25,60,\n"),
        ("a.txt", "1.5|2.5|3.5\n-4|0.25|60\n"),
        ("a.txt", "1.5, 2.5 3.5\n-4, 0.25 60\n"),
        ("a.asc", "+1.5 2.5 3.5\n-4 2.5D-01 6.0d+1\n"),
        ("a.txt", "1.5 2.5 3.5\r\n-4 0.25 60\r\n"),
        ("a.txt", "1.5 2.5 3.5\r-4 0.25 60\r"),
        ("a.txt", "\u{feff}1.5 2.5 3.5\n-4 0.25 60\n"),
        ("a.txt", "# a comment\n// another\n1.5 2.5 3.5\n# between\n-4 0.25 60\n"),
        ("a.txt", "x y z\n1.5 2.5 3.5\n-4 0.25 60\n"),
        ("a.csv", "X,Y,Z\n1.5,2.5,3.5\n-4,0.25,60\n"),
        ("a.csv", "\"Z\",\"X\",\"Y\"\n3.5,1.5,2.5\n60,-4,0.25\n"),
        ("a.csv", "Points:0,Points:1,Points:2\n1.5,2.5,3.5\n-4,0.25,60\n"),
        ("a.txt", "//X Y Z\n1.5 2.5 3.5\n-4 0.25 60\n"),
        ("a.txt", "# x, y, z\n1.5 2.5 3.5\n-4 0.25 60\n"),
        ("a.txt", "a title\nEasting (m)\tNorthing (m)\tHeight (m)\n1.5\t2.5\t3.5\n-4\t0.25\t60\n"),
        ("a.txt", "P1 1.5 2.5 3.5\nP2 -4 0.25 60\n"),
        ("a.pts", "2\n1.5 2.5 3.5\n-4 0.25 60\n"),
        ("a.PTS", "1\n1.5 2.5 3.5\n1\n-4 0.25 60\n"),
    ] {
        let shape = points(name, text);
        assert_eq!(shape.positions, TWO, "{name} {text:?}");
        assert_eq!(shape.elements, Elements::Points(2), "{text:?}");
        assert!(shape.colors.is_empty() && shape.normals.is_empty(), "{text:?}");
    }
}

/// Linear red, green and blue of 255, 128 and 0.
const ORANGE: Vec3 = vec3(1.0, 0.215_860_5, 0.0);

#[test]
fn colours_are_srgb_of_bytes_words_or_shares() {
    for (name, text) in [
        ("a.xyz", "1.5 2.5 3.5 255 128 0\n-4 0.25 60 255 128 0\n"),
        ("a.txt", "1.5 2.5 3.5 1.0 0.5019608 0.0\n-4 0.25 60 1 0.5019608 0\n"),
        ("a.txt", "1.5 2.5 3.5 65535 32896 0\n-4 0.25 60 65535 32896 0\n"),
        ("a.pts", "2\n1.5 2.5 3.5 -1200 255 128 0\n-4 0.25 60 12 255 128 0\n"),
        ("a.xyz", "nan nan nan 0 0 0\n1.5 2.5 3.5 255 128 0\n-4 0.25 60 255 128 0\n"),
        ("a.csv", "x,y,z,red,green,blue\n1.5,2.5,3.5,255,128,0\n-4,0.25,60,255,128,0\n"),
        ("a.csv", "r,g,b,x,y,z\n255,128,0,1.5,2.5,3.5\n255,128,0,-4,0.25,60\n"),
        ("a.asc", "//X Y Z Rf Gf Bf\n1.5 2.5 3.5 1 0.501961 0\n-4 0.25 60 1 0.501961 0\n"),
        ("a.csv", "x,y,z,r,g,b,a\n1.5,2.5,3.5,255,128,0,255\n-4,0.25,60,255,128,0,255\n"),
        ("a.txt", "1.5 2.5 3.5 255 128 0 255\n-4 0.25 60 255 128 0 255\n"),
    ] {
        let mut loaded = loaded(name, text);
        let shape = loaded.scene.shapes.pop().expect("a shape");
        assert_eq!(shape.positions, TWO, "{text:?}");
        assert_eq!(shape.colors.len(), 2, "{text:?}");
        for color in &shape.colors {
            assert!(color.distance(ORANGE.extend(1.0)) < 1e-4, "{text:?}: {color}");
        }
    }
}

#[test]
fn intensities_are_greys_normals_are_normals_and_radii_radii() {
    for (name, text) in [
        ("a.xyz", "1.5 2.5 3.5 -2000\n-4 0.25 60 1500\n"),
        ("a.csv", "x,y,z,Intensity\n1.5,2.5,3.5,0\n-4,0.25,60,65535\n"),
        ("a.csv", "x,y,z,scalar_reflectance\n1.5,2.5,3.5,0.25\n-4,0.25,60,0.5\n"),
    ] {
        let shape = points(name, text);
        let [dark, bright] = shape.colors[..] else { panic!("{text:?}: {:?}", shape.colors) };
        assert_eq!((dark, bright), (Vec3::ZERO.extend(1.0), Vec4::ONE), "{text:?}");
    }
    for (name, text) in [
        ("a.xyz", "1.5 2.5 3.5 0.6 0 -0.8\n-4 0.25 60 0.6 0 -0.8\n"),
        ("a.csv", "x,y,z,nx,ny,nz\n1.5,2.5,3.5,0.6,0,-0.8\n-4,0.25,60,0.6,0,-0.8\n"),
    ] {
        assert_eq!(points(name, text).normals, [vec3(0.6, 0.0, -0.8); 2], "{text:?}");
    }
    let both = points("a.xyz", "1 2 3 255 0 0 0.6 0 -0.8\n4 5 6 0 0 255 0 1 0\n");
    assert_eq!(both.normals, [vec3(0.6, 0.0, -0.8), Vec3::Y]);
    assert_eq!(both.colors, [Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0)]);
    let across = points("a.txt", "x y z size\n1.5 2.5 3.5 1\n-4 0.25 60 0.5\n");
    assert_eq!(across.radii, [0.5, 0.25]);
    for names in ["x y z radius", "x y z r", "x y z pscale"] {
        let shape = points("a.txt", &format!("{names}\n1.5 2.5 3.5 0.5\n-4 0.25 60 0.25\n"));
        assert_eq!(shape.radii, [0.5, 0.25], "{names}");
    }
}

#[test]
fn what_is_left_out_is_named() {
    for (why, name, text, words) in [
        ("rows of no points", "a.txt", "1 2 3\noops\n4 5\n4 5 6\n", &["2 lines", "line 2"][..]),
        ("points that are not numbers", "a.xyz", "1 2 3\nnan nan nan\n4 5 6\n", &["1 of 3"]),
        ("a count that is wrong", "a.pts", "3\n1 2 3\n4 5 6\n", &["has 2", "announces 3"]),
        ("names", "a.csv", "x,y,z,time,class\n1,2,3,4,5\n", &["time, class"]),
        ("columns behind the names", "a.txt", "x y z\n1 2 3 4\n4 5 6 7\n", &["column 4"]),
        ("numbers of points", "a.txt", "1 .5 2.5 3.5\n2 .5 2.5 4.5\n3 .5 2.5 5.5\n", &["column 1"]),
        ("columns", "a.txt", "1 2 3 4 1e9\n4 5 6 7 2e9\n", &["column 4, column 5"]),
        (
            "intensity beside colours",
            "a.csv",
            "x,y,z,r,g,b,intensity\n1,2,3,4,5,6,7\n",
            &["intensity"],
        ),
    ] {
        let loaded = loaded(name, text);
        let said = loaded.warnings.join("; ");
        for word in words {
            assert!(said.contains(word), "{why}: {said}");
        }
        let count = loaded.scene.shapes[1].positions.len();
        let expected = match why {
            "names" | "intensity beside colours" => 1,
            "numbers of points" => 3,
            _ => 2,
        };
        assert_eq!(count, expected, "{why}");
    }
}

#[test]
fn a_text_of_something_else_is_refused_with_its_line() {
    for (name, text, words) in [
        ("a.txt", "", "no points"),
        ("a.txt", "# nothing\n\n", "no points"),
        ("a.csv", "name,age\nAda,36\nAlan,41\n", "line 1"),
        ("a.txt", "Dear reader,\nthis is a letter.\n", "\"Dear reader,\""),
        ("a.pts", "version: 1\nn_points: 2\n{\n1.0 2.0\n3.0 4.0\n}\n", "line 1"),
        ("a.txt", "1 2 3\nthen\nmany\nlines\nof\ntext\n", "line 2"),
        ("a.xyz", "3\n\nO 0 0 0\nH 0 0 1\n", "ends before atom 2 of 3"),
        ("a.xyz", "2\n\nO 0 0 0\nH 0 zero 1\n", "line 4: y is \"zero\""),
        ("a.xyz", "2\n\nO 0 0 0\nH 0 0\n", "line 4: has no z"),
        ("a.xyz", "18446744073709551615\n\nO 0 0 0\n", "ends before atom 1"),
    ] {
        let error = result(name, text).map(|_| ()).expect_err(text);
        assert!(error.contains(words) && error.contains(name), "{text:?}: {error}");
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn a_point_far_away_keeps_its_millimetres() {
    let text = "6000000.001 400000.5 120\n6000000.002 400000.5 120\n6000000.003 400000.5 120\n";
    let loaded = loaded("a.xyz", text);
    let positions = &loaded.scene.shapes[1].positions;
    for pair in positions.windows(2) {
        assert!((pair[0].distance(pair[1]) - 0.001).abs() < 1e-6, "{positions:?}");
    }
    assert!(
        loaded.warnings.iter().any(|w| w.contains("far from the origin")),
        "{:?}",
        loaded.warnings
    );
}

const WATER: &str = "3\nwater\nO 0.000 0.000 0.117\nH 0.000 0.757 -0.469\nH 0.000 -0.757 -0.469\n";

#[test]
fn atoms_have_the_colours_and_radii_of_their_elements() {
    for (name, text) in [
        ("a.xyz", WATER.to_owned()),
        ("a.txt", WATER.to_owned()),
        ("a.xyz", WATER.replace('\n', "\r\n")),
        ("a.xyz", WATER.replace('\n', "\r")),
        ("a.xyz", WATER.replace("O ", "8 ").replace("H ", "1 ")),
        ("a.xyz", WATER.replace("O ", "o1 ").replace("H ", "h\t")),
        ("a.xyz", WATER.replace("water", "").replace("3\n", "  3  \n")),
        ("a.xyz", WATER.replace("3\nwater\n", "")),
        ("a.xyz", WATER.replace("0.117", "0.117 -0.8 0.1 0.2")),
        (
            "a.xyz",
            WATER.replace("water", "Lattice=\"9 0 0\" Properties=species:S:1:pos:R:3 pbc=\"F\""),
        ),
    ] {
        let shape = points(name, &text);
        assert_eq!(shape.positions[0], vec3(0.0, 0.0, 0.117), "{text:?}");
        assert_eq!(shape.radii, [1.52, 1.1, 1.1], "{text:?}");
        let red = Vec4::new(1.0, 0.004_024_717, 0.004_024_717, 1.0);
        assert!(shape.colors[0].distance(red) < 1e-4, "{text:?}: {}", shape.colors[0]);
        assert_eq!(shape.colors[1..], [Vec4::ONE; 2], "{text:?}");
    }
}

#[test]
fn further_frames_and_names_of_no_element_are_named() {
    let frames = format!("{WATER}{WATER}");
    for (why, text, words) in [
        ("frames", frames.as_str(), "line 6"),
        ("more atoms than announced", &format!("{WATER}C 0 0 0\n"), "1 lines after the 3 atoms"),
        ("labels", &WATER.replace("O ", "OW ").replace("H ", "HW1 "), "OW, HW1"),
        ("dummies", &WATER.replace("O ", "X "), "no element is named X"),
    ] {
        let loaded = loaded("a.xyz", text);
        assert_eq!(loaded.scene.shapes[1].positions.len(), 3, "{why}");
        assert!(
            loaded.warnings.len() == 1 && loaded.warnings[0].contains(words),
            "{why}: {:?}",
            loaded.warnings
        );
    }
}

#[test]
fn extended_files_name_their_columns() {
    let text = "2\nProperties=\"pos:R:3:forces:R:3:species:S:1:radius:R:1:color:R:3\"\n\
        0 0 0 9 9 9 C 0.5 1 0 0\n1 0 0 9 9 9 C 0.25 0 0 1\n";
    let loaded = loaded("a.xyz", text);
    let shape = &loaded.scene.shapes[1];
    assert_eq!(shape.positions, [Vec3::ZERO, Vec3::X]);
    assert_eq!(shape.radii, [0.5, 0.25]);
    assert_eq!(shape.colors, [Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0)]);
    assert!(loaded.warnings[0].contains("forces"), "{:?}", loaded.warnings);
}

#[test]
fn a_scene_may_name_points_as_text() {
    let json = br#"{ "shapes": [{ "uri": "a.xyz" }], "materials": [{ "color": [1, 1, 1] }],
        "instances": [{ "shape": 0, "material": 0 }] }"#;
    let files = |path: &str| (path == "a.xyz").then_some(WATER.as_bytes().into());
    let scene = load_bytes("a.json", json, &files, &LoadOptions::default()).expect("loads").scene;
    assert_eq!(scene.shapes[0].radii, [1.52, 1.1, 1.1]);
    // z is up in a file by itself.
    let lone = loaded("a.xyz", WATER).scene;
    let up = lone.instances[1].world_from_object.transform_vector3(Vec3::Z);
    assert!(up.distance(Vec3::Y) < 1e-6);
}
