//! Rendering for one client: previews, samples at full size, and what it is told of them.

use super::{Phase, Seat};
use crate::denoise::Guides;
use crate::message::{Activity, Event, FrameHeader, Status};
use crate::place::Place;
use crate::shared::{Kept, Shared};
use crate::side::Side;
use rotund_image::{Image, luminance};
use rotund_trace::{Film, Options, RenderError, World};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time that a preview may take.
const PREVIEW: Duration = Duration::from_millis(25);
/// Pixels of the smallest preview.
const FEWEST_PIXELS: f64 = 48.0 * 32.0;
/// Factor of the number of pixels from one preview to the next while the camera rests.
const STEP: f64 = 4.0;
/// Least time between two pictures of a refinement.
const PUBLISH: Duration = Duration::from_millis(200);
/// Pictures come the more rarely the longer they are refined, since each changes less: this part of
/// the time goes by between two of them, so that samples double from one to the next.
const RARER: u32 = 1;
/// Longest time between two pictures that take less than a sixteenth of it.
const RAREST: Duration = Duration::from_secs(4);
/// Longest time between two reports, and the part of the time that goes by before.
const REPORT: Duration = Duration::from_millis(1000);
const RARER_REPORTS: u32 = 4;
/// Least time between two pictures, in times that it takes to make one from the film and to encode
/// it: samples must not wait for pictures.
const PUBLISH_COST: u32 = 16;
/// The same for the removal of noise, which takes longer than all else.
const DENOISE_COST: u32 = 3;
/// Time of a slice if both sides of a comparison, or several clients, take turns.
const TURN: Duration = Duration::from_millis(300);

/// Returns what is known of the pixels of a picture, whose camera is the last one.
fn guides(world: &World<'_>, options: &Options) -> Result<Guides, RenderError> {
    let layers = world.layers(world.scene().cameras.len() - 1, options)?;
    Ok(Guides { albedo: layers.albedo, normal: layers.normal })
}

impl Seat {
    /// Renders for a while: one preview, or samples at full size until `interrupted` says so. If
    /// not `alone`, others have their turn soon.
    pub(crate) fn step(
        &mut self,
        place: &mut Place,
        alone: bool,
        interrupted: &dyn Fn(&Shared) -> bool,
    ) {
        let done = match self.phase {
            Phase::Preview(pixels) => self.preview(place, pixels, interrupted),
            Phase::Refine => self.refine(place, alone, interrupted),
            Phase::Done => Ok(()),
        };
        if let Err(error) = done {
            self.problem(format_args!("the picture cannot be rendered: {error}"));
            self.phase = Phase::Done;
        }
    }

    /// Renders a small picture of one sample a pixel.
    fn preview(
        &mut self,
        place: &mut Place,
        pixels: f64,
        interrupted: &dyn Fn(&Shared) -> bool,
    ) -> Result<(), RenderError> {
        let full = self.options();
        let whole = f64::from(full.width) * f64::from(full.height);
        let sides = self.sides();
        // The first one after a change is finished whatever happens, or a hand that never rests
        // would see nothing.
        let first = pixels <= 0.0;
        let affordable = self.speed * PREVIEW.as_secs_f64() / sides.len() as f64;
        let pixels = if first { affordable.max(FEWEST_PIXELS) } else { pixels };
        let scale = (pixels / whole).sqrt().min(1.0);
        let side = |length: u32| ((f64::from(length) * scale).round() as u32).max(1);
        let small = Options {
            width: side(full.width),
            height: side(full.height),
            samples: 1,
            // To move a far scene takes longer than a preview.
            recenter: false,
            ..full
        };
        let start = Instant::now();
        let mut images = Vec::new();
        for &side in sides {
            self.configure(place, side)?;
            let world = place.world();
            let mut film = self.new_film(side, &small)?;
            world.resume(&mut film, place.seat_camera(), &small, &mut |_| {
                let stop = !first && self.is_interrupted(&world, interrupted);
                if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })?;
            let image = (film.samples() > 0).then(|| self.buffers.develop(&film));
            self.spare[side as usize] = Some(film);
            let Some(image) = image else { return Ok(()) };
            images.push((side, image));
        }
        let taken = f64::from(small.width) * f64::from(small.height) * sides.len() as f64;
        let speed = taken / start.elapsed().as_secs_f64().max(1e-6);
        // Half of the last speed, so that one slow picture does not decide alone.
        self.speed = (0.5 * (self.speed + speed)).clamp(1e3, 1e9);
        for (side, image) in images {
            self.publish(side, image, 1, true);
        }
        let next = pixels * STEP;
        self.phase = if 2.0 * next >= whole { Phase::Refine } else { Phase::Preview(next) };
        self.report(0, Activity::Moving);
        Ok(())
    }

