//! Neurons and glia in SWC files: which lines they become, what is mended, and what is refused.

#![cfg(feature = "load")]

use rotund_geometry::{
    Ray,
    glam::{Vec2, Vec3, Vec4, vec3},
};
use rotund_scene::{Elements, LoadOptions, Loaded, Shape, Trees, load_bytes};
use std::{borrow::Cow, fmt::Write as _, time::Instant};

fn loaded(text: &str) -> Result<Loaded, String> {
    let none = |_: &str| None;
    load_bytes("cell.swc", text.as_bytes(), &none, &LoadOptions::default())
        .map_err(|error| error.to_string())
}

/// Returns the shape of a file that loads without a warning.
fn shape(text: &str) -> Shape {
    let mut loaded = loaded(text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.warnings, Vec::<String>::new(), "{text}");
    loaded.scene.shapes.swap_remove(1)
}

/// A segment as `x` and radius of both ends, and the name of its colour.
type Segment = ([(f32, f32); 2], &'static str);

/// Returns the segments, sorted by their ends.
fn segments(shape: &Shape) -> Vec<Segment> {
    let Elements::Lines(lines) = &shape.elements else { panic!("no lines: {shape:?}") };
    let end = |vertex: u32| {
        let vertex = vertex as usize;
        (shape.positions[vertex].x, shape.radii[vertex])
    };
    let mut segments: Vec<_> = lines
        .iter()
        .map(|line| {
            let [first, second] = line.map(|vertex| name(shape.colors[vertex as usize]));
            assert_eq!(first, second, "one colour along a segment");
            (line.map(end), first)
        })
        .collect();
    segments.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
    segments
}

/// Returns the type that has this colour.
fn name(color: Vec4) -> &'static str {
    let table = [
        ("soma", [0.8714, 0.7758, 0.0545]),
        ("axon", [0.0, 0.1683, 0.4452]),
        ("basal dendrite", [0.6654, 0.1119, 0.0]),
        ("apical dendrite", [0.6038, 0.1912, 0.3864]),
        ("other", [0.4969, 0.4969, 0.4969]),
    ];
    let found = table.iter().find(|(_, rgb)| color.distance(Vec3::from(*rgb).extend(1.0)) < 1e-3);
    found.unwrap_or_else(|| panic!("no type has the colour {color}")).0
}

