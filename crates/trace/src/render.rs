//! All pixels of a picture, over all threads.

use crate::path::World;
use crate::{Film, Lights, Sampler, Sequence, Shard, View, film::PixelSum};
use glam::Vec2;
use rayon::prelude::*;
use rotund_scene::{Scene, Trees};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Pixels in a row; see [`rotund_scene::Camera::resolution`].
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples per pixel, over all shards.
    pub samples: u32,
    /// Segments of the longest path, counted from the camera: 1 shows what shines, 2 direct light.
    pub bounces: u32,
    /// Another seed is another, independent picture of the same scene.
    pub seed: u64,
    /// Where random numbers come from.
    pub sequence: Sequence,
    /// Which of the samples are rendered.
    pub shard: Shard,
    /// What the picture shows.
    pub view: View,
    /// Samples whose largest channel is above this are scaled down to it. That takes light away, so
    /// there is none by default; [`Film::clamped`] counts them.
    pub clamp: Option<f32>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            width: 720,
            height: 405,
            samples: 64,
            bounces: 8,
            seed: 0,
            sequence: Sequence::Sobol,
            shard: Shard::default(),
            view: View::Path,
            clamp: None,
        }
    }
}

/// How far a render has come; it is told after each pass over all pixels.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// What there is: `film.samples` of the samples are done.
    pub film: &'a Film,
    /// Rays traced in this run, shadow rays included.
    pub rays: u64,
    /// Since this run began.
    pub elapsed: Duration,
}

/// Renders a picture with the threads of the current rayon pool, in passes over all pixels.
///
/// After each pass, which takes about half a second, `progress` is told; if it breaks, the render
/// ends with the samples it has. The passes, and so the clock, decide only when that is: the same
/// samples make the same picture, bit for bit, on any number of threads.
///
/// # Panics
///
/// If the scene has no camera of that index.
pub fn render(
    scene: &Scene,
    trees: &Trees,
    lights: &Lights,
    camera: usize,
    options: &Options,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Film {
    let mut film = Film::new(options);
    resume(&mut film, scene, trees, lights, camera, options, progress);
    film
}

/// Adds to a film the samples that it lacks; see [`render`].
///
/// # Panics
///
/// If the scene has no camera of that index, or the film has not the size, seed and shard that `options`
/// say.
pub fn resume(
    film: &mut Film,
    scene: &Scene,
    trees: &Trees,
    lights: &Lights,
    camera: usize,
    options: &Options,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) {
    let of_film = (film.width, film.height, film.seed, film.shard);
    let of_options = (options.width, options.height, options.seed, options.shard);
    assert!(of_film == of_options, "a film of {of_film:?} cannot be resumed as {of_options:?}");
    let camera = &scene.cameras[camera];
    let world = World::new(scene, trees, lights, options);
    let brightest = match options.view {
        View::Path => lights.brightest(),
        _ => f32::INFINITY,
    };
    // What is exactly as bright may come out a few roundings brighter.
    let brightest = brightest * (1.0 + 1.0 / 1024.0);
    let clamp = options.clamp.unwrap_or(f32::INFINITY);
    let size = Vec2::new(options.width as f32, options.height as f32);
    // One sample of one pixel; returns the rays it took and whether it was rejected, was brighter than
    // any source and was clamped.
    let sample = |sum: &mut PixelSum, x: u32, y: u32, index: u32| -> [u64; 4] {
        let index = options.shard.index + index * options.shard.count;
        let sampler = Sampler::new(options.sequence, options.seed, x, y, index);
        let [u, v, lens_u, lens_v] = sampler.set(0);
        let image_uv = Vec2::new(x as f32 + u, y as f32 + v) / size;
        let lens_uv = crate::warp::disk(Vec2::new(lens_u, lens_v));
        let arrived = world.look(options.view, camera.ray(image_uv, lens_uv), &sampler);
        let bright = arrived.radiance.max_element();
        let clamped = bright > clamp;
        let radiance = if clamped { arrived.radiance * (clamp / bright) } else { arrived.radiance };
        let fit = sum.add(radiance.to_array(), arrived.covered);
        [arrived.rays, u64::from(!fit), u64::from(fit && bright > brightest), u64::from(clamped)]
    };

    let start = Instant::now();
    let mut rays = 0;
    let mut pass_samples = 1;
    let samples = options.shard.share_of(options.samples);
    while film.samples < samples && film.width > 0 {
        let pass_start = Instant::now();
        let first = film.samples;
        let last = samples.min(first.saturating_add(pass_samples));
        let row = |(y, row): (usize, &mut [PixelSum])| {
            let mut counts = [0; 4];
            for (x, sum) in row.iter_mut().enumerate() {
                for index in first..last {
                    counts = add(counts, sample(sum, x as u32, y as u32, index));
                }
            }
            counts
        };
        let [pass_rays, rejected, fireflies, clamped] = film
            .pixels
            .par_chunks_mut(film.width as usize)
            .enumerate()
            .map(row)
            .reduce(|| [0; 4], add);
        rays += pass_rays;
        film.rejected += rejected;
        film.fireflies += fireflies;
        film.clamped += clamped;
        film.samples = last;
        if progress(&Progress { film, rays, elapsed: start.elapsed() }).is_break() {
            break;
        }
        let fast = pass_start.elapsed() < PASS_TIME / 2;
        pass_samples = if fast { pass_samples * 2 } else { pass_samples };
    }
}

/// Passes get longer until they take between half of this and twice as much.
const PASS_TIME: Duration = Duration::from_millis(500);

fn add(a: [u64; 4], b: [u64; 4]) -> [u64; 4] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}