    /// Adds samples at full size, to the side that has fewer.
    fn refine(
        &mut self,
        place: &mut Place,
        alone: bool,
        interrupted: &dyn Fn(&Shared) -> bool,
    ) -> Result<(), RenderError> {
        let full = self.options();
        let sides = self.sides();
        let samples =
            |seat: &Self, side: Side| seat.films[side as usize].as_ref().map_or(0, Film::samples);
        let side = sides.iter().copied().min_by_key(|&side| {
            // Of finished films, one that has not been denoised.
            (samples(self, side), !self.lacks_guides(side))
        });
        let side = side.unwrap_or(Side::Chosen);
        let compared = sides.len() > 1;
        // Both sides of a comparison keep step, so that they are equally noisy.
        let doubled = (2 * samples(self, side)).clamp(1, full.samples);
        let goal = if compared { doubled } else { full.samples };
        let mut film = match self.films[side as usize].take() {
            Some(film) => film,
            None => self.new_film(side, &full)?,
        };
        self.configure(place, side)?;
        let world = place.world();
        let options = Options { samples: goal, ..full.clone() };
        let before = self.progress[side as usize];
        let result = world.resume(&mut film, place.seat_camera(), &options, &mut |progress| {
            self.progress[side as usize] = before.and(progress.rays, progress.elapsed);
            let whole = progress.film.samples() > 0;
            let over = (!alone || compared) && whole && progress.elapsed >= TURN;
            let stop = self.is_interrupted(&world, interrupted) || over;
            if whole && !stop && self.is_due() {
                self.publish_film(side, progress.film, &world, &options);
            }
            self.report(progress.film.samples(), Activity::Refining);
            if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let now = film.samples();
        if now >= goal && (compared || now >= full.samples) && result.is_ok() {
            self.publish_film(side, &film, &world, &options);
        }
        self.films[side as usize] = Some(film);
        result?;
        let is_done =
            |&side: &Side| samples(self, side) >= full.samples && !self.lacks_guides(side);
        if sides.iter().all(is_done) {
            self.phase = Phase::Done;
            self.told = None;
            self.report(samples(self, Side::Chosen), Activity::Done);
        }
        Ok(())
    }

    /// Makes a film in the memory of one before: a hand that moves and rests for hours interrupts
    /// thousands of pictures.
    fn new_film(&mut self, side: Side, options: &Options) -> Result<Film, RenderError> {
        match self.spare[side as usize].take() {
            Some(film) => film.restart(options),
            None => Film::for_options(options),
        }
    }

    /// Ends the films in progress, and keeps the memory of those that are needed again.
    pub(super) fn spare_films(&mut self) {
        for (film, spare) in self.films.iter_mut().zip(&mut self.spare) {
            if film.is_some() {
                *spare = film.take();
            }
        }
        let sides = self.sides().len();
        self.spare[sides..].fill(None);
    }

    /// Returns true if rendering must stop. Questions about a point are answered on the way.
    fn is_interrupted(&self, world: &World<'_>, interrupted: &dyn Fn(&Shared) -> bool) -> bool {
        if let Some(at) = self.shared.take_inspection() {
            self.answer(world, at);
        }
        interrupted(&self.shared)
    }

    /// Returns true if a new picture of the film may be shown.
    fn is_due(&self) -> bool {
        self.published.is_none_or(|(when, cost)| {
            let mut pause = (cost + self.shared.encoding()) * PUBLISH_COST;
            if self.settings.denoise {
                pause += self.shared.denoising() * DENOISE_COST;
            }
            let rarer = (self.progress_time() / RARER).min(RAREST);
            when.elapsed() >= PUBLISH.max(pause).max(rarer)
        })
    }

    /// Returns how long the films have been refined.
    fn progress_time(&self) -> Duration {
        self.progress.iter().map(|progress| progress.time).sum()
    }

    /// Whether a side is to be denoised and cannot be yet.
    pub(super) fn lacks_guides(&self, side: Side) -> bool {
        self.settings.denoise && self.guides[side as usize].is_none()
    }

    /// Publishes a film of what `world` is configured for.
    fn publish_film(&mut self, side: Side, film: &Film, world: &World<'_>, options: &Options) {
        if self.lacks_guides(side) {
            let guides = guides(world, options).unwrap_or_else(|error| {
                self.problem(format_args!("the picture cannot be denoised: {error}"));
                Guides::default()
            });
            self.guides[side as usize] = Some(Arc::new(guides));
        }
        let start = Instant::now();
        let image = self.buffers.develop(film);
        if side == Side::Chosen {
            self.fireflies = film.fireflies();
            self.estimate_noise(&image, film.samples());
        }
        self.publish(side, image, film.samples(), false);
        self.published = Some((Instant::now(), start.elapsed()));
    }

    /// Estimates the noise from how much a picture has changed since it had about half the samples.
    fn estimate_noise(&mut self, image: &Arc<Image>, samples: u32) {
        if let Some((earlier, fewer)) = &self.earlier {
            if samples < 2 * fewer {
                return;
            }
            // The mean of n samples differs from that of the first m by the error of the former
            // times the root of n / m - 1, if samples are independent.
            let (mut square, mut sum) = (0.0, 0.0);
            for (now, then) in image.pixels.iter().zip(&earlier.pixels) {
                let (now, then) = (f64::from(luminance(*now)), f64::from(luminance(*then)));
                square += (now - then) * (now - then);
                sum += now;
            }
            let count = image.pixels.len() as f64;
            let ratio = f64::from(samples) / f64::from(*fewer) - 1.0;
            let error = (square / count / ratio).sqrt();
            self.noise = Some(error / (sum / count)).filter(|noise| noise.is_finite());
        }
        self.earlier = Some((Arc::clone(image), samples));
    }

    fn publish(&self, side: Side, image: Arc<Image>, samples: u32, preview: bool) {
        let header = FrameHeader {
            id: 0,
            epoch: self.epoch,
            side,
            input: self.input,
            width: image.width,
            height: image.height,
            samples,
            preview,
            denoised: false,
            media: "image/png",
        };
        let (version, settings) = (self.version, self.settings.clone());
        let guides = if preview { None } else { self.guides_of(side) };
        self.shared.keep(Kept { image, header, version, settings, guides });
        self.publisher.add(&self.shared, side);
    }

    /// Returns the guides of a side if it is to be denoised.
    fn guides_of(&self, side: Side) -> Option<Arc<Guides>> {
        self.guides[side as usize].clone().filter(|_| self.settings.denoise)
    }

    /// Shows the last pictures in the colours of other settings.
    pub(super) fn show_again(&self) {
        for &side in self.sides() {
            let Some(mut kept) = self.shared.kept(side) else { continue };
            kept.header.epoch = self.epoch;
            kept.settings = self.settings.clone();
            kept.guides = if kept.header.preview { None } else { self.guides_of(side) };
            self.shared.keep(kept);
            self.publisher.add(&self.shared, side);
            self.publisher.repeat(&self.shared, side);
        }
    }

    /// Tells how far the picture is, a few times a second.
    fn report(&mut self, samples: u32, activity: Activity) {
        let pause = PUBLISH.max(self.progress_time() / RARER_REPORTS).min(REPORT);
        if self.told.is_some_and(|told| told.elapsed() < pause) {
            return;
        }
        self.told = Some(Instant::now());
        let rays: u64 = self.progress.iter().map(|progress| progress.rays).sum();
        let seconds = self.progress_time().as_secs_f64();
        self.shared.outbox.post(Event::Status(Status {
            epoch: self.epoch,
            activity,
            samples,
            wanted: self.settings.samples,
            rays_per_second: rays as f64 / seconds.max(1e-9),
            seconds,
            noise: self.noise,
            fireflies: self.fireflies,
        }));
    }
}