#[test]
fn segments_join_children_and_parents_with_the_radii_of_both() {
    let table: &[(&str, &str, &[Segment])] = &[
        (
            "a chain",
            "1 2 0 0 0 1 -1\n2 2 5 0 0 0.5 1\n3 2 9 0 0 0.25 2\n",
            &[([(0.0, 1.0), (5.0, 0.5)], "axon"), ([(5.0, 0.5), (9.0, 0.25)], "axon")],
        ),
        (
            "children before parents",
            "3 2 9 0 0 0.25 2\n2 2 5 0 0 0.5 1\n1 2 0 0 0 1 -1\n",
            &[([(0.0, 1.0), (5.0, 0.5)], "axon"), ([(5.0, 0.5), (9.0, 0.25)], "axon")],
        ),
        (
            "several roots, and ids with gaps",
            "10 3 0 0 0 1 -1\n7 3 5 0 0 1 10\n900 4 6 0 0 1 -1\n0 4 8 0 0 1 900\n",
            &[
                ([(0.0, 1.0), (5.0, 1.0)], "basal dendrite"),
                ([(6.0, 1.0), (8.0, 1.0)], "apical dendrite"),
            ],
        ),
        (
            "a fork",
            "1 0 0 0 0 1 -1\n2 6 5 0 0 1 1\n3 7 -5 0 0 1 1\n",
            &[([(0.0, 1.0), (-5.0, 1.0)], "other"), ([(0.0, 1.0), (5.0, 1.0)], "other")],
        ),
        (
            "types change sharply, and a segment has that of its child",
            "1 2 0 0 0 1 -1\n2 3 5 0 0 0.5 1\n3 -1 9 0 0 0.25 2\n",
            &[([(0.0, 1.0), (5.0, 0.5)], "basal dendrite"), ([(5.0, 0.5), (9.0, 0.25)], "other")],
        ),
        ("a node alone is a ball", "1 4 2 0 0 1 -1\n", &[([(2.0, 1.0); 2], "apical dendrite")]),
        (
            "a soma of one node is a ball, and its branches keep their radius",
            "1 1 0 0 0 5 -1\n2 3 6 0 0 0.5 1\n3 2 -6 0 0 0.25 1\n",
            &[
                ([(0.0, 0.25), (-6.0, 0.25)], "axon"),
                ([(0.0, 0.5), (6.0, 0.5)], "basal dendrite"),
                ([(0.0, 5.0); 2], "soma"),
            ],
        ),
        (
            "a soma below a branch",
            "1 2 0 0 0 0.5 -1\n2 1 6 0 0 5 1\n",
            &[([(0.0, 0.5), (6.0, 0.5)], "axon"), ([(6.0, 5.0); 2], "soma")],
        ),
        (
            "a soma of three nodes is one ball",
            "1 1 0 0 0 4.79498 -1\n2 1 0 4.79 0 4.79498 1\n3 1 0 -4.79 0 4.79498 1\n",
            &[([(0.0, 4.79498); 2], "soma")],
        ),
        (
            "three nodes and no radii: they say where the ball ends",
            "1 1 0 0 0 0 -1\n2 1 4 0 0 0 1\n3 1 -4 0 0 0 1\n4 2 9 0 0 1 1\n",
            &[([(0.0, 1.0), (9.0, 1.0)], "axon"), ([(0.0, 4.0); 2], "soma")],
        ),
        (
            "a soma of three nodes that are not on opposite sides is a tube",
            "1 1 0 0 0 4 -1\n2 1 4 0 0 4 1\n3 1 0 4 0 4 1\n",
            &[([(0.0, 4.0), (0.0, 4.0)], "soma"), ([(0.0, 4.0), (4.0, 4.0)], "soma")],
        ),
        (
            "a soma of three nodes of different radii is a tube",
            "1 1 0 0 0 4 -1\n2 1 4 0 0 3 1\n3 1 -4 0 0 3 1\n",
            &[([(0.0, 4.0), (-4.0, 3.0)], "soma"), ([(0.0, 4.0), (4.0, 3.0)], "soma")],
        ),
        (
            "an outline of a soma is its segments",
            "1 1 0 0 0 1 -1\n2 1 4 0 0 1 1\n3 1 4 4 0 1 2\n4 1 0 4 0 1 3\n",
            &[
                ([(0.0, 1.0), (4.0, 1.0)], "soma"),
                ([(4.0, 1.0), (0.0, 1.0)], "soma"),
                ([(4.0, 1.0), (4.0, 1.0)], "soma"),
            ],
        ),
    ];
    for (why, text, expected) in table {
        assert_eq!(segments(&shape(text)), *expected, "{why}");
    }
}

