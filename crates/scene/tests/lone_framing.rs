//! A file that is loaded by itself always shows something: what its camera sees, how thick its
//! points and lines are by default, and which way is up.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec2, Vec3, vec2, vec3};
use rotund_scene::{LoadOptions, Loaded, Scene, Trees, Up, load, load_bytes};
use std::{borrow::Cow, fmt::Write as _};

fn loaded_with(name: &str, bytes: &[u8], options: &LoadOptions) -> Loaded {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("writes the file");
    load(&path, options).unwrap_or_else(|error| panic!("{error}"))
}

fn loaded(name: &str, text: &str) -> Loaded {
    loaded_with(name, text.as_bytes(), &LoadOptions::default())
}

/// Returns the points of a cloud as a PLY file.
fn cloud(points: &[Vec3]) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nend_header\n",
        points.len()
    );
    for Vec3 { x, y, z } in points {
        writeln!(text, "{x} {y} {z}").expect("writes");
    }
    text
}

/// Returns points in a cube of side 2 about a center, from an additive recurrence.
fn scattered(count: u32, center: Vec3) -> Vec<Vec3> {
    let steps = vec3(0.819_172_5, 0.671_043_6, 0.549_700_5);
    (0..count).map(|i| center + 2.0 * (i as f32 * steps).fract() - Vec3::ONE).collect()
}

/// Returns the share of the picture, of 720 x 480 pixels, that shows the last instance; its border
/// does not show it.
fn share(scene: &Scene) -> f32 {
    let trees = Trees::build(scene).expect("the scene is valid");
    let last = scene.instances.len() as u32 - 1;
    let size = [720_u32, 480];
    let mut seen = 0;
    for x in 0..size[0] {
        for y in 0..size[1] {
            let uv = vec2((x as f32 + 0.5) / size[0] as f32, (y as f32 + 0.5) / size[1] as f32);
            let ray = scene.cameras[0].ray(uv, Vec2::ZERO);
            if trees.closest(scene, &ray).is_some_and(|hit| hit.instance == last) {
                assert!(x > 0 && y > 0 && x < size[0] - 1 && y < size[1] - 1, "cut by the border");
                seen += 1;
            }
        }
    }
    seen as f32 / (size[0] * size[1]) as f32
}

#[test]
fn far_points_are_counted_and_the_others_fill_the_picture() {
    let mut points = scattered(200, Vec3::ZERO);
    let all = loaded("cloud.ply", &cloud(&points));
    assert!(all.warnings.is_empty(), "{:?}", all.warnings);
    let without = share(&all.scene);
    assert!(without > 0.05, "{without}");
    points.insert(77, vec3(500.0, 20.0, -400.0));
    points.push(vec3(0.0, 0.0, -1e9));
    let with = loaded("cloud.ply", &cloud(&points));
    assert!((share(&with.scene) / without - 1.0).abs() < 0.1, "the same picture");
    assert!(
        with.warnings.len() == 1 && with.warnings[0].contains("2 of 202 vertices"),
        "{:?}",
        with.warnings
    );
}

#[test]
fn only_what_elements_name_is_framed() {
    let octahedron = "v 1 0 0\nv 0 1 0\nv 0 0 1\nv -1 0 0\nv 0 -1 0\nv 0 0 -1\n";
    let faces = "f 1 2 3\nf 1 3 5\nf 1 5 6\nf 1 6 2\nf 4 2 6\nf 4 6 5\nf 4 5 3\nf 4 3 2\n";
    let ply = |stray: &str, count: u32| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
             property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0\n1 0 0\n1 1 0\n{stray}3 0 1 2\n3 2 1 0\n"
        )
    };
    for (name, plain, stray) in [
        ("a.obj", format!("{octahedron}{faces}"), format!("{octahedron}v 900 40 -700\n{faces}")),
        ("a.ply", ply("", 3), ply("900 40 -700\n", 4)),
    ] {
        let expected = share(&loaded(name, &plain).scene);
        assert_eq!(share(&loaded(name, &stray).scene), expected, "{name}");
        assert!(expected > 0.1, "{name}: {expected}");
    }
    // In a scene without a camera too.
    let files = |_: &str| Some(Cow::Owned(ply("900 40 -700\n", 4).into_bytes()));
    let json = br#"{ "shapes": [{ "uri": "a.ply" }], "materials": [{ "color": [1, 1, 1] }],
        "instances": [{ "shape": 0, "material": 0 }] }"#;
    let scene = load_bytes("a.json", json, &files, &LoadOptions::default()).expect("loads").scene;
    assert!(share(&scene) > 0.1);
}

