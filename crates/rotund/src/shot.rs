//! One render: trees, lights, samples, and how long each took.

use crate::cancel::Cancel;
use crate::kinds::KindArgs;
use crate::progress::Meter;
use crate::scene_source::{LoadArgs, NamedScene, find_camera, load};
use anyhow::{Context, Result};
use rotund_scene::Scene;
use rotund_trace::{Film, Options, Sequence, World};
use std::ops::ControlFlow;
use std::time::Instant;

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum SamplerKind {
    /// Owen-scrambled Sobol points: noise falls faster.
    Sobol,
    /// Independent numbers, the textbook Monte Carlo.
    Independent,
}

fn parse_clamp(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(clamp) if clamp > 0.0 => Ok(clamp),
        _ => Err("a radiance is a number above zero".to_owned()),
    }
}

/// How to take a picture of a scene.
#[derive(Clone, Debug, clap::Args)]
pub struct ShotArgs {
    /// The camera to look through; the first of the scene if not given.
    #[arg(long)]
    pub camera: Option<String>,
    /// Samples per pixel.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub samples: u32,
    /// Pixels along the longer side.
    #[arg(long, default_value_t = 720, value_parser = clap::value_parser!(u32).range(1..=1 << 14))]
    pub resolution: u32,
    /// Segments of the longest path, counted from the camera.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1 << 16))]
    pub bounces: u32,
    /// Another seed is another picture of the same scene.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Where random numbers come from.
    #[arg(long, value_enum, default_value = "sobol")]
    sampler: SamplerKind,
    /// Scale samples down whose largest channel is above this: less noise, but light is lost.
    #[arg(long, value_name = "RADIANCE", value_parser = parse_clamp)]
    clamp: Option<f32>,
    /// Threads to render with; one for each processor if not given. The picture is the same.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 10))]
    pub threads: Option<u32>,
}

/// The options of a command that takes pictures of a scene.
#[derive(Clone, Debug, clap::Args)]
pub struct PictureArgs {
    #[command(flatten)]
    pub kinds: KindArgs,
    #[command(flatten)]
    pub shot: ShotArgs,
    #[command(flatten)]
    loading: LoadArgs,
}

impl PictureArgs {
    /// Loads the scene; with it the index of the camera, and the options of the render.
    pub fn load(&self, scene: &str) -> Result<(NamedScene, usize, Options)> {
        let scene = load(scene, &self.loading)?;
        let (camera, options) = self.shot.resolve(&scene)?;
        Ok((scene, camera, options))
    }
}

impl ShotArgs {
    /// The index of the camera, and the options of the render.
    pub fn resolve(&self, scene: &NamedScene) -> Result<(usize, Options)> {
        let camera = find_camera(scene, self.camera.as_deref())?;
        let (width, height) = scene.scene.cameras[camera].resolution(self.resolution);
        let options = Options {
            width,
            height,
            samples: self.samples,
            bounces: self.bounces,
            seed: self.seed,
            sequence: match self.sampler {
                SamplerKind::Sobol => Sequence::Sobol,
                SamplerKind::Independent => Sequence::Independent,
            },
            clamp: self.clamp,
            ..Options::default()
        };
        Ok((camera, options))
    }

    /// Runs `work` with as many threads as asked for.
    pub fn with_threads<T: Send>(&self, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
        let count = self.threads.unwrap_or(0) as usize;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        pool.context("cannot start the threads of the renderer")?.install(work)
    }
}

/// A picture and what it took.
#[derive(Debug)]
pub struct Shot {
    pub film: Film,
    /// Time to build trees and the tables of lights.
    pub build_seconds: f64,
    /// Time to take all samples.
    pub render_seconds: f64,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Samples of all pixels that were taken in this run.
    pub samples: u64,
    /// Ctrl-C ended it early: the film has fewer samples than asked for.
    pub interrupted: bool,
}

impl Shot {
    pub fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.render_seconds.max(1e-9)
    }

    pub fn samples_per_second(&self) -> f64 {
        self.samples as f64 / self.render_seconds.max(1e-9)
    }
}

/// Renders a scene as its shapes say, with a progress meter under the name `label`. Ctrl-C ends it
/// early.
pub fn take(scene: &Scene, camera: usize, options: &Options, label: &str) -> Result<Shot> {
    take_from(Film::for_options(options)?, scene, camera, options, label)
}

/// Adds samples to a picture until it has `samples` of them. Times and rays are those of the whole.
pub fn take_more(
    scene: &Scene,
    camera: usize,
    options: &Options,
    shot: &Shot,
    samples: u32,
    label: &str,
) -> Result<Shot> {
    let options = Options { samples, ..options.clone() };
    let more = take_from(shot.film.clone(), scene, camera, &options, label)?;
    Ok(Shot {
        build_seconds: shot.build_seconds,
        render_seconds: shot.render_seconds + more.render_seconds,
        rays: shot.rays + more.rays,
        samples: shot.samples + more.samples,
        ..more
    })
}

fn take_from(
    film: Film,
    scene: &Scene,
    camera: usize,
    options: &Options,
    label: &str,
) -> Result<Shot> {
    let start = Instant::now();
    let world = World::new(scene)?;
    let build_seconds = start.elapsed().as_secs_f64();
    let shot = take_on(film, &world, camera, options, label, &mut |_| {})?;
    Ok(Shot { build_seconds, ..shot })
}

/// Adds the samples that a film lacks, with a progress meter under the name `label`. `each_report` is
/// shown the film several times a second; Ctrl-C ends the render early. The world was built by the caller.
pub fn take_on(
    mut film: Film,
    world: &World<'_>,
    camera: usize,
    options: &Options,
    label: &str,
    each_report: &mut dyn FnMut(&Film),
) -> Result<Shot> {
    let cancel = Cancel::listen();
    let wanted = options.shard.share_of(options.samples);
    let mut meter = Meter::new(label, wanted);
    let (mut rays, mut samples) = (0, 0);
    let start = Instant::now();
    world.resume(&mut film, camera, options, &mut |progress| {
        (rays, samples) = (progress.rays, progress.samples);
        meter.update(progress);
        each_report(progress.film);
        if cancel.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let render_seconds = start.elapsed().as_secs_f64();
    meter.finish();
    let interrupted = film.samples() < wanted;
    Ok(Shot { film, build_seconds: 0.0, render_seconds, rays, samples, interrupted })
}

/// What is to be said of samples that are not as they should be; nothing if all are.
pub fn odd_samples(film: &Film) -> String {
    let mut text = String::new();
    for (count, what) in [
        (film.rejected(), "no radiance, counted as black"),
        (film.fireflies(), "brighter than any light"),
        (film.clamped(), "clamped"),
    ] {
        if count > 0 {
            text += &format!("; samples {what}: {count}");
        }
    }
    text
}
