//! Rendering a world into a film.

use crate::context::{Arrived, Context};
use crate::film::{Film, FilmHeader, FilmSample, GROUP, Limits, Place, Progress, Splats};
use crate::{Options, RenderError, Sampler, View, World, camera_ray};
use rotund_scene::Camera;
use std::array;
use std::ops::ControlFlow;

impl World<'_> {
    /// Renders a picture with the threads of the current rayon pool.
    ///
    /// # Errors
    ///
    /// If the scene has no such camera, [`Options::validate`] refuses the options, or the film does
    /// not fit into memory.
    pub fn render(&self, camera: usize, options: &Options) -> Result<Film, RenderError> {
        self.render_with(camera, options, &mut |_| ControlFlow::Continue(()))
    }

    /// Renders a picture with the threads of the current rayon pool, with progress and
    /// cancellation.
    ///
    /// `progress` is called at least every 0.1 s, whatever the size of the picture. If it returns
    /// [`ControlFlow::Break`], the film has the samples taken so far, and [`Self::resume`] adds the
    /// others.
    ///
    /// The clock decides only when `progress` is called. The same samples make the same picture,
    /// bit for bit, on any number of threads, with any interruptions.
    ///
    /// # Errors
    ///
    /// As [`Self::render`].
    pub fn render_with(
        &self,
        camera: usize,
        options: &Options,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Film, RenderError> {
        self.camera(camera)?;
        let mut film = Film::for_options(options)?;
        self.resume(&mut film, camera, options, progress)?;
        Ok(film)
    }

    /// Adds to a film the samples that it lacks, as [`Self::render_with`] would have taken them.
    ///
    /// A film with all samples of `options` or more stays as it is. The film does not record scene,
    /// camera and the other options; the caller must pass the same ones.
    ///
    /// # Errors
    ///
    /// If the scene has no such camera, [`Options::validate`] refuses the options, or the film is
    /// not of the size, seed and shard of the options. The film is unchanged then.
    pub fn resume(
        &self,
        film: &mut Film,
        camera: usize,
        options: &Options,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        self.camera(camera)?;
        options.validate()?;
        check_film(film, options)?;
        match self.near(camera, options)? {
            None => {
                let context = self.context(options);
                take_samples(film, &context, &self.scene().cameras[camera], options, progress);
            }
            Some(near) => {
                let context =
                    Context::new(&near.scene, &near.trees, &near.lights, near.facts, options);
                take_samples(film, &context, &near.scene.cameras[camera], options, progress);
            }
        }
        Ok(())
    }
}

fn check_film(film: &Film, options: &Options) -> Result<(), RenderError> {
    let (film, options) = (film.header(), FilmHeader::for_options(options));
    let shard = |header: &FilmHeader| header.shards.to_string().replacen("shard ", "", 1);
    let fields = [
        ("width", film.width.to_string(), options.width.to_string()),
        ("height", film.height.to_string(), options.height.to_string()),
        ("seed", film.seed.to_string(), options.seed.to_string()),
        ("shard", shard(film), shard(&options)),
    ];
    for (field, film, options) in fields {
        if film != options {
            return Err(RenderError::OtherPicture { field, film, options });
        }
    }
    Ok(())
}

fn take_samples(
    film: &mut Film,
    context: &Context<'_>,
    camera: &Camera,
    options: &Options,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) {
    let size = [options.width, options.height];
    let brightest = match options.view {
        View::Path => context.lights.brightest(),
        _ => f32::INFINITY,
    };
    let limits = Limits {
        clamp: options.clamp.unwrap_or(f32::INFINITY),
        // Rounding may make a sample a little brighter than the light that it shows.
        brightest: brightest * (1.0 + 1.0 / 1024.0),
    };
    let context = context.with_light_paths(camera, options);
    let is_path = matches!(options.view, View::Path | View::Furnace);
    let integrator = |places: &[Place], splats: &mut Splats, samples: &mut [FilmSample]| {
        let start = |&[x, y, sample]: &Place| {
            let sampler = Sampler::new(options.sequence, options.seed, x, y, sample);
            (sampler, camera_ray(camera, size, [x, y], &sampler))
        };
        // The rays of a group are traced in turn before any path goes on: they meet much the same,
        // and none waits for the one before.
        let starts: [_; GROUP] = array::from_fn(|i| start(&places[i.min(places.len() - 1)]));
        let found: [_; GROUP] = array::from_fn(|i| {
            if is_path && i < places.len() { context.camera_hit(&starts[i].1) } else { None }
        });
        let starts = starts.iter().zip(&found);
        for ((place, out), ((sampler, ray), found)) in places.iter().zip(samples).zip(starts) {
            let arrived = if is_path {
                context.trace(*ray, sampler, found)
            } else {
                context.look(options.view, *ray, sampler)
            };
            let Arrived { radiance, covered, rays } = arrived;
            let of_light = context.trace_light(options, *place, &mut |splat| splats.push(splat));
            *out = FilmSample { radiance, covered, rays: rays + of_light };
        }
    };
    film.take_samples(options.samples, limits, &integrator, progress);
}
