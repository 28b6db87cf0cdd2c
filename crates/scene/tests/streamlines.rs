//! Streamlines in TCK and TRK files: lines, colours, places, and what is refused.

#![cfg(feature = "load")]

use rotund_geometry::glam::{Vec3, vec3};
use rotund_scene::{Elements, LoadOptions, Loaded, Shape, load_bytes};

fn loaded(name: &str, bytes: &[u8]) -> Result<Loaded, String> {
    let none = |_: &str| None;
    load_bytes(name, bytes, &none, &LoadOptions::default()).map_err(|error| error.to_string())
}

/// Returns the shape of a file that loads without a warning.
fn shape(name: &str, bytes: &[u8]) -> Shape {
    let mut loaded = loaded(name, bytes).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.warnings, Vec::<String>::new());
    loaded.scene.shapes.swap_remove(1)
}

/// A point in a file.
type Point = [f32; 3];

const NAN: Point = [f32::NAN; 3];
const END: Point = [f32::INFINITY; 3];
/// Two streamlines.
const TWO: [Point; 7] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], NAN, [5.0, 5.0, 5.0], [5.0, 5.0, 7.5], END];

/// Returns a TCK file with these lines of the header, where `AT` is replaced by the place of the
/// data, and points in this type.
fn tck(header: &str, datatype: &str, points: &[Point]) -> Vec<u8> {
    let text = format!("mrtrix tracks\ndatatype: {datatype}\n{header}END\n");
    let at = format!("{:04}", text.len() + 2);
    let mut bytes = text.replace("AT", &at).into_bytes();
    for number in points.iter().flatten().copied() {
        match datatype {
            "Float32BE" => bytes.extend(number.to_be_bytes()),
            "Float64LE" => bytes.extend(f64::from(number).to_le_bytes()),
            "Float64BE" => bytes.extend(f64::from(number).to_be_bytes()),
            _ => bytes.extend(number.to_le_bytes()),
        }
    }
    bytes
}

const FILE: &str = "file: . AT\n";

/// The fields of a TRK file that the tests change.
#[derive(Clone)]
struct Trk {
    big: bool,
    version: i32,
    count: i32,
    scalars: i16,
    properties: i16,
    dimensions: [i16; 3],
    voxel_size: Point,
    /// Rows of the transform.
    vox_to_ras: [[f32; 4]; 4],
    voxel_order: &'static [u8],
    hdr_size: i32,
    /// Each with the number of points that it claims.
    streamlines: Vec<(i32, Vec<Point>)>,
}

const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
const ABSENT: [[f32; 4]; 4] = [[0.0; 4]; 4];

impl Trk {
    /// The streamlines of [`TWO`], half a voxel from the corner.
    fn new() -> Self {
        let half = |points: &[Point]| {
            let points = points.iter().map(|point| point.map(|x| x + 0.5)).collect::<Vec<_>>();
            (points.len() as i32, points)
        };
        Self {
            big: false,
            version: 2,
            count: 2,
            scalars: 0,
            properties: 0,
            dimensions: [10, 20, 30],
            voxel_size: [1.0; 3],
            vox_to_ras: IDENTITY,
            voxel_order: b"RAS",
            hdr_size: 1000,
            streamlines: vec![half(&TWO[..3]), half(&TWO[4..6])],
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 1000];
        bytes[..5].copy_from_slice(b"TRACK");
        let i32 = |x: i32| if self.big { x.to_be_bytes() } else { x.to_le_bytes() };
        let i16 = |x: i16| if self.big { x.to_be_bytes() } else { x.to_le_bytes() };
        let f32 = |x: f32| if self.big { x.to_be_bytes() } else { x.to_le_bytes() };
        let mut put = |at: usize, part: &[u8]| bytes[at..at + part.len()].copy_from_slice(part);
        put(6, &self.dimensions.map(i16).concat());
        put(12, &self.voxel_size.map(f32).concat());
        put(36, &i16(self.scalars));
        put(238, &i16(self.properties));
        put(440, &self.vox_to_ras.as_flattened().iter().flat_map(|&x| f32(x)).collect::<Vec<_>>());
        put(948, self.voxel_order);
        put(988, &i32(self.count));
        put(992, &i32(self.version));
        put(996, &i32(self.hdr_size));
        for (count, points) in &self.streamlines {
            bytes.extend(i32(*count));
            for point in points {
                bytes.extend(point.map(f32).concat());
                bytes.extend((0..self.scalars).flat_map(|_| f32(f32::NAN)));
            }
            bytes.extend((0..self.properties).flat_map(|_| f32(-1.0)));
        }
        bytes
    }
}

