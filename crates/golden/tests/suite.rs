//! A suite as a user's own test sees it.

use rotund_golden::{Blessed, GoldenError, Settings, Suite};
use rotund_scene::{Camera, Environment, Material, Scene, Shape};
use std::path::Path;

/// Returns a ball under a sky of this brightness.
fn ball(sky: f32) -> Scene {
    let mut scene = Scene::default();
    let grey = Material { color: [0.5; 3].into(), ..Material::default() };
    scene.add(Shape::points([[0.0; 3].into()], [1.0]), grey);
    let camera = Camera::look_at([0.0, 1.0, 5.0].into(), [0.0; 3].into(), [0.0, 1.0, 0.0].into());
    scene.cameras.push(camera);
    scene.environments.push(Environment { emission: [sky; 3].into(), ..Environment::default() });
    scene
}

fn suite(folder: &Path, scenes: &[(&str, Scene)]) -> Suite {
    let mut suite = Suite::new(folder.join("golden"));
    suite.resolution = 24;
    for (name, scene) in scenes {
        suite.add(name, scene.clone()).unwrap();
    }
    suite
}

fn words(result: Result<(), GoldenError>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn a_picture_is_accepted_then_passes_and_a_change_fails_with_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let two = [("a", ball(1.0)), ("b", ball(0.5))];

    let missing = words(suite(folder, &two).check());
    assert!(missing.contains("a: there is no reference") && missing.contains("a.exr"), "{missing}");
    assert!(!folder.join("golden").exists(), "a check accepts nothing");

    let blessed = suite(folder, &two).bless().unwrap();
    assert!(matches!(&blessed[..], [(_, Blessed::New(_)), (_, Blessed::New(_))]), "{blessed:?}");
    suite(folder, &two).check().unwrap();

    // An unchanged picture keeps its file.
    let before = std::fs::read(folder.join("golden/a.exr")).unwrap();
    let again = suite(folder, &two).bless().unwrap();
    assert!(again.iter().all(|(_, it)| matches!(it, Blessed::Unchanged)), "{again:?}");
    assert_eq!(std::fs::read(folder.join("golden/a.exr")).unwrap(), before);

    // A loss of two percent of the light.
    let changed = suite(folder, &[("a", ball(0.98)), ("b", ball(0.5))]);
    let error = changed.check().unwrap_err();
    let text = format!("{error:?}");
    assert!(text.contains("1 of 2 differ") && text.contains("a: energy: "), "{text}");
    assert!(text.contains("failures.html") && text.contains("ROTUND_BLESS=1"), "{text}");
    let page = std::fs::read_to_string(folder.join("golden/failures.html")).unwrap();
    assert!(page.contains("<strong>energy</strong>") && !page.contains("http"));
    assert_eq!(page.matches("<img ").count(), page.matches("src=\"data:image/png;base64,").count());

    let accepted = changed.bless().unwrap();
    assert!(matches!(&accepted[0].1, Blessed::Changed(_, findings) if !findings.is_empty()));
    changed.check().unwrap();
}

#[test]
fn a_reference_without_a_picture_fails_and_other_images_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    suite(folder, &[("a", ball(1.0)), ("gone", ball(0.5))]).bless().unwrap();
    let picture = folder.join("golden/photo.exr");
    rotund_image::Image::new(4, 4).write(&picture).unwrap();
    let one = suite(folder, &[("a", ball(1.0))]);
    let text = words(one.check());
    assert!(text.contains("gone.exr is the reference of no picture"), "{text}");
    assert!(!text.contains("photo.exr"), "{text}");
    one.bless().unwrap();
    assert!(!folder.join("golden/gone.exr").exists() && picture.exists());
    one.check().unwrap();
}

#[test]
fn wrong_input_is_an_error_that_names_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut suite = suite(folder, &[("a", ball(1.0))]);
    let taken = suite.add("a", ball(1.0)).unwrap_err().to_string();
    assert!(taken.contains("a.exr"), "{taken}");
    for name in ["", "../a", "c:a"] {
        let error = suite.add(name, ball(1.0)).unwrap_err().to_string();
        assert!(error.contains(&format!("{name:?}")), "{error}");
    }
    suite.resolution = 0;
    for result in [suite.check(), suite.bless().map(drop)] {
        assert!(words(result).starts_with("the resolution of the suite is 0"));
    }
    suite.resolution = 24;
    let empty = words(Suite::new(folder.join("empty")).check());
    assert!(empty.contains("empty has no pictures"), "{empty}");

    // A scene that cannot be rendered is reported as such, whether it has a reference or not.
    let mut absent = Suite::new(folder.join("absent"));
    absent.add_file("no/such/scene.json").unwrap();
    for result in [absent.check(), absent.bless().map(drop)] {
        let missing = words(result);
        assert!(missing.contains("no/such/scene.json: cannot be read"), "{missing}");
    }

    let mut blind = Suite::new(folder.join("blind"));
    blind.add("no-eyes", Scene { cameras: Vec::new(), ..ball(1.0) }).unwrap();
    for error in [blind.bless().unwrap_err(), blind.check().unwrap_err()] {
        assert!(matches!(&error, GoldenError::NoCamera { name } if name == "no-eyes"), "{error}");
    }

    let mut dark = Suite::new(folder.join("dark"));
    dark.resolution = 16;
    dark.add("night", ball(0.0)).unwrap();
    let error = dark.bless().unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, GoldenError::Refused(_)) && text.contains("night: "), "{text}");
    assert!(text.contains("black"), "{text}");

    let mut broken = ball(1.0);
    broken.shapes[0].radii[0] = f32::NAN;
    let mut nan = Suite::new(folder.join("nan"));
    nan.add("broken", broken).unwrap();
    for error in [nan.bless().unwrap_err(), nan.check().unwrap_err()] {
        assert!(matches!(&error, GoldenError::Scene { name, .. } if name == "broken"), "{error}");
    }
}

#[test]
fn other_random_numbers_pass() {
    let folder = tempfile::tempdir().unwrap();
    let mut suite = suite(folder.path(), &[("a", ball(1.0))]);
    suite.bless().unwrap();
    for seed in 2..6 {
        suite.settings = Settings { seed, ..Settings::default() };
        suite.check().unwrap();
    }
}
