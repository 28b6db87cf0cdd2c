//! Pictures depend on scene, options and seed alone.

mod support;

use rotund_scene::{Scene, Trees};
use rotund_trace::{Film, Lights, Options, Progress, render, resume};
use std::ops::ControlFlow;

const OPTIONS: Options = Options {
    width: 48,
    height: 32,
    samples: 8,
    bounces: 8,
    seed: 5,
    sequence: rotund_trace::Sequence::Sobol,
};

fn picture(scene: &Scene, options: &Options, threads: usize) -> Film {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let (trees, lights) = (Trees::build(scene), Lights::build(scene));
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
    let (trees, lights) = (Trees::build(&scene), Lights::build(&scene));
    let mut film = render(&scene, &trees, &lights, 0, &OPTIONS, &mut |progress: &Progress<'_>| {
        if progress.film.samples >= 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(film.samples < OPTIONS.samples, "it was not interrupted");
    let go_on = &mut |_: &Progress<'_>| ControlFlow::Continue(());
    resume(&mut film, &scene, &trees, &lights, 0, &OPTIONS, go_on);
    assert_eq!(film, picture(&scene, &OPTIONS, 2));
}

#[test]
fn progress_counts_samples_and_rays() {
    let scene = support::glass_over_a_floor();
    let (trees, lights) = (Trees::build(&scene), Lights::build(&scene));
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