#[test]
fn streamlines_are_lines_in_every_encoding() {
    let two = Trk::new();
    let table = [
        ("Float32LE", "a.tck", tck(FILE, "Float32LE", &TWO)),
        ("Float32BE", "a.tck", tck(FILE, "Float32BE", &TWO)),
        ("Float64LE", "a.tck", tck(FILE, "Float64LE", &TWO)),
        ("Float64BE", "a.tck", tck(FILE, "Float64BE", &TWO)),
        (
            "other lines in the header, and the right count",
            "a.tck",
            tck("count: 0000000002\nno key\nstep: a: b\nfile: . AT\n", "Float32LE", &TWO),
        ),
        ("line ends of two bytes", "a.tck", tck("file: . AT\r\n", "Float32LE\r", &TWO)),
        ("a last streamline that is closed", "a.tck", {
            tck(FILE, "Float32LE", &[&TWO[..6], &[NAN, END]].concat())
        }),
        ("anything after the end", "a.tck", {
            tck(FILE, "Float32LE", &[&TWO[..], &[[7.0; 3], NAN]].concat())
        }),
        ("TRK", "a.trk", two.bytes()),
        ("big endian", "a.trk", Trk { big: true, ..two.clone() }.bytes()),
        ("an unknown count", "a.trk", Trk { count: 0, ..two.clone() }.bytes()),
        ("a small order", "a.trk", Trk { voxel_order: b"ras ", ..two }.bytes()),
    ];
    for (why, name, bytes) in table {
        let shape = shape(name, &bytes);
        assert_eq!(shape.elements, Elements::Lines(vec![[0, 1], [1, 2], [3, 4]]), "{why}");
        let points = [0, 1, 2, 4, 5].map(|i| Vec3::from(TWO[i]));
        assert_eq!(shape.positions, points, "{why}");
        // Half of the median distance to the nearest neighbour is 1, which would fill the picture:
        // a 50th of half the diagonal of the bounds.
        let most = 0.02 * 0.5 * points.iter().fold(Vec3::ZERO, |most, p| most.max(*p)).length();
        assert!(shape.radii.iter().all(|r| (r / most - 1.0).abs() < 1e-5), "{why}");
    }
}

#[test]
fn a_vertex_has_the_colour_of_its_direction() {
    let half = 0.5_f32.sqrt();
    let table: &[(&str, &[Point], &[Point])] = &[
        // The tangent is that of the neighbours, so a corner has a colour between its sides.
        ("a corner", &TWO[..3], &[[1.0, 0.0, 0.0], [0.4472, 0.8944, 0.0], [0.0, 1.0, 0.0]]),
        ("backwards", &[[0.0; 3], [0.0, -1.0, -1.0]], &[[0.0, half, half]; 2]),
        (
            "there and back",
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]],
            &[[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        ),
        (
            "points that coincide",
            &[[0.0; 3], [0.0; 3], [0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]],
            &[[0.0, 0.0, 1.0]; 6],
        ),
        ("no direction at all", &[[3.0; 3]; 3], &[[1.0; 3]; 3]),
        ("far apart", &[[-3e38, 0.0, 0.0], [3e38, 0.0, 0.0]], &[[1.0, 0.0, 0.0]; 2]),
    ];
    let scene = br#"{ "materials": [{ "color": [1, 1, 1] }], "shapes": [{ "uri": "a.tck" }] }"#;
    for (why, points, expected) in table {
        let bytes = tck(FILE, "Float32LE", &[points, &[NAN, END][..]].concat());
        let files = |_: &str| Some(bytes.clone().into());
        let loaded = load_bytes("scene.json", scene, &files, &LoadOptions::default());
        let shape = loaded.expect("loads").scene.shapes.remove(0);
        assert_eq!(shape.colors.len(), expected.len(), "{why}");
        for (color, expected) in shape.colors.iter().zip(*expected) {
            // Absolute values of the direction are shown as they are, so they are sRGB.
            let linear = |x: f32| if x > 0.1 { ((x + 0.055) / 1.055).powf(2.4) } else { x };
            let expected = Vec3::from(expected.map(linear)).extend(1.0);
            assert!(color.distance(expected) < 1e-3, "{why}: {color} is not {expected}");
        }
        assert_eq!(shape.radii.len(), points.len(), "{why}");
    }
}

