//! What a picture shows where there is nothing.

use rotund_image::Image;

const TRIANGLE: &str = "v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Renders a triangle by itself and returns the picture.
fn picture(options: &[&str]) -> Image {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let shape = folder.path().join("triangle.obj");
    std::fs::write(&shape, TRIANGLE).expect("writes the file");
    let out = folder.path().join("out.png");
    let [shape, out] = [&shape, &out].map(|path| path.to_str().expect("UTF-8"));
    let fixed = ["rotund", "render", shape, "--out", out, "--samples", "4", "--resolution", "60"];
    rotund::run(fixed.iter().chain(options)).expect("renders");
    Image::read(out).expect("a picture")
}

#[test]
fn a_background_replaces_the_sky_and_the_floor_of_a_lone_file() {
    let colored = picture(&["--background", "#ff8000"]);
    let corners = [(0, 0), (59, 0), (0, 39), (59, 39)];
    let bytes = colored.srgb_bytes();
    for (x, y) in corners {
        assert_eq!(bytes[y * 60 + x], [255, 128, 0, 255], "{x}, {y}");
    }
    let transparent = picture(&["--transparent"]);
    for (x, y) in corners {
        assert_eq!(transparent.srgb_bytes()[y * 60 + x][3], 0, "{x}, {y}");
    }
    // The sky lights the triangle as before.
    let [r, g, b, a] = colored.pixel(30, 20);
    assert_eq!(transparent.pixel(30, 20), [r, g, b, a]);
    assert!(a == 1.0 && r.min(g).min(b) > 0.1, "{r} {g} {b}");
}

#[test]
fn the_floor_of_a_lone_file_stays_before_a_background_if_that_is_asked_for() {
    let below = |options: &[&str]| picture(options).srgb_bytes()[39 * 60 + 30];
    let floor = below(&[]);
    assert_eq!(floor[3], 255);
    assert_eq!(below(&["--transparent"])[3], 0);
    assert_eq!(below(&["--transparent", "--floor"]), floor);
    assert_eq!(below(&["--background", "white", "--floor"]), floor);
}

#[test]
fn a_background_is_a_colour_and_not_transparent_at_once() {
    for options in [&["--background", "mauve"][..], &["--background", "white", "--transparent"]] {
        let fixed = ["rotund", "render", "shapes1", "--out", "unwritten.png"];
        let error = rotund::run(fixed.iter().chain(options)).expect_err("refused").to_string();
        assert!(error.contains("--background"), "{error}");
    }
}
