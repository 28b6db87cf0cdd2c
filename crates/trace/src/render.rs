//! All pixels of a picture, over all threads.

use crate::path::World;
use crate::{Film, Lights, Sampler, Sequence, Shard, film::PixelSum};
use glam::Vec2;
use rayon::prelude::*;
use rotund_scene::{Material, MaterialKind, Pixels, Scene, Trees};
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
    let world = World { scene, trees, lights, bounces: options.bounces, opaque: is_opaque(scene) };
    let size = Vec2::new(options.width as f32, options.height as f32);
    // One sample of one pixel; returns the rays it took and whether it was rejected.
    let sample = |sum: &mut PixelSum, x: u32, y: u32, index: u32| -> [u64; 2] {
        let index = options.shard.index + index * options.shard.count;
        let sampler = Sampler::new(options.sequence, options.seed, x, y, index);
        let [u, v, lens_u, lens_v] = sampler.set(0);
        let image_uv = Vec2::new(x as f32 + u, y as f32 + v) / size;
        let lens_uv = crate::warp::disk(Vec2::new(lens_u, lens_v));
        let arrived = world.trace(camera.ray(image_uv, lens_uv), &sampler);
        let fit = sum.add(arrived.radiance.to_array(), arrived.covered);
        [arrived.rays, u64::from(!fit)]
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
            let mut counts = [0, 0];
            for (x, sum) in row.iter_mut().enumerate() {
                for index in first..last {
                    let [rays, rejected] = sample(sum, x as u32, y as u32, index);
                    counts[0] += rays;
                    counts[1] += rejected;
                }
            }
            counts
        };
        let [pass_rays, rejected] = film
            .pixels
            .par_chunks_mut(film.width as usize)
            .enumerate()
            .map(row)
            .reduce(|| [0, 0], |a, b| [a[0] + b[0], a[1] + b[1]]);
        rays += pass_rays;
        film.rejected += rejected;
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

/// True if no surface of the scene lets rays go straight through.
fn is_opaque(scene: &Scene) -> bool {
    let image_is_opaque = |texture: &Option<u32>| {
        texture.is_none_or(|texture| match &scene.textures[texture as usize].pixels {
            Pixels::Bytes(pixels) => pixels.iter().all(|&[.., alpha]| alpha == u8::MAX),
            Pixels::Floats(pixels) => pixels.iter().all(|&[.., alpha]| alpha >= 1.0),
        })
    };
    let is_opaque = |material: &Material| {
        material.opacity >= 1.0
            && material.kind != MaterialKind::Volumetric
            && image_is_opaque(&material.color_tex)
    };
    scene.materials.iter().all(is_opaque)
        && scene.shapes.iter().all(|shape| shape.colors.iter().all(|color| color.w >= 1.0))
}