#[test]
fn rows_in_any_layout_mean_the_same() {
    let expected = shape("1 2 0 0.5 0 1 -1\n2 3 5 -1 0.25 0.5 1\n");
    let table = [
        (
            "comments and empty lines",
            "# A cell\n\n1 2 0 0.5 0 1 -1 # root\n #\n2 3 5 -1 0.25 0.5 1",
        ),
        ("line ends of two bytes", "#\r\n1 2 0 0.5 0 1 -1\r\n2 3 5 -1 0.25 0.5 1\r\n"),
        ("commas", "1,2,0,0.5,0,1,-1\n2,3,5,-1,0.25,0.5,1,\n"),
        ("commas and blanks", "1, 2, 0, 0.5, 0, 1, -1\n2 ,3\t,5 -1, 0.25, 0.5,1\n"),
        ("tabs and blanks", "\t1 2\t0   0.5 0 1 -1 \n  2 3 5 -1 0.25 0.5 1\t\n"),
        ("numbers with exponents", "1e0 2.0 0e3 5e-1 0. 1.0 -1.0\n2 3 +5 -1 .25 0.5 1.000\n"),
        ("more columns", "1 2 0 0.5 0 1 -1 0 7\n2 3 5 -1 0.25 0.5 1 0 x\n"),
        ("a byte order mark", "\u{feff}1 2 0 0.5 0 1 -1\n2 3 5 -1 0.25 0.5 1\n"),
        ("another negative parent", "1 2 0 0.5 0 1 -2\n2 3 5 -1 0.25 0.5 1\n"),
    ];
    for (why, text) in table {
        assert_eq!(shape(text), expected, "{why}");
    }
    let latin = b"# caf\xe9\n1 2 0 0.5 0 1 -1\n2 3 5 -1 0.25 0.5 1\n";
    let options = LoadOptions::default();
    let loaded = load_bytes("cell.swc", latin, &|_: &str| None, &options).expect("loads");
    assert_eq!(loaded.scene.shapes[1], expected, "comments of any encoding");
}

#[test]
fn radii_that_were_not_measured_are_filled_in_with_one_warning() {
    let table: &[(&str, &str, &[f32], &str)] = &[
        (
            "from the parent of the same type, through several nodes",
            "1 2 0 0 0 2 -1\n2 2 1 0 0 0 1\n3 2 2 0 0 0 2\n4 2 3 0 0 1 3\n",
            &[2.0, 2.0, 2.0, 1.0],
            "2 nodes have no radius",
        ),
        (
            "not from the soma, but the median of branches",
            "1 1 0 0 0 9 -1\n2 2 1 0 0 0 1\n3 3 2 0 0 0.5 1\n4 3 3 0 0 0.25 3\n5 3 4 0 0 1 4\n",
            &[0.25, 0.5, 0.5, 0.5, 0.5, 1.0, 9.0],
            "1 nodes have no radius",
        ),
        (
            "a 50th of the reach, less than half the median length of segments",
            "1 2 0 0 0 0 -1\n2 2 3 0 0 0 1\n3 2 7 0 0 0 2\n4 2 9 0 0 0 3\n",
            &[0.09, 0.09, 0.09, 0.09],
            "4 nodes have no radius",
        ),
        ("the default without a length", "1 2 0 0 0 0 -1\n", &[0.001], "1 nodes have no radius"),
        (
            "in words",
            "1 2 0 0 0 1 -1\n2 2 1 0 0 NA 1\n3,2,2,0,0,,2\n4 2 3 0 0 nan 3\n",
            &[1.0, 1.0, 1.0, 1.0],
            "3 nodes have no radius",
        ),
    ];
    for (why, text, expected, warning) in table {
        let loaded = loaded(text).unwrap_or_else(|error| panic!("{why}: {error}"));
        let mut radii = loaded.scene.shapes[1].radii.clone();
        if *why != "from the parent of the same type, through several nodes" {
            radii.sort_by(f32::total_cmp);
        }
        assert_eq!(radii, *expected, "{why}");
        assert_eq!(loaded.warnings.len(), 1, "{why}: {:?}", loaded.warnings);
        let text = &loaded.warnings[0];
        assert!(text.contains(warning) && text.contains("cell.swc"), "{why}: {text}");
    }
}

#[test]
fn nodes_that_are_repeated_count_once_with_one_warning() {
    let row = "2 2 5 0 0 0.5 1\n";
    let loaded = loaded(&format!("1 2 0 0 0 1 -1\n{row}{row}{row}")).expect("loads");
    assert_eq!(segments(&loaded.scene.shapes[1]), [([(0.0, 1.0), (5.0, 0.5)], "axon")]);
    assert_eq!(loaded.warnings, ["cell.swc: 2 nodes are repeated; each counts once"]);
}