#[test]
fn a_flat_shape_lies_above_the_floor() {
    let plan = "v 0 0 0\nv 4 0 0\nv 4 0 3\nv 0 0 3\nf 4 3 2 1\n";
    let far = plan.replace("v ", "v 100").replace(" 0 ", " 500 ");
    for (name, text) in [("plan.obj", plan), ("far.obj", &far)] {
        let shown = share(&loaded(name, text).scene);
        assert!(shown > 0.05, "{name}: {shown}");
    }
}

#[test]
fn lines_are_neither_lumps_nor_thinner_than_a_pixel() {
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        l 1 2 3 4 1\nl 5 6 7 8 5\nl 1 5\nl 2 6\nl 3 7\nl 4 8\n";
    let spiral: String = (0..5000)
        .map(|i| {
            let (sin, cos) = (i as f32 * 0.001).sin_cos();
            format!("v {cos} {} {sin}\n", i as f32 * 0.0002)
        })
        .collect();
    let indices: String = (1..=5000).map(|i| format!(" {i}")).collect();
    let axon: String = (1..2000)
        .map(|i| format!("{i} 2 {} 0 0 0 {}\n", i, if i == 1 { -1 } else { i - 1 }))
        .collect();
    for (name, text, least, most) in [
        ("cube.obj", cube.to_owned(), 0.01, 0.15),
        ("fibre.obj", format!("{spiral}l{indices}\n"), 0.002, 0.1),
        ("long.obj", "v 0 0 0\nv 1000 0 0\nv 1000 0.001 0\nl 1 2 3\n".to_owned(), 0.001, 0.1),
        ("axon.swc", axon, 0.001, 0.1),
    ] {
        let shown = share(&loaded(name, &text).scene);
        assert!((least..most).contains(&shown), "{name}: {shown}");
    }
}

#[test]
fn points_are_neither_lumps_nor_smaller_than_a_pixel() {
    let corners: Vec<Vec3> =
        (0..8_u8).map(|i| vec3((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into())).collect();
    // Pairs, so that the nearest neighbour says nothing about the whole.
    let pairs: Vec<Vec3> = scattered(500, Vec3::ZERO).iter().flat_map(|&p| [p, p + 1e-5]).collect();
    let spaced: Vec<Vec3> = (0..2).map(|i| vec3(i as f32 * 7.0, 0.0, 0.0)).collect();
    for (name, points, least, most) in [
        ("corners", corners, 0.01, 0.2),
        ("pairs", pairs, 0.001, 0.1),
        ("two", spaced, 0.005, 0.2),
        ("one", vec![vec3(1000.0, 0.0, 0.0)], 0.01, 0.6),
    ] {
        let shown = share(&loaded("points.ply", &cloud(&points)).scene);
        assert!((least..most).contains(&shown), "{name}: {shown}");
    }
}

#[test]
fn streamlines_in_a_scene_get_a_radius_of_their_own_scale() {
    let mut tck = b"mrtrix tracks\ndatatype: Float32LE\ncount: 1\nfile: . 60\nEND\n".to_vec();
    tck.resize(60, 0);
    let points = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.5], [150.0, 2.0, 1.0], [f32::NAN; 3]];
    tck.extend(points.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    tck.extend([f32::INFINITY; 3].iter().flat_map(|x| x.to_le_bytes()));
    let files = |_: &str| Some(Cow::Borrowed(&tck[..]));
    let json = br#"{ "shapes": [{ "uri": "a.tck" }] }"#;
    let scene = load_bytes("a.json", json, &files, &LoadOptions::default()).expect("loads").scene;
    let radius = scene.shapes[0].radii[0];
    assert!((0.2..2.0).contains(&radius), "{radius}");
}

const RADII: &str = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
    property float z\nproperty float radius\nend_header\n";