#[test]
fn the_header_says_where_streamlines_are() {
    let new = Trk::new();
    let point = vec3(1.0, 2.0, 3.0);
    let moved = [[2.0, 0.0, 0.0, 10.0], [0.0, 0.0, 3.0, 20.0], [0.0, -4.0, 0.0, 30.0], IDENTITY[3]];
    let table = [
        // what the header has, the header, and where it puts `point`
        ("corners of voxels", Trk { ..new.clone() }, point - 0.5),
        (
            "voxels of two millimeters",
            Trk { voxel_size: [2.0, 4.0, 1.0], ..new.clone() },
            vec3(0.0, 0.0, 2.5),
        ),
        // Voxel (0.5, 1.5, 2.5), whose axes run to the right, down, and to the front.
        (
            "a transform",
            Trk { vox_to_ras: moved, voxel_order: b"RIA", ..new.clone() },
            vec3(10.0 + 2.0 * 0.5, 20.0 + 3.0 * 2.5, 30.0 - 4.0 * 1.5),
        ),
        // The same image, read from the other side: voxel 0.5 of 10 is voxel 8.5.
        (
            "another order than the transform",
            Trk { voxel_order: b"LAS", ..new.clone() },
            vec3(9.0 - 0.5, 1.5, 2.5),
        ),
        ("no order, which is LPS", Trk { voxel_order: b"", ..new.clone() }, vec3(8.5, 17.5, 2.5)),
        // The first axis of the file is the third of the transform, and so on.
        (
            "another sequence than the transform",
            Trk { voxel_order: b"SRA", ..new.clone() },
            vec3(1.5, 2.5, 0.5),
        ),
        (
            "another sequence and other sides",
            Trk { voxel_order: b"ILA", ..new.clone() },
            vec3(19.0 - 1.5, 2.5, 9.0 - 0.5),
        ),
        ("no transform", Trk { vox_to_ras: ABSENT, ..new.clone() }, point),
        (
            "no transform, but sides",
            Trk { vox_to_ras: ABSENT, voxel_order: b"LPS", ..new.clone() },
            vec3(-1.0, -2.0, 3.0),
        ),
        (
            "neither",
            Trk { vox_to_ras: ABSENT, voxel_order: b"", voxel_size: [0.0; 3], ..new.clone() },
            point,
        ),
        ("version 1 has no transform", Trk { version: 1, vox_to_ras: moved, ..new }, point),
    ];
    for (why, header, expected) in table {
        let end = [4.0, 4.0, 4.0];
        let streamlines = vec![(2, vec![point.to_array(), end])];
        let shape = shape("a.trk", &Trk { streamlines, count: 1, ..header }.bytes());
        assert!(shape.positions[0].distance(expected) < 1e-5, "{why}: {:?}", shape.positions);
    }
}

