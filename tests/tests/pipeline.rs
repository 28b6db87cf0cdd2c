//! `compare` and `render` from a scene file to the files they write, in small.

use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs a command of `cargo xtask`.
#[track_caller]
fn xtask(arguments: &[&str]) {
    let all = std::iter::once("xtask").chain(arguments.iter().copied());
    if let Err(error) = xtask::run(all) {
        panic!("{arguments:?}: {error:#}");
    }
}

fn metrics(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("metrics.json")).expect("metrics.json is written");
    serde_json::from_str(&text).expect("metrics.json is JSON")
}

/// Compares a bundled scene at a size that takes a moment.
fn compare(scene: &str, options: &[&str]) -> (tempfile::TempDir, Value) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().to_string_lossy().into_owned();
    // What comes last of an option given twice counts, so `options` can change these.
    let small = ["compare", scene, "--out", &out, "--resolution", "96", "--samples", "2"];
    xtask(&[&small, options].concat());
    let metrics = metrics(folder.path());
    (folder, metrics)
}

/// The bits of all channels of an EXR file.
fn bits(path: &Path) -> Vec<u32> {
    values(path).into_iter().map(f32::to_bits).collect()
}

/// The values of all channels of an EXR file, channel by channel.
fn values(path: &Path) -> Vec<f32> {
    let pixels = exr::prelude::read_first_flat_layer_from_file(path).expect("an EXR file");
    let channels = pixels.layer_data.channel_data.list;
    channels.iter().flat_map(|channel| channel.sample_data.values_as_f32()).collect()
}

#[test]
fn compare_writes_every_file_and_the_documented_metrics() {
    let (folder, metrics) = compare("shapes4", &["--camera", "front", "--seed", "7"]);
    for name in [
        "vanilla.png",
        "vanilla.exr",
        "enhanced.png",
        "enhanced.exr",
        "difference.png",
        "flip.png",
        "metrics.json",
        "report.html",
    ] {
        let length = fs::metadata(folder.path().join(name)).map(|file| file.len());
        assert!(length.is_ok_and(|length| length > 0), "{name}");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 8, "and nothing else");

    assert_eq!(metrics["scene"], "shapes4");
    assert_eq!(metrics["camera"], "front");
    let numbers = ["width", "height", "samples", "seed"].map(|key| metrics[key].as_u64());
    assert_eq!(numbers, [Some(96), Some(32), Some(2), Some(7)]);
    for mode in ["vanilla", "enhanced"] {
        for key in ["build_seconds", "render_seconds", "rays", "rays_per_second"] {
            let value = metrics[mode][key].as_f64();
            assert!(value.is_some_and(|value| value > 0.0), "{mode}.{key} is {value:?}");
        }
        assert_eq!(metrics[mode]["rejected_samples"], 0, "{mode}");
    }
    for key in ["mean_abs", "rmse", "rel_mse", "flip_mean", "changed_fraction"] {
        let value = metrics["difference"][key].as_f64();
        assert!(value.is_some_and(|value| value > 0.0), "difference.{key} is {value:?}");
    }
}

/// A sphere, a cone and a twisted quad side by side under an even sky, each in a third of the
/// picture and too far from the others to be seen in their shading.
fn three_kinds(folder: &Path) -> String {
    let header = |vertices: &str, elements: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\nproperty float radius\nelement {elements}\n"
        )
    };
    let list = "property list uchar int vertex_indices\nend_header\n";
    let files = [
        ("point.ply", header("1", "point 1") + list + "-2 0 0 0.6\n1 0\n"),
        ("line.ply", header("2", "line 1") + list + "-0.4 0 0 0.6\n0.4 0 0 0.3\n2 0 1\n"),
        (
            "quad.ply",
            header("4", "face 1")
                + list
                + "1.4 -0.6 -0.6 0\n2.6 -0.6 0.6 0\n2.6 0.6 -0.6 0\n1.4 0.6 0.6 0\n4 0 1 2 3\n",
        ),
    ];
    for (name, text) in files {
        fs::write(folder.join(name), text).expect("a shape file");
    }
    let json = r#"{
        "asset": { "version": "4.2" },
        "cameras": [{ "name": "front", "frame": [1,0,0, 0,1,0, 0,0,1, 0,0,10], "aspect": 3,
                      "orthographic": true, "lens": 0.006 }],
        "environments": [{ "emission": [1, 1, 1] }],
        "materials": [{ "color": [0.5, 0.5, 0.5], "type": "reflective", "roughness": 0.3 }],
        "shapes": [{ "uri": "point.ply" }, { "uri": "line.ply" }, { "uri": "quad.ply" }],
        "instances": [{ "shape": 0, "material": 0 }, { "shape": 1, "material": 0 },
                      { "shape": 2, "material": 0 }]
    }"#;
    let path = folder.join("three.json");
    fs::write(&path, json).expect("a scene file");
    path.to_string_lossy().into_owned()
}

