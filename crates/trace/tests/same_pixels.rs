//! Pictures depend on scene, options and seed alone.

mod support;

use rotund_scene::{Scene, Trees};
use rotund_trace::output::{load_film, save_film, write_layers};
use rotund_trace::{
    Film, Image, Lights, MergeError, Options, Progress, Shard, View, layers, render, resume,
};
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
};

fn picture(scene: &Scene, options: &Options, threads: usize) -> Film {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let (trees, lights) = (Trees::build(scene).expect("the scene is valid"), Lights::build(scene));
    pool.install(|| {
        render(
            scene,
            &trees,
            &lights,
            0,
            options,
            &mut |_: &Progress<'_>| ControlFlow::Continue(()),
        )
    })
}

#[test]
fn one_thread_and_two_make_the_same_bits() {
    let scene = support::glass_over_a_floor();
    let one = picture(&scene, &OPTIONS, 1);
    assert_eq!(one, picture(&scene, &OPTIONS, 2));
    assert_eq!(one.samples, OPTIONS.samples);
    assert_eq!(one.rejected, 0);
}

#[test]
fn another_seed_is_another_picture() {
    let scene = support::glass_over_a_floor();
    let other = Options { seed: 6, ..OPTIONS };
    assert_ne!(picture(&scene, &OPTIONS, 2), picture(&scene, &other, 2));
}

#[test]
fn a_picture_that_was_interrupted_and_resumed_is_the_same() {
    let scene = support::glass_over_a_floor();
    let (trees, lights) =
        (Trees::build(&scene).expect("the scene is valid"), Lights::build(&scene));
    let film = render(&scene, &trees, &lights, 0, &OPTIONS, &mut |progress: &Progress<'_>| {
        if progress.film.samples >= 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(film.samples < OPTIONS.samples, "it was not interrupted");
    // By way of a file, as another process would.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("half.film");
    save_film(&path, &film).expect("it is saved");
    let mut film = load_film(&path).expect("it is loaded");
    let go_on = &mut |_: &Progress<'_>| ControlFlow::Continue(());
    resume(&mut film, &scene, &trees, &lights, 0, &OPTIONS, go_on);
    assert_eq!(film, picture(&scene, &OPTIONS, 2));
}

#[test]
fn progress_counts_samples_and_rays() {
    let scene = support::glass_over_a_floor();
    let (trees, lights) =
        (Trees::build(&scene).expect("the scene is valid"), Lights::build(&scene));
    let mut last = (0, 0);
    render(&scene, &trees, &lights, 0, &OPTIONS, &mut |progress: &Progress<'_>| {
        let now = (progress.film.samples, progress.rays);
        assert!(now.0 > last.0 && now.1 > last.1, "{now:?} after {last:?}");
        last = now;
        ControlFlow::Continue(())
    });
    assert_eq!(last.0, OPTIONS.samples);
    let paths = u64::from(OPTIONS.width * OPTIONS.height * OPTIONS.samples);
    assert!(last.1 >= paths, "each path has a camera ray");
}

#[test]
fn shards_make_the_same_picture_together() {
    let scene = support::glass_over_a_floor();
    let shard = |index| {
        let options = Options { shard: Shard { index, count: 3 }, ..OPTIONS };
        picture(&scene, &options, 2)
    };
    let parts = [shard(2), shard(0), shard(1)];
    assert_eq!(parts.each_ref().map(|film| film.samples), [2, 3, 3]);
    assert_eq!(Film::merge(&parts), Ok(picture(&scene, &OPTIONS, 2)));

    let [a, b, c] = parts;
    let twice = Film::merge(&[a.clone(), b.clone(), b.clone()]);
    assert_eq!(twice, Err(MergeError::Shards { index: 0, count: 3, times: 2 }));
    let missing = Film::merge(&[a.clone(), b.clone()]);
    assert_eq!(missing, Err(MergeError::Shards { index: 1, count: 3, times: 0 }));
    let mut other = c;
    other.seed = 9;
    assert_eq!(Film::merge(&[a, b, other]), Err(MergeError::Different { number: 3 }));
    assert_eq!(Film::merge(&[]), Err(MergeError::Nothing));
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
    let table: [(&str, &[u8], &str); 4] = [
        ("cut short", &good[..good.len() - 60], "damaged"),
        ("a bit flipped", &flipped, "damaged"),
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
    let trees = Trees::build(&scene).expect("the scene is valid");
    let layers = layers(&scene, &trees, 0, &options);
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
