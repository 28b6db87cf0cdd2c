//! One render: trees, lights, samples, and how long each took.

use crate::cancel::Cancel;
use crate::progress::Meter;
use crate::scene_source::{NamedScene, find_camera};
use anyhow::{Context, Result, bail};
use rotund_scene::{Scene, Trees};
use rotund_trace::{Film, Lights, Options, render};
use std::ops::ControlFlow;
use std::time::Instant;

/// How to take a picture of a scene.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ShotArgs {
    /// The camera to look through; the first of the scene if not given.
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
    /// Another seed is another picture of the same scene.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Threads to render with; one for each processor if not given. The picture is the same.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 10))]
    pub(crate) threads: Option<u32>,
}

impl ShotArgs {
    /// The index of the camera, and the options of the render.
    pub(crate) fn resolve(&self, scene: &NamedScene) -> Result<(usize, Options)> {
        let camera = find_camera(scene, self.camera.as_deref())?;
        let (width, height) = scene.scene.cameras[camera].resolution(self.resolution);
        let options = Options {
            width,
            height,
            samples: self.samples,
            bounces: self.bounces,
            seed: self.seed,
            ..Options::default()
        };
        Ok((camera, options))
    }

    /// Runs `work` with as many threads as asked for.
    pub(crate) fn with_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T> {
        let count = self.threads.unwrap_or(0) as usize;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        Ok(pool.context("cannot start the threads of the renderer")?.install(work))
    }
}

/// A picture and what it took.
#[derive(Debug)]
pub(crate) struct Shot {
    pub(crate) film: Film,
    /// Time to build trees and the tables of lights.
    pub(crate) build_seconds: f64,
    /// Time to take all samples.
    pub(crate) render_seconds: f64,
    /// Rays traced, shadow rays included.
    pub(crate) rays: u64,
}

impl Shot {
    pub(crate) fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.render_seconds.max(1e-9)
    }
}

/// Renders a scene as its shapes say, with a progress meter under the name `label`.
///
/// # Errors
///
/// If Ctrl-C is pressed.
pub(crate) fn take(scene: &Scene, camera: usize, options: &Options, label: &str) -> Result<Shot> {
    let cancel = Cancel::listen();
    let start = Instant::now();
    let trees = Trees::build(scene);
    let lights = Lights::build(scene);
    let build_seconds = start.elapsed().as_secs_f64();

    let mut meter = Meter::new(label, options.samples);
    let mut rays = 0;
    let start = Instant::now();
    let film = render(scene, &trees, &lights, camera, options, &mut |progress| {
        rays = progress.rays;
        meter.update(progress.film.samples, progress.rays, progress.elapsed);
        if cancel.requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let render_seconds = start.elapsed().as_secs_f64();
    meter.finish();
    if film.samples < options.samples {
        bail!(crate::cancel::Cancelled);
    }
    Ok(Shot { film, build_seconds, render_seconds, rays })
}
