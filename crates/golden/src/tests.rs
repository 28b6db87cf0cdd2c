//! Planted faults must be found by the check that is meant for them, and correct renders must pass.

use crate::case::{Case, of_folder};
use crate::check::{Check, Finding};
use crate::moments::Moments;
use crate::reference::Reference;
use crate::significance::{compare, level, p_value};
use crate::subject::{Plan, Subject};
use crate::verdict::{Verdict, judge};
use crate::{REPLICAS, Suite};
use glam::{DVec3, Vec2};
use rotund_bvh::Isa;
use rotund_scene::Scene;
use rotund_trace::Sequence;
use std::path::{Path, PathBuf};

mod surface;

/// The golden pictures of the workspace.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden")
}

fn case(name: &str) -> Case {
    let cases = of_folder(&folder()).unwrap();
    cases.into_iter().find(|case| case.name == name).expect("a picture of that name")
}

fn reference(name: &str) -> Reference {
    Reference::read(&case(name).reference).unwrap()
}

/// Renders a picture of a modified scene.
fn render(name: &str, sequence: Sequence, tamper: impl FnOnce(&mut Scene)) -> Moments {
    let mut scene = case(name).load().unwrap();
    tamper(&mut scene);
    let Reference { moments, samples, bounces, .. } = reference(name);
    let (width, height) = (moments.width as u32, moments.height as u32);
    let plan = Plan { width, height, bounces, samples, sequence };
    let subject = Subject::new(name, scene, Isa::default_set()).unwrap();
    subject.measure(&plan, REPLICAS, 77).unwrap()
}

fn verdict(name: &str, actual: &Moments) -> Verdict {
    judge(actual, &reference(name).moments, 24).unwrap()
}

/// Renders a scene with a planted fault.
fn faulty(name: &str, plant: impl FnOnce(&mut Scene)) -> Verdict {
    verdict(name, &render(name, Sequence::Sobol, plant))
}

fn honest(name: &str) -> Moments {
    render(name, Sequence::Sobol, |_| {})
}

#[track_caller]
fn assert_caught(verdict: &Verdict, check: Check, word: &str) {
    let named = |finding: &Finding| finding.check == check && finding.text.contains(word);
    assert!(verdict.findings.iter().any(named), "no {check} in {:?}", verdict.findings);
}

#[test]
fn other_random_numbers_pass() {
    for name in ["triangles", "points-enhanced"] {
        let verdict = verdict(name, &honest(name));
        assert!(verdict.findings.is_empty(), "{name}: {:?}", verdict.findings);
    }
}

#[test]
fn another_sampler_passes() {
    let actual = render("points-vanilla", Sequence::Independent, |_| {});
    let verdict = verdict("points-vanilla", &actual);
    assert!(verdict.findings.is_empty(), "{:?}", verdict.findings);
}

#[test]
fn a_leak_of_one_pixel_is_caught() {
    let honest = honest("points-enhanced");
    let (x, y) = (48, 48);
    let inside = y * honest.width + x;
    let background = honest.mean[honest.width / 2];
    for (why, leaked) in [("black", DVec3::ZERO), ("the sky behind", background)] {
        let mut actual = honest.clone();
        actual.mean[inside] = leaked;
        actual.variance[inside] = DVec3::ZERO;
        let verdict = verdict("points-enhanced", &actual);
        assert_caught(&verdict, Check::Pixel, "pixel (48, 48)");
        assert_eq!(verdict.findings.len(), 1, "{why}: {:?}", verdict.findings);
    }
}