#[test]
fn files_that_describe_no_trees_are_refused() {
    let table: &[(&str, &str, &[&str])] = &[
        ("nothing", "", &["no points, lines or faces"]),
        ("comments alone", "# a\n# b\n", &["no points, lines or faces"]),
        ("too few values", "1 1 0 0 0 -1\n", &["line 1", "6 values", "expected 7", "parent"]),
        ("names of columns", "#\nid,type,x,y,z,r,p\n", &["line 2", "type is \"type\"", "#"]),
        ("a word for a number", "1 1 0 up 0 1 -1\n", &["line 1", "y is \"up\"", "a number"]),
        ("half an id", "1.5 1 0 0 0 1 -1\n", &["line 1", "id is \"1.5\"", "an integer"]),
        ("an id below zero", "-3 1 0 0 0 1 -1\n", &["line 1", "id is -3", "not negative"]),
        ("a parent in words", "1 1 0 0 0 1 none\n", &["line 1", "parent is \"none\""]),
        ("an endless id", "inf 1 0 0 0 1 -1\n", &["line 1", "id is \"inf\"", "an integer"]),
        ("NaN", "1 1 0 0 0 1 -1\n2 1 0 0 nan 1 1\n", &["line 2", "z is nan", "finite"]),
        ("beyond f32", "1 1 1e39 0 0 1 -1\n", &["line 1", "x is 1e39", "finite"]),
        ("a negative radius", "1 1 0 0 0 -1 -1\n", &["line 1", "radius is -1", "write 0"]),
        ("an endless radius", "1 1 0 0 0 inf -1\n", &["line 1", "radius is inf", "finite"]),
        (
            "a parent that is not there",
            "# a\n1 1 0 0 0 1 -1\n2 1 0 0 0 1 7\n",
            &["line 3", "node 2", "node 7", "no line describes", "-1"],
        ),
        ("its own parent", "1 1 0 0 0 1 1\n", &["line 1", "node 1", "ancestor of itself", "-1"]),
        (
            "a loop beside a tree",
            "1 1 0 0 0 1 -1\n2 1 0 0 0 1 4\n3 1 0 0 0 1 2\n4 1 0 0 0 1 3\n",
            &["line 2", "node 2", "ancestor of itself"],
        ),
        (
            "two nodes of one id",
            "1 1 0 0 0 1 -1\n1 1 5 0 0 1 -1\n",
            &["line 2", "node 1", "line 1", "its own id"],
        ),
        ("UTF-16", "\u{feff}", &["no points, lines or faces"]),
    ];
    for (why, text, parts) in table {
        let message = loaded(text).map(|_| ()).expect_err(why);
        for part in parts.iter().chain([&"cell.swc"]) {
            assert!(message.contains(part), "{why}: {part:?} is not in {message:?}");
        }
        assert!(!message.contains('\n'), "{why}: one line: {message:?}");
    }
    let bytes = b"\xff\xfe1\0 \0";
    let options = LoadOptions::default();
    let error = load_bytes("cell.swc", bytes, &|_: &str| None, &options).map(|_| ());
    assert!(error.expect_err("refused").to_string().contains("UTF-8"), "UTF-16");
}