#[test]
fn radii_that_hide_everything_are_replaced_or_named() {
    let zero = loaded("a.ply", &format!("{RADII}0 0 0 0\n1 0 0 0\n"));
    assert!(share(&zero.scene) > 0.005);
    assert!(zero.warnings.iter().any(|w| w.contains("all radii are 0")), "{:?}", zero.warnings);
    let thin = loaded("a.ply", &format!("{RADII}0 0 0 1e-6\n1 0 0 1e-6\n"));
    assert_eq!(thin.scene.shapes[1].radii, [1e-6; 2], "the data of the file stay");
    assert!(
        thin.warnings.iter().any(|w| w.contains("too small to be seen")),
        "{:?}",
        thin.warnings
    );
    let seen = loaded("a.ply", &format!("{RADII}0 0 0 0.01\n1 0 0 0\n"));
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
}

#[test]
fn alpha_of_zero_at_every_vertex_is_taken_as_opaque() {
    let header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
        property uchar alpha\nend_header\n";
    for (alphas, expected, warned) in
        [([0, 0], [1.0, 1.0], true), ([0, 255], [0.0, 1.0], false), ([255, 255], [1.0, 1.0], false)]
    {
        let [a, b] = alphas;
        let text = format!("{header}0 0 0 255 0 0 {a}\n1 0 0 255 0 0 {b}\n");
        let found = loaded("a.ply", &text);
        let colors = &found.scene.shapes[1].colors;
        assert_eq!([colors[0].w, colors[1].w], expected, "{alphas:?}");
        let said = found.warnings.iter().any(|warning| warning.contains("taken as opaque"));
        assert_eq!(said, warned, "{alphas:?}: {:?}", found.warnings);
    }
}

/// Returns the direction in the world of the z axis of the file.
fn z_of(scene: &Scene) -> Vec3 {
    let instance = scene.instances.last().expect("an instance");
    instance.world_from_object.transform_vector3(Vec3::Z)
}

#[test]
fn each_format_has_an_axis_that_points_up_and_the_option_another() {
    let line = |kind: &str| {
        let cloud = cloud(&[Vec3::ZERO, Vec3::X, Vec3::Z]);
        let list = format!("element {kind} 1\nproperty list uchar int vertex_indices\nend_header");
        cloud.replace("end_header", &list) + "3 0 1 2\n"
    };
    let swc = "1 1 0 0 0 1 -1\n2 3 0 5 0 1 1\n";
    for (name, text, up) in [
        ("a.ply", cloud(&[Vec3::ZERO, Vec3::X, Vec3::Z]), Up::Z),
        ("a.ply", line("face"), Up::Y),
        ("a.ply", line("line"), Up::Y),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n".to_owned(), Up::Y),
        ("a.swc", swc.to_owned(), Up::Y),
    ] {
        for given in [None, Some(Up::Y), Some(Up::Z)] {
            let options = LoadOptions { up: given, ..LoadOptions::default() };
            let scene = loaded_with(name, text.as_bytes(), &options).scene;
            let expected = if given.unwrap_or(up) == Up::Z { Vec3::Y } else { Vec3::Z };
            assert!(z_of(&scene).distance(expected) < 1e-6, "{name} {given:?}: {}", z_of(&scene));
            assert!(share(&scene) > 0.0005, "{name} {given:?}: {}", share(&scene));
        }
    }
    let options = LoadOptions { up: Some(Up::Z), ..LoadOptions::default() };
    let found = loaded_with("a.json", b"{}", &options);
    assert!(found.warnings[0].contains("up axis changes nothing"), "{:?}", found.warnings);
}

#[test]
fn a_shape_with_z_up_stands_on_the_floor() {
    let points: Vec<Vec3> = (0..10).map(|i| vec3(0.0, 0.0, 5.0 + i as f32)).collect();
    let scene = loaded("a.ply", &cloud(&points)).scene;
    let bounds = scene.bounds();
    let shape = &scene.shapes[1];
    let floor = scene.instances[0].world_from_object.translation.y;
    let lowest = 5.0 - shape.radii[0];
    assert!(floor < lowest && floor > lowest - 0.1, "{floor} below {lowest}");
    assert!((bounds.max.y - 14.0 - shape.radii[0]).abs() < 1e-4, "{bounds:?}");
}

#[test]
fn the_floor_can_be_left_out() {
    let options = LoadOptions { without_floor: true, ..LoadOptions::default() };
    let points = cloud(&scattered(20, Vec3::ZERO));
    let scene = loaded_with("a.ply", points.as_bytes(), &options).scene;
    assert_eq!(scene.instances.len(), 1);
    assert!(share(&scene) > 0.01);
}