#[test]
fn a_black_pixel_is_caught_in_most_places_of_any_picture() {
    let (mut shares, mut too_noisy) = (Vec::new(), Vec::<String>::new());
    for case in of_folder(&folder()).unwrap() {
        let reference = Reference::read(&case.reference).unwrap().moments;
        let zeros = vec![DVec3::ZERO; reference.mean.len()];
        let black = Moments {
            replicas: REPLICAS,
            mean: zeros.clone(),
            variance: zeros,
            ..reference.clone()
        };
        let caught = |&i: &usize| {
            (0..3).any(|channel| {
                let found = compare(&black, &reference, [i].into_iter(), channel);
                p_value(found.t, found.freedom) < level(3 * reference.mean.len() * 24)
            })
        };
        // Pixels that are black in the reference cannot reveal a black pixel.
        let lit = |&i: &usize| reference.mean[i].max_element() > 0.0;
        let lit: Vec<usize> = (0..reference.mean.len()).filter(lit).collect();
        let share = lit.iter().copied().filter(caught).count() as f64 / lit.len() as f64;
        // The other pixels are too noisy: behind glass, in penumbras, and most of all where the
        // only light comes from small emitters that paths hit by chance.
        let least = match case.name.as_str() {
            "lights-vanilla" | "lights-enhanced" => 0.5,
            // Glass, or the light of small emitters, in most of the picture.
            "dielectrics" | "fresnel" | "glow-vanilla" => 0.7,
            _ => 0.8,
        };
        if share <= least {
            too_noisy.push(format!("{}: {share:.3} of all pixels", case.name));
        }
        shares.push(share);
    }
    assert!(too_noisy.is_empty(), "{too_noisy:?}");
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    assert!(mean > 0.9, "{mean:.3} of all pixels of all pictures");
}

#[test]
fn a_flipped_normal_is_caught() {
    let flipped = faulty("quads-enhanced", |scene| {
        let saddle = scene.shapes.iter_mut().find(|shape| !shape.normals.is_empty()).unwrap();
        // Vertices are 4 x 4: this one has quads all around. At the rim, the bound on shading
        // normals corrects so much that the light hardly changes; the check of surfaces finds that.
        let [row, column] = [1, 1];
        let inner = 4 * row + column;
        saddle.normals[inner] = -saddle.normals[inner];
    });
    assert_caught(&flipped, Check::Block, "block");
}

#[test]
fn a_surface_turned_inside_out_is_caught() {
    let turned = faulty("triangles", |scene| {
        let shape = scene.shapes.iter_mut().find(|shape| shape.name == "tetrahedron").unwrap();
        let rotund_scene::Elements::Triangles(triangles) = &mut shape.elements else {
            panic!("a tetrahedron is made of triangles")
        };
        triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    });
    assert_caught(&turned, Check::Block, "block");
}

#[test]
fn a_texture_shifted_by_one_texel_is_caught() {
    for name in ["triangles", "quads-vanilla"] {
        let shifted = faulty(name, |scene| {
            for shape in &mut scene.shapes {
                let one_texel = Vec2::new(1.0 / 16.0, 0.0);
                shape.texcoords.iter_mut().for_each(|texcoord| *texcoord += one_texel);
            }
        });
        assert_caught(&shifted, Check::Block, "block");
    }
}

#[test]
fn a_loss_of_one_percent_of_the_light_is_caught() {
    for name in ["points-enhanced", "triangles", "lights-vanilla"] {
        let mut dim = honest(name);
        dim.mean.iter_mut().for_each(|pixel| *pixel *= 0.99);
        assert_caught(&verdict(name, &dim), Check::Energy, "whole picture");
    }
}

#[test]
fn surfaces_that_lose_one_percent_of_the_light_are_caught() {
    // The emitters lose nothing and fill a part of the picture, but indirect light loses more.
    let darker = faulty("lights-enhanced", |scene| {
        scene.materials.iter_mut().for_each(|material| material.color *= 0.98);
    });
    assert_caught(&darker, Check::Energy, "whole picture");
}

#[test]
fn a_rejected_sample_is_caught() {
    let mut actual = honest("triangles");
    actual.rejected = 1;
    assert_caught(&verdict("triangles", &actual), Check::Rejected, "1 samples");
}

#[test]
fn a_tint_that_people_see_is_caught_by_flip() {
    let mut actual = honest("triangles");
    actual.mean.iter_mut().for_each(|pixel| *pixel *= DVec3::new(1.1, 1.0, 0.9));
    assert_caught(&verdict("triangles", &actual), Check::Flip, "FLIP");
}

#[test]
fn two_scenes_of_one_name_are_refused() {
    let mut suite = Suite::new("goldens");
    suite.add_file("a/x.json").unwrap();
    let error = suite.add_file("b/x.json").unwrap_err().to_string();
    assert!(error.contains("a/x.json") && error.contains("b/x.json"), "{error}");
}