#[test]
fn large_trees_of_any_form_take_seconds() {
    const COUNT: usize = 1_000_000;
    let start = Instant::now();
    let rows = |row: &dyn Fn(usize) -> String| {
        (0..COUNT).fold(String::new(), |mut text, i| {
            text.push_str(&row(i));
            text
        })
    };
    let last = COUNT - 1;
    let table = [
        ("roots alone", rows(&|i| format!("{i} 2 {i} 0 0 1 -1\n")), COUNT),
        (
            "a soma with many branches",
            rows(&|i| match i {
                0 => "0 1 0 0 0 1 -1\n".to_owned(),
                _ => format!("{i} 2 {i} 0 0 1 0\n"),
            }),
            COUNT,
        ),
        (
            "a soma of many nodes",
            rows(&|i| match i {
                0 => "0 1 0 0 0 1 -1\n".to_owned(),
                _ => format!("{i} 1 {i} 0 0 0 0\n"),
            }),
            last,
        ),
        (
            "one chain from its end, without radii",
            rows(&|i| match i {
                i if i == last => format!("{i} 2 {i} 0 0 0 -1\n"),
                i => format!("{i} 2 {i} 0 0 0 {}\n", i + 1),
            }),
            last,
        ),
    ];
    for (why, text, count) in table {
        let loaded = loaded(&text).unwrap_or_else(|error| panic!("{why}: {error}"));
        assert_eq!(loaded.scene.shapes[1].elements.count(), count, "{why}");
    }
    let mut ring = rows(&|i| format!("{i} 2 0 0 0 1 {}\n", i + 1));
    writeln!(ring, "{COUNT} 2 0 0 0 1 0").expect("writes to memory");
    let message = loaded(&ring).map(|_| ()).expect_err("a loop");
    assert!(message.contains("ancestor of itself"), "{message}");
    assert!(start.elapsed().as_secs() < 60, "took {:?}", start.elapsed());
}

#[test]
fn a_soma_of_one_node_is_hit_as_a_ball() {
    let scene = loaded("1 1 0 0 0 2 -1\n").expect("loads").scene;
    let trees = Trees::build(&scene).expect("the scene is valid");
    for direction in [Vec3::X, Vec3::NEG_Z, vec3(-1.0, -2.0, 3.0).normalize()] {
        let hit = trees.closest(&scene, &Ray::new(-10.0 * direction, direction));
        let hit = hit.filter(|hit| hit.instance == 1).expect("aimed at its center");
        assert!((hit.t - 8.0).abs() < 1e-5, "{direction}: {hit:?}");
    }
}

#[test]
fn a_scene_may_name_a_neuron_whose_colours_scale_those_of_the_material() {
    let json = br#"{ "materials": [{ "color": [0.5, 1, 0] }], "shapes": [{ "uri": "a.swc" }],
        "instances": [{ "shape": 0, "material": 0 }] }"#;
    let cell = b"1 1 0 0 0 2 -1\n";
    let files = |path: &str| (path == "a.swc").then_some(Cow::Borrowed(&cell[..]));
    let options = LoadOptions::default();
    let scene = load_bytes("scene.json", json, &files, &options).expect("loads").scene;
    let point = scene.eval_material(0, 0, Vec2::splat(0.5));
    let soma = scene.shapes[0].colors[0];
    assert_eq!(point.color, vec3(0.5 * soma.x, soma.y, 0.0));
    // The radius of the command line is for lone files, and replaces all.
    let options = LoadOptions { radius: Some(3.0), ..options };
    let lone = load_bytes("a.swc", cell, &files, &options).expect("loads").scene;
    assert_eq!(lone.shapes[1].radii, [3.0]);
}

#[test]
fn the_floor_is_below_the_thickest_part_and_the_picture_as_large_as_the_cell() {
    let floor = |text: &str| {
        let scene = loaded(text).expect("loads").scene;
        scene.instances[0].world_from_object.translation.y
    };
    let cell = "1 1 0 0 0 1 -1\n2 2 0 9 0 0.5 1\n3 2 8 -9 0 0.5 1\n";
    assert!((-9.6..-9.5).contains(&floor(cell)), "{}", floor(cell));
    let ball = "1 1 0 0 0 10 -1\n2 2 0 9 0 0.5 1\n3 2 8 -9 0 0.5 1\n";
    assert!((-10.1..-10.0).contains(&floor(ball)), "{}", floor(ball));
}
