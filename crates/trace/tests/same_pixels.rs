//! Pictures depend on scene, options and seed alone.

mod support;

use glam::Vec3;
use rotund_scene::{Material, MaterialKind, Scene, Shape, Trees};
use rotund_trace::output::{load_film, save_film, write_layers};
use rotund_trace::{
    Film, FilmError, Image, Layers, Lights, MergeError, Options, Origin, Progress, RenderError,
    Shard, View, World,
};
use std::error::Error as _;
use std::ops::ControlFlow;

const OPTIONS: Options = Options {
    view: View::Path,
    clamp: None,
    width: 48,
    height: 32,
    samples: 8,
    bounces: 8,
    seed: 5,
    sequence: rotund_trace::Sequence::Sobol,
    shard: Shard { index: 0, count: 1 },
    transparent: false,
    recenter: true,
};

fn picture(scene: &Scene, options: &Options, threads: usize) -> Film {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| World::new(scene).expect("a valid scene").render(0, options))
        .expect("a picture")
}

#[test]
fn one_thread_and_two_make_the_same_bits() {
    let scene = support::glass_over_a_floor();
    let one = picture(&scene, &OPTIONS, 1);
    assert_eq!(one, picture(&scene, &OPTIONS, 2));
    assert_eq!(one.samples(), OPTIONS.samples);
    assert_eq!(one.rejected(), 0);
}

#[test]
fn another_seed_is_another_picture() {
    let scene = support::glass_over_a_floor();
    let other = Options { seed: 6, ..OPTIONS };
    assert_ne!(picture(&scene, &OPTIONS, 2), picture(&scene, &other, 2));
}

