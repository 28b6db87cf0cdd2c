//! Taking samples of all pixels in parallel, with progress reports and cancellation.

use super::schedule::Schedule;
use super::{Film, PixelSum};
use crate::Shard;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};
use std::time::{Duration, Instant};

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmSample {
    /// Radiance, in linear Rec. 709.
    pub radiance: Vec3,
    /// Whether the sample met something; the mean over the samples of a pixel is its alpha.
    pub covered: bool,
    /// Rays traced for the sample, for [`Progress::rays`] alone.
    pub rays: u64,
}

impl From<Vec3> for FilmSample {
    /// A sample of this radiance that met something.
    fn from(radiance: Vec3) -> Self {
        Self { radiance, covered: true, rays: 0 }
    }
}

/// The state of a render between two batches of pixels.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// The film so far. Some pixels may have more samples than others.
    pub film: &'a Film,
    /// Samples taken in this run, over all pixels.
    pub samples: u64,
    /// Samples that this run takes if it is not cancelled, over all pixels.
    pub total: u64,
    /// Rays traced in this run, shadow rays included.
    pub rays: u64,
    /// Time since the run began.
    pub elapsed: Duration,
}

impl Progress<'_> {
    /// Returns the completed fraction of this run, in `0.0..=1.0`.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        if self.total == 0 { 1.0 } else { self.samples as f64 / self.total as f64 }
    }
}

/// Column and row of a pixel, and the index of a sample.
pub(crate) type Place = [u32; 3];

/// Number of samples that an integrator takes together. From 4 to 16 of them take the same time.
pub(crate) const GROUP: usize = 8;

/// Returns an integrator of groups of samples that takes each by itself.
pub(crate) fn one_by_one(
    integrator: impl Fn(Place, &mut Splats) -> FilmSample + Sync,
) -> impl Fn(&[Place], &mut Splats, &mut [FilmSample]) + Sync {
    move |places, splats, samples| {
        for (&place, sample) in places.iter().zip(samples) {
            *sample = integrator(place, splats);
        }
    }
}

/// Light for any pixels, beside that of the sample which found it.
pub(crate) type Splats = Vec<Splat>;

/// Light that belongs to a pixel but to none of its samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat {
    /// Place in the picture, `0.0..1.0`.
    pub(crate) image_uv: Vec2,
    /// Radiance of each of the samples of the pixel that the light is spread over.
    pub(crate) radiance: Vec3,
    /// Number of those samples.
    pub(crate) samples: f32,
}

/// Treatment of bright samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Samples with a larger channel are scaled down to it.
    pub(crate) clamp: f32,
    /// Samples with a larger channel are counted as fireflies.
    pub(crate) brightest: f32,
}

impl Limits {
    pub(crate) const NONE: Self = Self { clamp: f32::INFINITY, brightest: f32::INFINITY };
}

/// Statistics of the samples of a batch.
#[derive(Default)]
struct Tally {
    splats: Splats,
    samples: u64,
    rays: u64,
    rejected: u64,
    fireflies: u64,
    clamped: u64,
    /// Pixels that have all samples of the pass now, and had not before.
    finished: usize,
    /// Those of them that had no more samples than the minimum of the film.
    advanced: usize,
}

/// Samples that are taken together.
#[derive(Default)]
struct Group {
    places: [Place; GROUP],
    /// The pixel of each, as an index into a slice.
    owners: [usize; GROUP],
    count: usize,
}

impl Group {
    fn push(&mut self, place: Place, owner: usize) {
        (self.places[self.count], self.owners[self.count]) = (place, owner);
        self.count += 1;
    }

    /// Takes the samples and adds them to their pixels.
    fn take(
        &mut self,
        integrator: &impl Fn(&[Place], &mut Splats, &mut [FilmSample]),
        pixels: &mut [PixelSum],
        tally: &mut Tally,
        limits: Limits,
    ) {
        let count = std::mem::take(&mut self.count);
        if count == 0 {
            return;
        }
        let mut samples = [FilmSample::default(); GROUP];
        let samples = &mut samples[..count];
        integrator(&self.places[..count], &mut tally.splats, samples);
        for (&owner, sample) in self.owners.iter().zip(samples) {
            tally.add(&mut pixels[owner], *sample, limits);
        }
    }
}

