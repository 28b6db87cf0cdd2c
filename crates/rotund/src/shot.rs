//! One render with its timings, and the options that all commands that render share.

use crate::cancel::Cancel;
use crate::kinds::KindArgs;
use crate::memory;
use crate::progress::Meter;
use crate::scene_source::{LoadArgs, NamedScene, find_camera, load};
use anyhow::{Context, Result};
use rotund_scene::Scene;
use rotund_trace::{Film, Options, Sequence, World};
use std::ffi::OsStr;
use std::ops::ControlFlow;
use std::time::Instant;

/// The source of random numbers.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum SamplerKind {
    /// Owen-scrambled Sobol points: their noise falls faster.
    Sobol,
    /// Independent numbers: plain Monte Carlo.
    Independent,
}

fn parse_clamp(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(clamp) if clamp > 0.0 => Ok(clamp),
        _ => Err("a radiance is a number above zero".to_owned()),
    }
}

/// Options of one render.
#[derive(Clone, Debug, clap::Args)]
pub struct ShotArgs {
    /// Name of the camera, or a camera as JSON, like an entry of `cameras` in a scene file.
    /// Default: the first one of the scene.
    #[arg(long)]
    pub(crate) camera: Option<String>,
    /// Samples per pixel.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub(crate) samples: u32,
    /// Pixels along the longer side.
    #[arg(long, default_value_t = 720, value_parser = clap::value_parser!(u32).range(1..=1 << 14))]
    pub(crate) resolution: u32,
    /// Segments of the longest path, counted from the camera.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1 << 16))]
    pub(crate) bounces: u32,
    /// Seed of the random numbers: another seed gives the same picture with other noise.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Source of random numbers.
    #[arg(long, value_enum, default_value = "sobol")]
    sampler: SamplerKind,
    /// Scale down samples with a channel above this radiance: less noise, but the picture gets
    /// darker.
    #[arg(long, value_name = "RADIANCE", value_parser = parse_clamp)]
    clamp: Option<f32>,
    /// Number of threads. Default: one for each processor. The picture is the same for any number.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 10))]
    pub(crate) threads: Option<u32>,
}

/// Options of a command that renders a scene.
#[derive(Clone, Debug, clap::Args)]
pub struct PictureArgs {
    /// Kinds of elements that are traced exactly.
    #[command(flatten)]
    pub kinds: KindArgs,
    /// Camera, size, samples and threads.
    #[command(flatten)]
    pub shot: ShotArgs,
    #[command(flatten)]
    pub(crate) loading: LoadArgs,
}

impl PictureArgs {
    /// Loads a scene by its name or path, and returns it with the index of the camera and the
    /// options of the render.
    ///
    /// # Errors
    ///
    /// If the scene cannot be loaded or has no such camera.
    pub fn load(&self, scene: &OsStr) -> Result<(NamedScene, usize, Options)> {
        let mut scene = load(scene, &self.loading)?;
        let (camera, options) = self.shot.resolve(&mut scene)?;
        Ok((scene, camera, options))
    }
}

impl ShotArgs {
    /// Returns the index of the camera, which may be added to the scene, and the options of the
    /// render.
    fn resolve(&self, scene: &mut NamedScene) -> Result<(usize, Options)> {
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

    /// Runs `work` on the number of threads that the options ask for.
    ///
    /// # Errors
    ///
    /// If the threads cannot be started, or `work` fails.
    pub fn with_threads<T: Send>(&self, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
        let count = self.threads.unwrap_or(0) as usize;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        pool.context("cannot start the threads of the renderer")?.install(work)
    }
}

/// A picture with its timings.
#[derive(Debug)]
pub struct Shot {
    /// The picture.
    pub film: Film,
    /// Seconds to build the trees and the tables of lights.
    pub build_seconds: f64,
    /// Seconds to take all samples.
    pub render_seconds: f64,
    /// Number of rays, shadow rays included.
    pub rays: u64,
    /// Number of samples of all pixels that this run took.
    pub samples: u64,
    /// True if a signal ended the render early: the film has fewer samples than asked for.
    pub interrupted: bool,
}

impl Shot {
    pub(crate) fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.render_seconds.max(1e-9)
    }

    pub(crate) fn samples_per_second(&self) -> f64 {
        self.samples as f64 / self.render_seconds.max(1e-9)
    }
}

/// Renders a scene by the methods of its shapes, with a progress meter under the name `label`.
/// A signal ends the render early.
///
/// # Errors
///
/// If the scene or the options are invalid.
pub fn take(scene: &Scene, camera: usize, options: &Options, label: &str) -> Result<Shot> {
    take_from(Film::for_options(options)?, scene, camera, options, label)
}

/// Adds samples to a picture until it has `samples` of them. Timings and counts include those of
/// `shot`.
pub(crate) fn take_more(
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
    memory::check_scene(scene)?;
    let start = Instant::now();
    let world = World::new(scene)?;
    let build_seconds = start.elapsed().as_secs_f64();
    let shot = take_on(film, &world, camera, options, label, &mut |_, _| {})?;
    Ok(Shot { build_seconds, ..shot })
}

/// Adds the samples that a film lacks, with a progress meter under the name `label`. `each_report`
/// gets the film several times a second. A signal ends
/// the render early.
pub(crate) fn take_on(
    mut film: Film,
    world: &World<'_>,
    camera: usize,
    options: &Options,
    label: &str,
    each_report: &mut dyn FnMut(&Film, Cancel),
) -> Result<Shot> {
    let cancel = Cancel::listen();
    let wanted = options.shard.share_of(options.samples);
    let mut meter = Meter::new(label, wanted);
    let (mut rays, mut samples) = (0, 0);
    let start = Instant::now();
    world.resume(&mut film, camera, options, &mut |progress| {
        (rays, samples) = (progress.rays, progress.samples);
        meter.update(progress);
        each_report(progress.film, cancel);
        if cancel.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let render_seconds = start.elapsed().as_secs_f64();
    let interrupted = film.samples() < wanted;
    meter.finish(interrupted);
    Ok(Shot { film, build_seconds: 0.0, render_seconds, rays, samples, interrupted })
}

/// Returns counts of rejected and clamped samples for the end of a message; an empty text if there
/// are none.
pub(crate) fn odd_samples(film: &Film) -> String {
    let mut text = String::new();
    for (count, what) in [
        (film.rejected(), "not finite or beyond 5e11, counted as black"),
        (film.fireflies(), "brighter than any light"),
        (film.clamped(), "clamped"),
    ] {
        if count > 0 {
            text += &format!("; samples {what}: {count}");
        }
    }
    text
}