/// Renders until `progress` has been called this often.
fn begun(world: &World<'_>, options: &Options, mut calls: u32) -> Film {
    let film = world.render_with(0, options, &mut |_| {
        calls -= 1;
        if calls == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    film.expect("a picture")
}

/// A picture of several batches, so that it can be interrupted in the middle of a pass.
const LARGER: Options = Options { width: 160, height: 120, samples: 3, bounces: 3, ..OPTIONS };

#[test]
fn a_picture_that_was_interrupted_and_resumed_is_the_same() {
    let scene = support::glass_over_a_floor();
    let world = World::new(&scene).expect("a valid scene");
    let film = begun(&world, &LARGER, 2);
    assert!(film.samples() < LARGER.samples, "it was not interrupted");
    // By way of a file, as another process would.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("half.film");
    save_film(&path, &film).expect("it is saved");
    let mut film = load_film(&path).expect("it is loaded");
    let go_on = &mut |_: &Progress<'_>| ControlFlow::Continue(());
    world.resume(&mut film, 0, &LARGER, go_on).expect("it is resumed");
    assert_eq!(film, picture(&scene, &LARGER, 2));
}

#[test]
fn an_interruption_after_every_batch_loses_nothing() {
    let scene = support::glass_over_a_floor();
    let world = World::new(&scene).expect("a valid scene");
    let whole = picture(&scene, &LARGER, 2);
    for every in [1, 2, 3] {
        let mut film = begun(&world, &LARGER, 1);
        let (mut runs, mut uneven) = (1, 0);
        while film.samples() < LARGER.samples {
            let first = film.samples_at(0, 0).expect("a pixel");
            uneven += u32::from(first > film.samples());
            // The image is right where a pass was interrupted: pixels are means of their own
            // samples.
            let image = film.image();
            let done = film.samples() > 0;
            assert!(image.pixels.iter().all(|p| p[3] == 1.0 || !done && p[3] == 0.0));
            let mut calls = 0;
            let mut stop = |_: &Progress<'_>| {
                calls += 1;
                if calls == every { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            world.resume(&mut film, 0, &LARGER, &mut stop).expect("it is resumed");
            runs += 1;
        }
        // The first batch after a start has 4096 pixels, fewer than the picture. Later ones are
        // longer the faster the machine is, so they may end with a pass.
        assert!(every > 1 || uneven > 0, "no interruption of {runs} fell within a pass");
        assert_eq!(film, whole, "interrupted at every {every}-th report");
    }
}

#[test]
fn progress_counts_samples_and_rays() {
    let scene = support::glass_over_a_floor();
    let mut last = (0, 0);
    let all = u64::from(OPTIONS.width * OPTIONS.height * OPTIONS.samples);
    let film =
        World::new(&scene).expect("a valid scene").render_with(0, &OPTIONS, &mut |progress| {
            let now = (progress.samples, progress.rays);
            assert!(now.0 > last.0 && now.1 > last.1, "{now:?} after {last:?}");
            assert_eq!(progress.total, all);
            assert_eq!(progress.fraction(), now.0 as f64 / all as f64);
            last = now;
            ControlFlow::Continue(())
        });
    assert_eq!(film.expect("a picture").samples(), OPTIONS.samples);
    assert_eq!(last.0, all);
    assert!(last.1 >= all, "each path has a camera ray");
}

#[test]
fn lights_of_shapes_with_other_elements_are_refused() {
    // Three glowing balls, of which one goes out.
    let balls = |count: usize| {
        let mut scene = support::glass_over_a_floor();
        let glow = Material { emission: Vec3::ONE, ..Material::default() };
        let centers: Vec<_> = (0..count).map(|i| Vec3::splat(i as f32)).collect();
        let last = scene.add(Shape::points(centers, 0.1), glow);
        scene.instances[last as usize].name = "lamps".into();
        scene
    };
    let (before, now) = (balls(3), balls(2));
    let lights = Lights::build(&before).expect("a valid scene");
    let trees = Trees::build(&now).expect("a valid scene");
    let error = World::from_parts(&now, &trees, &lights).expect_err("other lights").to_string();
    assert_eq!(
        error,
        format!(
            "instances[{}] \"lamps\": has 2 elements, but the lights were built from 3: \
             build new lights",
            now.instances.len() - 1
        )
    );
    // Smooth glass has tables too.
    let mut more = before.clone();
    more.shapes[0] = Shape::points(vec![Vec3::ZERO; 7], 0.1);
    let trees = Trees::build(&more).expect("a valid scene");
    let error = World::from_parts(&more, &trees, &lights).expect_err("other lights").to_string();
    assert!(error.contains("has 7 elements, but the lights were built from 1"), "{error}");
    // Elements that neither emit nor pass light on have none, so they may change.
    more.materials[0].kind = MaterialKind::Matte;
    let lights = Lights::build(&Scene { shapes: before.shapes, ..more.clone() });
    let lights = lights.expect("a valid scene");
    let trees = Trees::build(&more).expect("a valid scene");
    World::from_parts(&more, &trees, &lights).expect("the same lights");
}

#[test]
fn a_size_that_does_not_fit_into_memory_is_an_error() {
    let scene = support::glass_over_a_floor();
    let world = World::new(&scene).expect("a valid scene");
    let huge = Options { width: u32::MAX, height: u32::MAX, ..OPTIONS };
    let expected = FilmError::TooLarge { width: u32::MAX, height: u32::MAX };
    assert_eq!(world.render(0, &huge), Err(expected.clone().into()));
    assert_eq!(world.layers(0, &huge).map(drop), Err(expected.into()));
}

#[test]
fn trees_and_lights_of_another_scene_are_refused() {
    let scene = support::glass_over_a_floor();
    let trees = Trees::build(&scene).expect("a valid scene");
    let lights = Lights::build(&scene).expect("a valid scene");
    let world = World::from_parts(&scene, &trees, &lights).expect("they fit");
    assert_eq!(world.render(0, &OPTIONS), Ok(picture(&scene, &OPTIONS, 2)));
    let mut other = scene.clone();
    other.instances.pop();
    let error = World::from_parts(&other, &trees, &lights).expect_err("other trees").to_string();
    assert!(error.starts_with("the scene has 4 instances, but the trees "), "{error}");
    let trees = Trees::build(&other).expect("a valid scene");
    let error = World::from_parts(&other, &trees, &lights).expect_err("other lights").to_string();
    assert!(error.starts_with("the scene has 4 instances, but the lights "), "{error}");
    other.materials[0].ior = f32::NAN;
    let error = World::new(&other).expect_err("no index of refraction").to_string();
    assert!(error.contains("materials[0]") && error.contains("ior"), "{error}");
}

#[test]
fn what_cannot_be_rendered_is_refused_and_the_culprit_is_named() {
    let scene = support::glass_over_a_floor();
    let world = World::new(&scene).expect("a valid scene");
    let table = [
        (1, OPTIONS, "there is no camera 1: the scene has 1, counted from 0"),
        (0, Options { width: 0, ..OPTIONS }, "option `width` is 0; it must be at least 1"),
        (0, Options { height: 0, ..OPTIONS }, "option `height` is 0; it must be at least 1"),
        (0, Options { samples: 0, ..OPTIONS }, "option `samples` is 0; it must be at least 1"),
        (0, Options { bounces: 0, ..OPTIONS }, "option `bounces` is 0; it must be at least 1"),
        (0, Options { shard: Shard { index: 2, count: 2 }, ..OPTIONS }, "there is no shard 3/2"),
        (
            0,
            Options { clamp: Some(f32::NAN), ..OPTIONS },
            "option `clamp` is NaN; it must be a positive number",
        ),
        (
            0,
            Options { width: u32::MAX, height: u32::MAX, ..OPTIONS },
            "a film of 4294967295 x 4294967295 does not fit into memory: it takes 56 bytes a pixel",
        ),
    ];
    for (camera, options, message) in table {
        let error = world.render(camera, &options).expect_err(message);
        assert_eq!(error.to_string(), message);
        if !matches!(error, RenderError::Film(_)) {
            let error = world.layers(camera, &options).expect_err(message);
            assert_eq!(error.to_string(), message);
        }
    }
    let mut film = Film::for_options(&OPTIONS).expect("a film");
    let empty = film.clone();
    for (options, message) in [
        (Options { width: 49, ..OPTIONS }, "width is 48, that of the options 49"),
        (Options { height: 31, ..OPTIONS }, "height is 32, that of the options 31"),
        (Options { seed: 6, ..OPTIONS }, "seed is 5, that of the options 6"),
        (
            Options { shard: Shard { index: 1, count: 2 }, ..OPTIONS },
            "shard is 1/1, that of the options 2/2",
        ),
    ] {
        let go_on = &mut |_: &Progress<'_>| ControlFlow::Continue(());
        let error = world.resume(&mut film, 0, &options, go_on).expect_err(message);
        assert_eq!(error.to_string(), format!("cannot resume the film: its {message}"));
        assert_eq!(film, empty);
    }
}

#[test]
fn shards_make_the_same_picture_together() {
    let scene = support::glass_over_a_floor();
    let shard = |index| {
        let options = Options { shard: Shard { index, count: 3 }, ..OPTIONS };
        picture(&scene, &options, 2)
    };
    let parts = [shard(2), shard(0), shard(1)];
    assert_eq!(parts.each_ref().map(Film::samples), [2, 3, 3]);
    assert_eq!(Film::merge(&parts), Ok(picture(&scene, &OPTIONS, 2)));

    let [a, b, c] = parts;
    let twice = Film::merge(&[a.clone(), b.clone(), b.clone()]);
    assert_eq!(twice, Err(MergeError::Twice { index: 0, count: 3, times: 2 }));
    let missing = Film::merge(&[a.clone(), b.clone()]);
    assert_eq!(missing, Err(MergeError::Missing { index: 1, count: 3, missing: 1 }));
    // The film that is not like most others is named, wherever it stands.
    let odd = a.clone().with_seed(9);
    assert_eq!(
        Film::merge(&[odd, b.clone(), c.clone()]),
        Err(MergeError::Different { number: 1, usual: 2 })
    );
    let version = Origin { program: "another".into(), ..Origin::default() };
    assert_eq!(
        Film::merge(&[a.clone(), b.clone(), c.clone().with_origin(version)]),
        Err(MergeError::Different { number: 3, usual: 1 })
    );
    let world = World::new(&scene).expect("a valid scene");
    let options = Options { shard: Shard { index: 2, count: 3 }, ..LARGER };
    let half = begun(&world, &options, 1);
    assert!(!half.header().is_finished(), "it was interrupted");
    let whole = |index| picture(&scene, &Options { shard: Shard { index, count: 3 }, ..LARGER }, 2);
    let unfinished = Film::merge(&[whole(0), half, whole(1)]);
    assert_eq!(unfinished, Err(MergeError::Unfinished { numbers: vec![2] }));
    assert_eq!(Film::merge(&[]), Err(MergeError::Nothing));
}

#[test]
fn merges_nest_and_take_more_samples_when_they_are_whole() {
    let scene = support::glass_over_a_floor();
    let shard = |index| {
        let options = Options { shard: Shard { index, count: 4 }, ..OPTIONS };
        picture(&scene, &options, 2)
    };
    let pair = |a: u32, b: u32| {
        let mut film = shard(a);
        film.absorb(&shard(b)).expect("shards of one picture");
        film
    };
    let (mut some, rest) = (pair(3, 1), pair(0, 2));
    assert_eq!(some.header().shards.to_string(), "shards 2 and 4 of 4");
    assert_eq!(some.absorb(&shard(1)), Err(MergeError::Twice { index: 1, count: 4, times: 2 }));
    assert_eq!(some.add(0, 0, Vec3::ONE, true), Err(FilmError::Merged));
    some.absorb(&rest).expect("the other shards");
    assert_eq!(some, picture(&scene, &OPTIONS, 2));
    let more = Options { samples: 12, ..OPTIONS };
    let world = World::new(&scene).expect("a valid scene");
    let go_on = &mut |_: &Progress<'_>| ControlFlow::Continue(());
    world.resume(&mut some, 0, &more, go_on).expect("it is resumed");
    assert_eq!(some, picture(&scene, &more, 2));
}

#[test]
fn a_damaged_checkpoint_is_refused() {
    let scene = support::glass_over_a_floor();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.film");
    save_film(&path, &picture(&scene, &OPTIONS, 2)).expect("it is saved");
    let good = std::fs::read(&path).expect("it is there");
    let flipped: Vec<u8> =
        good.iter().enumerate().map(|(i, &byte)| if i == 9000 { byte ^ 4 } else { byte }).collect();
    let older = [b"rotund film 003\n", &good[16..]].concat();
    let table: [(&str, &[u8], &str); 5] = [
        ("cut short", &good[..good.len() - 60], "damaged"),
        ("a bit flipped", &flipped, "damaged"),
        ("of the version before", &older, "of another version of the format: render it again"),
        ("empty", &[], "not a checkpoint"),
        ("something else", b"P6 640 480 255 and so on and so on", "not a checkpoint"),
    ];
    for (why, bytes, expected) in table {
        std::fs::write(&path, bytes).expect("it is written");
        let message = load_film(&path).expect_err(why).to_string();
        assert!(message.contains(expected) && message.contains("a.film"), "{why}: {message}");
    }
}

/// Pictures are compared by the bytes of their files. Large ones are packed by several threads.
#[test]
fn a_picture_written_again_has_the_same_bytes() {
    let scene = support::glass_over_a_floor();
    let options = Options { width: 300, height: 200, samples: 1, ..OPTIONS };
    let layers = World::new(&scene).expect("a valid scene").layers(0, &options).expect("layers");
    // Tiles of very unequal work.
    let value = |i: u32| if i % 300 < 150 { 0.25 } else { (i as f32 * 0.7).sin().exp() };
    let pixels = (0..300 * 200).map(|i| [value(i), value(i + 1), value(i + 2), 1.0]).collect();
    let image = Image { width: 300, height: 200, pixels };
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["plain.exr", "plain.hdr", "plain.png", "layers.exr"] {
        let path = folder.path().join(name);
        let bytes = || {
            match name {
                "layers.exr" => write_layers(&path, &image, &layers),
                _ => image.write(&path),
            }
            .expect("a file");
            std::fs::read(&path).expect("the file")
        };
        let first = bytes();
        for _ in 0..20 {
            assert!(bytes() == first, "{name} is another file");
        }
    }
}

#[test]
fn layers_of_another_size_are_an_error_and_no_file() {
    let scene = support::glass_over_a_floor();
    let world = World::new(&scene).expect("a valid scene");
    let layers = world.layers(0, &OPTIONS).expect("layers");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("layers.exr");
    let refused = |image: &Image, layers: &Layers| {
        let error = write_layers(&path, image, layers).expect_err("they do not fit");
        assert!(!path.exists());
        error.source().expect("a cause").to_string()
    };
    assert_eq!(
        refused(&Image::new(32, 48), &layers),
        "layers of 48 x 32 do not fit a picture of 32 x 48"
    );
    let image = Image::new(48, 32);
    let mut short = layers.clone();
    short.depth.pop();
    assert_eq!(refused(&image, &short), "a layer `depth` of 48 x 32 holds 1535 pixels");
    let short = Image { pixels: image.pixels[1..].to_vec(), ..image.clone() };
    assert_eq!(refused(&short, &layers), "a picture of 48 x 32 holds 1535 pixels");
    write_layers(&path, &image, &layers).expect("they fit");
}