/// The part of a render that a batch takes.
struct Batch {
    pixels: Range<usize>,
    /// Pixels of a run.
    run: usize,
    /// Pixels of a run between two looks at the clock.
    stride: usize,
    /// Samples of a pixel after the batch.
    samples: u32,
    start: Instant,
}

impl Film {
    /// Takes samples with the threads of the current rayon pool until every pixel has `samples`
    /// samples, or the part of them that belongs to the film's shard; see
    /// [`Self::accumulate_with`].
    ///
    /// # Panics
    ///
    /// As [`Self::accumulate_with`].
    pub fn accumulate(
        &mut self,
        samples: u32,
        integrator: impl Fn(u32, u32, u32) -> FilmSample + Sync,
    ) {
        self.accumulate_with(samples, integrator, &mut |_| ControlFlow::Continue(()));
    }

    /// Takes samples with the threads of the current rayon pool until every pixel has `samples`
    /// samples, or the part of them that belongs to the film's shard, or `progress` returns
    /// [`ControlFlow::Break`].
    ///
    /// `integrator` returns the sample of pixel `(x, y)`, counted from the top left corner, with a
    /// sample index in `0..samples`. If its result depends on these three alone, so does the film:
    /// neither the number of threads nor an interruption changes a bit. A film of a
    /// [`crate::Shard`] takes the indices of its shard only.
    ///
    /// `progress` is called at least every 0.1 s, whatever the size of the film, as long as a
    /// single sample takes less than some milliseconds. If it returns [`ControlFlow::Break`], the
    /// film keeps the samples it has, and another call goes on from there.
    ///
    /// # Panics
    ///
    /// If the film is a merge of some of the shards of a picture.
    pub fn accumulate_with(
        &mut self,
        samples: u32,
        integrator: impl Fn(u32, u32, u32) -> FilmSample + Sync,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) {
        let alone = one_by_one(|[x, y, sample], _| integrator(x, y, sample));
        self.take_samples(samples, Limits::NONE, &alone, progress);
    }

    /// [`Self::accumulate_with`], with a treatment of bright samples, and an integrator that takes
    /// up to [`GROUP`] samples at a time.
    pub(crate) fn take_samples(
        &mut self,
        samples: u32,
        limits: Limits,
        integrator: &(impl Fn(&[Place], &mut Splats, &mut [FilmSample]) + Sync),
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) {
        let start = Instant::now();
        let shard = self.header.shards.only().expect("one shard, not a merge of some");
        let target = shard.share_of(samples);
        // The samples that are missing, and the most that a pixel has.
        let count =
            |pixel: &PixelSum| (u64::from(target.saturating_sub(pixel.samples)), pixel.samples);
        let join = |a: (u64, u32), b: (u64, u32)| (a.0 + b.0, a.1.max(b.1));
        let pixels = self.pixels.par_iter().with_min_len(1 << 14);
        let (total, most) = pixels.map(count).reduce(|| (0, 0), join);
        if most <= target {
            self.header.wanted = samples;
        }
        let mut schedule = Schedule::new(rayon::current_num_threads());
        let (mut taken, mut rays) = (0, 0);
        while self.header.samples < target {
            let pass = target.min(self.header.samples.saturating_add(schedule.pass_samples()));
            let mut next = 0;
            // Pixels that have the samples of this pass already come from an interrupted run, or
            // from a batch that ran out of time.
            while let Some(first) = self.first_behind(next, pass) {
                let start_of_batch = Instant::now();
                let end = self.pixels.len().min(first.saturating_add(schedule.batch()));
                let batch = Batch {
                    pixels: first..end,
                    run: schedule.run(end - first),
                    stride: schedule.stride(),
                    samples: pass,
                    start: start_of_batch,
                };
                next = first;
                let tally = self.take_batch(&batch, shard, limits, integrator);
                taken += tally.samples;
                rays += tally.rays;
                self.rejected += tally.rejected;
                self.fireflies += tally.fireflies;
                self.clamped += tally.clamped;
                self.advance(tally.advanced);
                schedule.batch_took(tally.finished, start_of_batch.elapsed());
                let elapsed = start.elapsed();
                let report = Progress { film: self, samples: taken, total, rays, elapsed };
                if progress(&report).is_break() {
                    return;
                }
            }
            schedule.pass_ended();
        }
    }