#[test]
fn what_can_be_left_out_is_counted_in_one_warning() {
    let point = [1.0, 1.0, 1.0];
    let short = [&TWO[..4], &[point, NAN, NAN, point, NAN], &TWO[4..]].concat();
    let new = Trk::new();
    let more = |count, points| {
        let streamlines = [new.streamlines.clone(), vec![(count, points)]].concat();
        Trk { streamlines, ..new.clone() }
    };
    let mut named = Trk { scalars: 2, properties: 1, ..new.clone() }.bytes();
    named[38..41].copy_from_slice(b"fa\0");
    named[240..246].copy_from_slice(b"length");
    let table: [(&str, &str, Vec<u8>, &[&str]); 8] = [
        (
            "numbers beside the points",
            "a.trk",
            named,
            &["not used of the streamlines: scalar fa, scalar 2, property length"],
        ),
        (
            "one point or none",
            "a.tck",
            tck(FILE, "Float32LE", &short),
            &["3 of 5 streamlines have fewer than two points"],
        ),
        (
            "one point in a TRK",
            "a.trk",
            Trk { count: 3, ..more(1, vec![point]) }.bytes(),
            &["1 of 3 streamlines have fewer than two points"],
        ),
        (
            "no point in a TRK",
            "a.trk",
            Trk { count: 0, ..more(0, vec![]) }.bytes(),
            &["1 of 3 streamlines have fewer than two points"],
        ),
        (
            "another count",
            "a.tck",
            tck("count: 7\nfile: . AT\n", "Float32LE", &TWO),
            &["counts 7 streamlines, but there are 2"],
        ),
        (
            "more than n_count",
            "a.trk",
            more(1, vec![point]).bytes(),
            &["16 bytes after the 2 streamlines"],
        ),
        (
            "an order that is none",
            "a.trk",
            Trk { voxel_order: b"RAR", ..new.clone() }.bytes(),
            &["voxel_order is \"RAR\", expected three letters as in RAS"],
        ),
        (
            "two kinds of trouble",
            "a.tck",
            tck("count: 7\nfile: . AT\n", "Float32LE", &short),
            &["3 of 5", "counts 7 streamlines, but there are 5"],
        ),
    ];
    for (why, name, bytes, expected) in table {
        let loaded = loaded(name, &bytes).unwrap_or_else(|error| panic!("{why}: {error}"));
        let Loaded { scene, warnings, .. } = loaded;
        let lines = Elements::Lines(vec![[0, 1], [1, 2], [3, 4]]);
        assert_eq!(scene.shapes[1].elements, lines, "{why}");
        assert_eq!(warnings.len(), expected.len(), "{why}: {warnings:?}");
        for (warning, part) in warnings.iter().zip(expected) {
            assert!(warning.contains(part) && warning.contains(name), "{why}: {warning}");
        }
    }
}