#[test]
fn every_combination_of_kinds_renders_and_changes_what_it_names_and_nothing_else() {
    let scene_folder = tempfile::tempdir().expect("a temporary folder");
    let scene = three_kinds(scene_folder.path());
    for kinds in [
        "points",
        "lines",
        "quads",
        "points,lines",
        "points,quads",
        "lines,quads",
        "points,lines,quads",
    ] {
        let (folder, metrics) = compare(&scene, &["--kinds", kinds, "--bounces", "2"]);
        let named = metrics["kinds"].as_array().expect("a list").iter();
        let named: Vec<_> = named.map(|kind| kind.as_str().expect("a name")).collect();
        assert_eq!(named.join(","), kinds);

        let [vanilla, enhanced] =
            ["vanilla.exr", "enhanced.exr"].map(|name| values(&folder.path().join(name)));
        // The channels of a pixel are far apart in a file, but all rows have the same length.
        for (third, kind) in ["points", "lines", "quads"].into_iter().enumerate() {
            let in_third = |i: &usize| i % 96 / 32 == third;
            let pairs = (0..vanilla.len()).filter(in_third);
            let changed = pairs.filter(|&i| (vanilla[i] - enhanced[i]).abs() > 1e-3).count();
            assert_eq!(changed > 50, kinds.contains(kind), "{kinds}: {changed} in that of {kind}");
            assert!(changed > 50 || changed == 0, "{kinds}: {changed} in that of {kind}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_one_and_two_threads() {
    let runs = ["1", "2"].map(|threads| {
        let (folder, metrics) = compare("glass", &["--threads", threads]);
        let images = ["vanilla.exr", "enhanced.exr"].map(|name| bits(&folder.path().join(name)));
        (images, metrics["enhanced"]["rays"].clone())
    });
    assert_eq!(runs[0], runs[1]);
    let (other, _) = compare("glass", &["--seed", "1"]);
    assert_ne!(
        runs[0].0[0],
        bits(&other.path().join("vanilla.exr")),
        "another seed is another picture"
    );
}

#[test]
fn render_makes_the_pictures_that_compare_makes() {
    let (folder, _) = compare("patches", &[]);
    for mode in ["vanilla", "enhanced"] {
        let path = folder.path().join("alone.exr");
        let out = path.to_string_lossy().into_owned();
        let options = ["--out", &out, "--mode", mode, "--resolution", "96", "--samples", "2"];
        xtask(&[&["render", "patches"], &options[..]].concat());
        assert_eq!(bits(&path), bits(&folder.path().join(format!("{mode}.exr"))), "{mode}");
    }
}

#[test]
fn every_bundled_scene_renders_without_a_rejected_sample() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut count = 0;
    for entry in fs::read_dir(scenes).expect("the folder of scenes") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "json") {
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let (_folder, metrics) = compare(&name, &["--samples", "1"]);
            assert_eq!(metrics["enhanced"]["rejected_samples"], 0, "{name}");
            count += 1;
        }
    }
    assert!(count >= 4, "{count} scenes");
}

#[test]
fn several_scenes_share_a_page() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().to_string_lossy().into_owned();
    let small = ["--out", &out, "--resolution", "48", "--samples", "1"];
    xtask(&[&["compare", "shapes1", "patches"], &small[..]].concat());
    let page = fs::read_to_string(folder.path().join("index.html")).expect("an index");
    for scene in ["shapes1", "patches"] {
        assert!(page.contains(&format!("href=\"{scene}/report.html\"")), "{scene}");
        assert!(folder.path().join(scene).join("report.html").is_file(), "{scene}");
    }
}

/// Another seed makes a FLIP error of 0.065 at this size: all limits are below the noise. Measured
/// were 0.033 far away, where the thinnest lines move by several of their radii, 0.0016 and 0.0013.
#[test]
fn a_picture_is_the_same_far_from_the_origin_tiny_and_huge() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().to_string_lossy().into_owned();
    let small = ["--camera", "front", "--out", &out, "--resolution", "240", "--samples", "8"];
    xtask(&[&["moved", "shapes4"], &small[..]].concat());
    let metrics = metrics(folder.path());
    for (name, flip, light) in [
        // At 10 km frames are multiples of a millimeter: a sixth of a pixel here.
        ("offset-10000", 0.045, 0.004),
        ("scale-0.001", 0.004, 0.001),
        ("scale-1000", 0.004, 0.001),
    ] {
        let value = |key: &str| metrics[name][key].as_f64().expect("a number");
        assert!(value("flip_mean") < flip, "{name}: FLIP {}", value("flip_mean"));
        assert!((value("luminance_ratio") - 1.0).abs() < light, "{name}: light");
        assert_eq!(metrics[name]["invalid_pixels"], 0, "{name}");
    }
    let noise = metrics["another-seed"]["flip_mean"].as_f64().expect("a number");
    assert!(noise > 0.045, "the pictures of two seeds differ by noise: {noise}");
}