    /// Returns the first pixel from `start` on that has fewer than `samples` samples.
    fn first_behind(&self, start: usize, samples: u32) -> Option<usize> {
        let mut rest = self.pixels[start..].iter();
        rest.position(|pixel| pixel.samples < samples).map(|offset| start + offset)
    }

    /// Takes the samples that the pixels of a batch lack, or some of them if the time is over.
    fn take_batch(
        &mut self,
        batch: &Batch,
        shard: Shard,
        limits: Limits,
        integrator: &(impl Fn(&[Place], &mut Splats, &mut [FilmSample]) + Sync),
    ) -> Tally {
        let (width, minimum) = (self.header.width as usize, self.header.samples);
        let run = |(index, pixels): (usize, &mut [PixelSum])| {
            let mut tally = Tally::default();
            let mut group = Group::default();
            let mut first = index * batch.run;
            for pixels in pixels.chunks_mut(batch.stride) {
                // The first pixels are always taken, so that a batch cannot end without a sample.
                if first > 0 && Schedule::is_over(batch.start.elapsed()) {
                    break;
                }
                for owner in 0..pixels.len() {
                    let pixel = batch.pixels.start + first + owner;
                    let (x, y) = ((pixel % width) as u32, (pixel / width) as u32);
                    let taken = pixels[owner].samples;
                    if taken >= batch.samples {
                        continue;
                    }
                    tally.finished += 1;
                    tally.advanced += usize::from(taken == minimum);
                    for sample in taken..batch.samples {
                        group.push([x, y, shard.sample_index(sample)], owner);
                        if group.count == GROUP {
                            group.take(integrator, pixels, &mut tally, limits);
                        }
                    }
                }
                group.take(integrator, pixels, &mut tally, limits);
                first += pixels.len();
            }
            tally
        };
        let tally = self.pixels[batch.pixels.clone()]
            .par_chunks_mut(batch.run)
            .enumerate()
            .with_max_len(1)
            .map(run)
            .reduce(Tally::default, Tally::join);
        self.add_splats(tally, limits)
    }

    /// Adds the light of light paths to the pixels that see it.
    fn add_splats(&mut self, mut tally: Tally, limits: Limits) -> Tally {
        let [width, height] = [self.header.width, self.header.height];
        for Splat { image_uv, radiance, samples } in std::mem::take(&mut tally.splats) {
            // Rounding may lead to the right or lower edge.
            let place = |share: f32, size: u32| ((share * size as f32) as u32).min(size - 1);
            let (x, y) = (place(image_uv.x, width), place(image_uv.y, height));
            let pixel = &mut self.pixels[y as usize * width as usize + x as usize];
            let (radiance, bright) = tally.limit(radiance, limits);
            let valid = pixel.add_light((samples * radiance).to_array());
            tally.judge(valid, bright, limits);
        }
        tally
    }
}

impl Tally {
    /// Adds a sample to a pixel.
    fn add(&mut self, sum: &mut PixelSum, sample: FilmSample, limits: Limits) {
        let (radiance, bright) = self.limit(sample.radiance, limits);
        let valid = sum.add(radiance.to_array(), sample.covered);
        self.samples += 1;
        self.rays += sample.rays;
        self.judge(valid, bright, limits);
    }

    /// Returns a radiance, scaled down to the limit, and its largest channel before.
    fn limit(&mut self, radiance: Vec3, limits: Limits) -> (Vec3, f32) {
        let bright = radiance.max_element();
        let clamped = bright > limits.clamp;
        self.clamped += u64::from(clamped);
        (if clamped { radiance * (limits.clamp / bright) } else { radiance }, bright)
    }

    /// Counts what is wrong with an addition to a pixel.
    fn judge(&mut self, valid: bool, bright: f32, limits: Limits) {
        self.rejected += u64::from(!valid);
        self.fireflies += u64::from(valid && bright > limits.brightest);
    }

    fn join(mut self, other: Self) -> Self {
        self.splats.extend(other.splats);
        Self {
            splats: self.splats,
            samples: self.samples + other.samples,
            rays: self.rays + other.rays,
            rejected: self.rejected + other.rejected,
            fireflies: self.fireflies + other.fireflies,
            clamped: self.clamped + other.clamped,
            finished: self.finished + other.finished,
            advanced: self.advanced + other.advanced,
        }
    }
}