#[test]
fn damaged_files_of_mrtrix_are_refused() {
    let text = |text: &str| text.as_bytes().to_vec();
    let good = tck(FILE, "Float32LE", &TWO);
    let with = |at: usize, point: Point| {
        let mut points = TWO;
        points[at] = point;
        tck(FILE, "Float32LE", &points)
    };
    let place = |place: &str| tck(&format!("file: {place}\n"), "Float32LE", &TWO);
    let table: [(&str, Vec<u8>, &[&str]); 16] = [
        ("nothing", vec![], &["header", "\"mrtrix tracks\""]),
        ("another format", text("TRACK\0\n"), &["header", "\"mrtrix tracks\""]),
        ("no end of the header", text("mrtrix tracks\nfile: . 9\n"), &["header", "\"END\"", "cut"]),
        ("no type", tck(FILE, "", &TWO), &["datatype", "\"\"", "Float32LE"]),
        ("integers", tck(FILE, "Int32LE", &TWO), &["datatype", "\"Int32LE\"", "Float64BE"]),
        ("no place", tck("", "Float32LE", &TWO), &["\"file\" is \"\"", "a dot"]),
        ("another file", place("data.bin 0"), &["\"file\" is \"data.bin 0\"", "a dot"]),
        ("a place in words", place(". here"), &["\"file\" is \". here\""]),
        ("a place inside the header", place(". 4"), &["\". 4\"", "from 48", "to 132"]),
        ("a place beyond the end", place(". 999"), &["\". 999\"", "to 134"]),
        ("a place beyond all", place(". 99999999999999999999"), &["expected a dot"]),
        ("cut inside a point", good[..good.len() - 18].to_vec(), &["streamline 1", "cut"]),
        ("cut after a streamline", tck(FILE, "Float32LE", &TWO[..4]), &["streamline 1", "cut"]),
        ("one NaN", with(4, [0.0, f32::NAN, 0.0]), &["streamline 1", "point 0", "NaN", "finite"]),
        ("one infinity", with(1, [0.0, 0.0, f32::INFINITY]), &["streamline 0", "point 1", "inf"]),
        ("no streamlines", tck(FILE, "Float32LE", &[END]), &["no points, lines or faces"]),
    ];
    check_refused("a.tck", &table);
    let far = [[1e300; 3], [0.0; 3], [f64::INFINITY; 3]];
    let mut bytes = tck(FILE, "Float64LE", &[]);
    bytes.extend(far.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    check_refused("a.tck", &[("beyond f32", bytes, &["streamline 0", "point 0", "finite"])]);
}

#[test]
fn damaged_files_of_trackvis_are_refused() {
    let new = Trk::new();
    let good = new.bytes();
    let claims = |count: i32| {
        let streamlines = vec![new.streamlines[0].clone(), (count, vec![[0.0; 3]; 2])];
        Trk { streamlines, ..new.clone() }.bytes()
    };
    let nan = vec![(2, vec![[0.0; 3], [0.0, f32::NAN, 0.0]])];
    let mut flat = IDENTITY;
    flat[1] = [0.0; 4];
    let mut endless = IDENTITY;
    endless[0][3] = f32::NAN;
    let table: [(&str, Vec<u8>, &[&str]); 18] = [
        ("nothing", vec![], &["header", "\"TRACK\""]),
        ("another format", b"mrtrix tracks\n".to_vec(), &["header", "\"TRACK\""]),
        ("half a header", good[..500].to_vec(), &["header", "500 bytes", "1000", "cut"]),
        ("another size", Trk { hdr_size: 7, ..new.clone() }.bytes(), &["hdr_size is 7", "1000"]),
        ("scalars below zero", Trk { scalars: -1, ..new.clone() }.bytes(), &["n_scalars is -1"]),
        (
            "properties below zero",
            Trk { properties: -9, ..new.clone() }.bytes(),
            &["n_properties is -9"],
        ),
        ("a count below zero", Trk { count: -2, ..new.clone() }.bytes(), &["n_count is -2"]),
        (
            "more streamlines than there are",
            Trk { count: i32::MAX, ..new.clone() }.bytes(),
            &["n_count is 2147483647", "after 2 streamlines"],
        ),
        ("points below zero", claims(-5), &["streamline 1", "points is -5", "not negative"]),
        ("more points than there are", claims(3), &["streamline 1", "points is 3", "after 2"]),
        ("most points", claims(i32::MAX), &["streamline 1", "2147483647", "after 2"]),
        ("cut inside a point", good[..good.len() - 3].to_vec(), &["streamline 1", "after 1"]),
        ("cut inside a count", good[..1042].to_vec(), &["streamline 1", "cut"]),
        (
            "NaN",
            Trk { streamlines: nan, count: 1, ..new.clone() }.bytes(),
            &["streamline 0", "point 1", "NaN", "finite"],
        ),
        (
            "a flat transform",
            Trk { vox_to_ras: flat, ..new.clone() }.bytes(),
            &["vox_to_ras", "inverse", "0 as its last"],
        ),
        (
            "an endless transform",
            Trk { vox_to_ras: endless, ..new.clone() }.bytes(),
            &["vox_to_ras", "inverse"],
        ),
        (
            "voxels of no size",
            Trk { voxel_size: [1.0, 0.0, 1.0], ..new.clone() }.bytes(),
            &["voxel_size", "positive"],
        ),
        (
            "no streamlines",
            Trk { streamlines: vec![], count: 0, ..new.clone() }.bytes(),
            &["no points, lines or faces"],
        ),
    ];
    check_refused("a.trk", &table);
}

fn check_refused(name: &str, table: &[(&str, Vec<u8>, &[&str])]) {
    for (why, bytes, parts) in table {
        let message = loaded(name, bytes).map(|_| ()).expect_err(why);
        for part in parts.iter().chain([&name]) {
            assert!(message.contains(part), "{why}: {part:?} is not in {message:?}");
        }
        assert!(!message.contains('\n'), "{why}: one line: {message:?}");
    }
}

#[test]
fn files_cut_anywhere_are_refused() {
    let files = [
        ("a.tck", tck(FILE, "Float32LE", &TWO)),
        ("a.tck", tck(FILE, "Float64BE", &TWO)),
        ("a.trk", Trk::new().bytes()),
        ("a.trk", Trk { scalars: 1, properties: 1, big: true, ..Trk::new() }.bytes()),
    ];
    for (name, bytes) in files {
        for length in 0..bytes.len() {
            let message = loaded(name, &bytes[..length]).map(|_| ()).expect_err("cut");
            assert!(message.starts_with(name), "{length} bytes: {message}");
        }
    }
}
