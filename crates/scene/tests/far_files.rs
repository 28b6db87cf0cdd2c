//! Coordinates far from the origin: differences between neighbours survive.

#![cfg(feature = "load")]

use rotund_geometry::glam::{DVec3, Vec3, dvec3};
use rotund_scene::{LoadOptions, Loaded, load_bytes};
use std::borrow::Cow;

/// Points a millimeter apart, and some outliers, about a place in a map and one in space.
fn places(center: DVec3) -> Vec<DVec3> {
    let step = |i: i32| f64::from(i) * 0.001;
    let near = (0..50).map(|i| center + dvec3(step(i), step(2 * i), step(-i)));
    near.chain((0..50).map(|i| center + dvec3(f64::from(i) * 0.25, step(i), 3.5))).collect()
}

const CENTERS: [DVec3; 3] = [
    dvec3(6_000_000.123, 5_429_876.543_21, 317.25),
    dvec3(-2_694_045.125, -4_297_222.017, 3_854_384.625),
    dvec3(477_322.5, 0.25, -6_000_000.333),
];

/// Returns the places in files of every kind that has doubles.
fn files(places: &[DVec3]) -> Vec<(&'static str, Vec<u8>)> {
    let header = |encoding: &str, count: usize| {
        format!(
            "ply\nformat {encoding} 1.0\nelement vertex {count}\nproperty double x\n\
             property double y\nproperty double z\nend_header\n"
        )
    };
    let text = |p: &DVec3| format!("{} {} {}\n", p.x, p.y, p.z);
    let lines: String = places.iter().map(text).collect();
    let numbers = || places.iter().flat_map(|p| p.to_array());
    let mut little = header("binary_little_endian", places.len()).into_bytes();
    little.extend(numbers().flat_map(f64::to_le_bytes));
    let mut big = header("binary_big_endian", places.len()).into_bytes();
    big.extend(numbers().flat_map(f64::to_be_bytes));
    let obj: String = places.iter().map(|p| format!("v {}", text(p))).collect();
    let node =
        |(i, p): (usize, &DVec3)| format!("{i} 3 {} {} {} 1e4 {}\n", p.x, p.y, p.z, i as i64 - 1);
    let swc: String = places.iter().enumerate().map(node).collect();
    // Some programs declare what they write in text as single.
    let ascii = header("ascii", places.len()).replace("double", "float") + &lines;
    vec![
        ("a.ply", ascii.into_bytes()),
        ("b.ply", little),
        ("c.ply", big),
        ("d.obj", obj.into_bytes()),
        ("e.swc", swc.into_bytes()),
    ]
}

fn load(name: &str, files: &[(&str, &[u8])]) -> Loaded {
    let find = |path: &str| {
        files.iter().find(|(name, _)| *name == path).map(|(_, bytes)| Cow::Borrowed(*bytes))
    };
    let bytes = find(name).expect("the file");
    load_bytes(name, &bytes, &find, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Asserts that differences to the first place are right within a fiftieth of a millimeter.
fn assert_differences(why: &str, positions: &[Vec3], places: &[DVec3]) {
    assert_eq!(positions.len(), places.len(), "{why}");
    for (position, place) in positions.iter().zip(places) {
        let found = position.as_dvec3() - positions[0].as_dvec3();
        let error = found.distance(*place - places[0]);
        assert!(error < 2e-5, "{why}: {found} is off by {error} at {place}");
    }
}

#[test]
fn neighbours_far_from_the_origin_keep_their_distance() {
    for center in CENTERS {
        let places = places(center);
        for (name, bytes) in files(&places) {
            let why = format!("{name} at {center}");
            let found = load(name, &[(name, &bytes)]);
            let positions = &found.scene.shapes[1].positions;
            assert_differences(&why, positions, &places);
            assert!(positions.iter().all(|p| p.is_finite() && p.length() < 400.0), "{why}");
            let [warning] = &found.warnings[..] else { panic!("{why}: {:?}", found.warnings) };
            assert!(warning.contains("far from the origin"), "{warning}");
        }
    }
}

#[test]
fn instances_have_the_offset_in_their_frames() {
    for center in CENTERS {
        let places = places(center);
        let [x, y, z] = (-center).to_array();
        for (name, bytes) in files(&places) {
            let scene = format!(
                r#"{{ "shapes": [{{ "uri": "{name}" }}], "materials": [{{}}], "instances": [
                {{ "shape": 0, "material": 0 }},
                {{ "shape": 0, "material": 0,
                  "frame": [1, 0, 0, 0, 1, 0, 0, 0, 1, {x}, {y}, {z}] }},
                {{ "shape": 0, "material": 0, "frame": [0, 2, 0, -2, 0, 0, 0, 0, 2, 5, 0, 0] }}] }}"#
            );
            let found = load("s.json", &[("s.json", scene.as_bytes()), (name, &bytes)]);
            assert_eq!(found.warnings, Vec::<String>::new());
            let positions = &found.scene.shapes[0].positions;
            assert_differences(name, positions, &places);
            let [own, moved, turned] = [0, 1, 2].map(|i| {
                let frame = found.scene.instances[i].world_from_object.as_daffine3();
                frame.transform_point3(positions[0].as_dvec3())
            });
            assert!(own.distance(places[0]) < 1e-4, "{name}: {own}, not {}", places[0]);
            assert!(moved.length() < 1e-4, "{name}: {moved}, back at the origin");
            let expected = 2.0 * dvec3(-places[0].y, places[0].x, places[0].z) + 5.0 * DVec3::X;
            // Half a unit of the last place of the frame.
            assert!(turned.distance(expected) < 1.0, "{name}: {turned}, not {expected}");
        }
    }
}

#[test]
fn near_coordinates_stay_as_they_are() {
    // Wide, in the middle of nowhere, or less than the limit away.
    let tables = [
        vec![dvec3(0.1, 0.2, 0.3), dvec3(-0.1, 1e3, 4095.7)],
        vec![dvec3(-5e6, 0.1, 0.0), dvec3(5e6, 0.2, 0.0), dvec3(1e5, 0.1, 0.0)],
    ];
    for places in tables {
        for (name, bytes) in files(&places) {
            let found = load(name, &[(name, &bytes)]);
            let expected: Vec<Vec3> = places.iter().map(|place| place.as_vec3()).collect();
            assert_eq!(found.scene.shapes[1].positions, expected, "{name}");
            assert_eq!(found.warnings, Vec::<String>::new(), "{name}");
        }
    }
}

#[test]
fn missing_points_at_the_origin_do_not_pull_the_offset() {
    let mut places = places(CENTERS[0]);
    let real = places.len();
    places.extend(vec![DVec3::ZERO; 3 * real]);
    for (name, bytes) in files(&places) {
        let found = load(name, &[(name, &bytes)]);
        let positions = &found.scene.shapes[1].positions;
        assert_differences(name, &positions[..real], &places[..real]);
    }
}
