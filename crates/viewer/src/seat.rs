//! The engine's side of one client: camera, settings, and the pictures in progress.

use crate::inspect::{inspect, ray};
use crate::message::{
    Activity, CameraText, Event, FrameHeader, Motion, Request, Side, State, Status,
};
use crate::place::Place;
use crate::publisher::Publisher;
use crate::rig::Rig;
use crate::session::{Ask, Kept, SaveError, Shared, Snapshot};
use crate::{LONGEST_SIDE, Settings};
use glam::Vec3;
use rotund_image::{Image, luminance};
use rotund_scene::Camera;
use rotund_trace::{Film, Layers, Options, RenderError, World};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time that a preview may take.
const PREVIEW: Duration = Duration::from_millis(25);
/// Time after a movement during which another is awaited before the picture is refined, which
/// takes longer to interrupt.
const PAUSE: Duration = Duration::from_millis(80);
/// Pixels of the smallest preview.
const FEWEST_PIXELS: f64 = 48.0 * 32.0;
/// Factor of the number of pixels from one preview to the next while the camera rests.
const STEP: f64 = 4.0;
/// Least time between two pictures of a refinement.
const PUBLISH: Duration = Duration::from_millis(200);
/// Time between two pictures, in times that it takes to make one from the film.
const PUBLISH_COST: u32 = 20;
/// Time of a slice if both sides of a comparison, or several clients, take turns.
const TURN: Duration = Duration::from_millis(300);

/// How far the picture of a client is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// The next picture is a preview of this many pixels.
    Preview(f64),
    /// Samples are added at full size.
    Refine,
    /// All samples are there.
    Done,
}

/// What a film at full size has taken.
#[derive(Clone, Copy, Debug, Default)]
struct Progress {
    rays: u64,
    time: Duration,
}

impl Progress {
    fn and(self, rays: u64, time: Duration) -> Self {
        Self { rays: self.rays + rays, time: self.time + time }
    }
}

/// The engine's side of one client.
pub(crate) struct Seat {
    pub(crate) shared: Arc<Shared>,
    publisher: Arc<Publisher>,
    /// `None` until there is a scene, or a camera that a client brings.
    rig: Option<Rig>,
    settings: Settings,
    asked: (u32, u32),
    keep_aspect: bool,
    /// Number of the state; movements do not change it.
    epoch: u64,
    /// Number of the change, movements included.
    version: u64,
    input: u64,
    /// The last movement, unless the hand has let go since.
    moved: Option<Instant>,
    phase: Phase,
    /// Samples per second of previews.
    speed: f64,
    films: [Option<Film>; 2],
    published: Option<(Instant, Duration)>,
    told: Option<Instant>,
    progress: [Progress; 2],
    fireflies: u64,
    /// An earlier picture of the first film, and its samples.
    earlier: Option<(Image, u32)>,
    noise: Option<f64>,
}

impl Seat {
    pub(crate) fn new(shared: Arc<Shared>, publisher: Arc<Publisher>) -> Self {
        Self {
            shared,
            publisher,
            rig: None,
            settings: Settings::default(),
            asked: (0, 0),
            keep_aspect: false,
            epoch: 0,
            version: 0,
            input: 0,
            moved: None,
            phase: Phase::Done,
            speed: 2e5,
            films: [None, None],
            published: None,
            told: None,
            progress: [Progress::default(); 2],
            fireflies: 0,
            earlier: None,
            noise: None,
        }
    }

    /// Returns the moment from which on there is something to do, `now` or later; `None` if there is
    /// nothing.
    pub(crate) fn ready_at(&self, now: Instant) -> Option<Instant> {
        if self.rig.is_none() || self.asked.0 == 0 || self.phase == Phase::Done {
            return None;
        }
        Some(match (self.phase, self.moved) {
            // The first preview after a movement is due at once.
            (Phase::Preview(pixels), _) if pixels <= 0.0 => now,
            (_, Some(moved)) => now.max(moved + PAUSE),
            _ => now,
        })
    }

    fn sides(&self) -> &'static [Side] {
        if self.settings.wipe { &Side::ALL } else { &Side::ALL[..1] }
    }

    /// Takes note of a scene that has been loaded: the picture starts anew, with the camera as it
    /// was, or the first one of the scene.
    pub(crate) fn scene_changed(&mut self, place: &Place) {
        let camera = self.rig.take().map_or_else(|| place.cameras()[0].clone(), |rig| rig.camera);
        self.take_camera(Some(place), camera);
        self.jump(Some(place));
    }

    fn take_camera(&mut self, place: Option<&Place>, camera: Camera) {
        // Without a scene the eye stands for the point that is looked at, until there is one.
        let eye = camera.world_from_camera.translation.into();
        let pivot = place.map_or(eye, |place| place.pivot(&camera));
        self.rig = Some(Rig::new(camera, pivot));
    }

    /// Starts another picture, of which frames of before say nothing.
    fn jump(&mut self, place: Option<&Place>) {
        self.epoch += 1;
        self.fit_aspect();
        self.restart(place);
    }

    /// Starts another picture.
    fn restart(&mut self, place: Option<&Place>) {
        self.version += 1;
        self.films = [None, None];
        self.progress = [Progress::default(); 2];
        self.earlier = None;
        self.noise = None;
        self.published = None;
        self.phase = Phase::Preview(0.0);
        self.post_state(place);
    }

    /// Gives the camera the aspect of the picture, unless that of the camera is kept.
    fn fit_aspect(&mut self) {
        let (width, height) = self.asked;
        if let Some(rig) = self.rig.as_mut().filter(|_| !self.keep_aspect && width > 0) {
            rig.camera.aspect = width as f32 / height as f32;
        }
    }

    /// Returns width and height of the full picture.
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.asked;
        match &self.rig {
            Some(rig) if self.keep_aspect => rig.camera.resolution(width.max(height)),
            _ => self.asked,
        }
    }

    fn post_state(&self, place: Option<&Place>) {
        let (Some(rig), Some(place)) = (&self.rig, place) else { return };
        let (width, height) = self.size();
        self.shared.outbox.post(Event::State(Box::new(State {
            epoch: self.epoch,
            scene: place.name.clone(),
            warnings: place.warnings.clone(),
            cameras: place.cameras().iter().map(|camera| camera.name.clone()).collect(),
            elements: place.elements,
            camera: CameraText::from(&rig.camera),
            width,
            height,
            settings: self.settings.clone(),
        })));
    }

    fn problem(&self, text: impl ToString) {
        self.shared.outbox.post(Event::Problem { text: text.to_string() });
    }

    /// Does what a client asks for. Size, settings and camera are kept if there is no scene yet;
    /// other requests have no meaning then.
    pub(crate) fn handle(&mut self, ask: Ask, place: Option<&mut Place>) {
        // A receiver that has gone needs no answer.
        match (ask, place) {
            (Ask::Snapshots(reply), _) => drop(reply.send(self.snapshots())),
            (Ask::Layers(reply), None) => drop(reply.send(Err(SaveError::Nothing))),
            (Ask::Layers(reply), Some(place)) => drop(reply.send(self.layers(place))),
            (Ask::Request(request), place) => self.handle_request(request, place),
        }
    }

    fn handle_request(&mut self, request: Request, place: Option<&mut Place>) {
        match (request, place) {
            (Request::Size { width, height, keep_aspect }, place) => {
                self.set_size(width, height, keep_aspect, place.as_deref());
            }
            (Request::Settings { settings }, place) => {
                self.set_settings(settings, place.as_deref());
            }
            (Request::Camera { camera }, place) => {
                let camera = Camera::from(&camera);
                match camera.validate() {
                    Err(error) => self.problem(format_args!("the camera is refused: {error}")),
                    Ok(()) => {
                        self.take_camera(place.as_deref(), camera);
                        self.jump(place.as_deref());
                    }
                }
            }
            (Request::Release, _) => self.moved = None,
            (Request::Inspect { at }, Some(place)) => {
                if self.configure(place, Side::Chosen).is_ok() {
                    self.answer(&place.world(), at);
                }
            }
            (request, Some(place)) => self.steer(request, place),
            (_, None) => {}
        }
    }

    fn set_size(&mut self, width: u32, height: u32, keep_aspect: bool, place: Option<&Place>) {
        if width == 0 || height == 0 {
            return self.problem("a picture has at least one pixel in each direction");
        }
        let longest = width.max(height);
        let mut size = (width, height);
        if longest > LONGEST_SIDE {
            let reduced = |side: u32| {
                let side = u64::from(side) * u64::from(LONGEST_SIDE) / u64::from(longest);
                (side as u32).max(1)
            };
            size = (reduced(width), reduced(height));
            self.problem(format_args!(
                "a picture of {width} x {height} pixels is reduced to {} x {}; `rotund render` \
                 makes larger ones",
                size.0, size.1
            ));
        }
        if (size, keep_aspect) != (self.asked, self.keep_aspect) {
            (self.asked, self.keep_aspect) = (size, keep_aspect);
            self.jump(place);
        }
    }

    fn set_settings(&mut self, settings: Settings, place: Option<&Place>) {
        if let Err(error) = settings.validate() {
            return self.problem(format_args!("the settings are refused: {error}"));
        }
        let before = std::mem::replace(&mut self.settings, settings);
        let settings = &self.settings;
        if before == *settings {
            return;
        }
        let more = Settings { samples: settings.samples, ..before.clone() };
        if more == *settings && self.films[0].is_some() {
            // The samples of a film do not depend on how many there will be.
            self.phase = Phase::Refine;
            self.post_state(place);
        } else if before.same_light(settings) && self.films[0].is_some() {
            self.epoch += 1;
            self.post_state(place);
            self.show_again();
        } else {
            self.jump(place);
        }
    }

    /// Moves the camera.
    fn steer(&mut self, request: Request, place: &mut Place) {
        if self.configure(place, Side::Chosen).is_err() {
            return;
        }
        let Some(rig) = &mut self.rig else { return };
        let pick = |camera: &Camera, at: [f32; 2]| {
            place.world().closest(&ray(camera, at)).map(|hit| hit.position)
        };
        match request {
            Request::Grab { at } => {
                rig.pivot = pick(&rig.camera, at).unwrap_or_else(|| rig.below(at));
                return;
            }
            Request::Move(motion) => {
                if !is_finite(&motion) {
                    return self.problem("a movement is not a finite number");
                }
                let target = motion.at.filter(|_| motion.zoom != 0.0);
                let target = target.and_then(|at| pick(&rig.camera, at));
                let before = rig.clone();
                rig.apply(&motion, target);
                if rig.camera.validate().is_err() || !rig.pivot.is_finite() {
                    // Beyond the range of numbers: the camera stays.
                    *rig = before;
                }
                self.input = motion.input;
                self.moved = Some(Instant::now());
                return self.restart(Some(place));
            }
            Request::Focus { at } => {
                let Some(target) = pick(&rig.camera, at) else { return };
                rig.focus(target);
            }
            Request::FrameAll => {
                let (center, radius) = place.extent();
                rig.frame(center, radius);
            }
            Request::SceneCamera { index } => match place.cameras().get(index).cloned() {
                Some(camera) => self.take_camera(Some(place), camera),
                None => return self.problem(format_args!("there is no camera {index}")),
            },
            _ => return,
        }
        self.jump(Some(place));
    }

    /// Tells what is at a point of the picture of a world that is configured for the client.
    fn answer(&self, world: &World<'_>, at: [f32; 2]) {
        let Some(rig) = &self.rig else { return };
        let kept = self.shared.kept(Side::Chosen);
        let image = kept.as_ref().filter(|kept| kept.version == self.version).map(|it| &*it.image);
        let inspection = inspect(world, &rig.camera, self.size(), at, image);
        self.shared.outbox.post(Event::Inspection(Box::new(inspection)));
    }

    /// Makes the scene what one side shows.
    fn configure(&self, place: &mut Place, side: Side) -> Result<(), RenderError> {
        let camera = self.rig.as_ref().map(|rig| &rig.camera);
        Ok(camera.map_or(Ok(()), |camera| place.configure(camera, &self.settings, side))?)
    }

    fn options(&self) -> Options {
        let (width, height) = self.size();
        // The settings have been validated.
        self.settings.options(width, height).unwrap_or_default()
    }

    fn snapshots(&self) -> Result<Vec<Snapshot>, SaveError> {
        let rig = self.rig.as_ref().ok_or(SaveError::Nothing)?;
        let snapshot = |&side: &Side| {
            let Progress { rays, time } = self.progress[side as usize];
            let film = self.films[side as usize].clone().filter(|film| film.samples() > 0);
            Ok(Snapshot {
                film: film.ok_or(SaveError::Preview)?,
                options: self.options(),
                camera: rig.camera.clone(),
                settings: self.settings.clone(),
                side,
                seconds: time.as_secs_f64(),
                rays,
            })
        };
        self.sides().iter().map(snapshot).collect()
    }

    fn layers(&self, place: &mut Place) -> Result<Layers, SaveError> {
        let render = |error: RenderError| SaveError::Render { problem: error.to_string() };
        self.configure(place, Side::Chosen).map_err(render)?;
        place.world().layers(place.seat_camera(), &self.options()).map_err(render)
    }

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
            let mut film = Film::for_options(&small)?;
            world.resume(&mut film, place.seat_camera(), &small, &mut |_| {
                let stop = !first && self.is_interrupted(&world, interrupted);
                if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })?;
            if film.samples() == 0 {
                return Ok(());
            }
            images.push((side, film.image()));
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
        let side = sides.iter().copied().min_by_key(|&side| samples(self, side));
        let side = side.unwrap_or(Side::Chosen);
        let compared = sides.len() > 1;
        // Both sides of a comparison keep step, so that they are equally noisy.
        let doubled = (2 * samples(self, side)).clamp(1, full.samples);
        let goal = if compared { doubled } else { full.samples };
        let mut film = match self.films[side as usize].take() {
            Some(film) => film,
            None => Film::for_options(&full)?,
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
                self.publish_film(side, progress.film);
            }
            self.report(progress.film.samples(), Activity::Refining);
            if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let now = film.samples();
        if now >= goal && (compared || now >= full.samples) && result.is_ok() {
            self.publish_film(side, &film);
        }
        self.films[side as usize] = Some(film);
        result?;
        if sides.iter().all(|&side| samples(self, side) >= full.samples) {
            self.phase = Phase::Done;
            self.told = None;
            self.report(samples(self, Side::Chosen), Activity::Done);
        }
        Ok(())
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
        self.published.is_none_or(|(when, cost)| when.elapsed() >= PUBLISH.max(cost * PUBLISH_COST))
    }

    fn publish_film(&mut self, side: Side, film: &Film) {
        let start = Instant::now();
        let image = film.image();
        if side == Side::Chosen {
            self.fireflies = film.fireflies();
            self.estimate_noise(&image, film.samples());
        }
        self.publish(side, image, film.samples(), false);
        self.published = Some((Instant::now(), start.elapsed()));
    }

    /// Estimates the noise from how much a picture has changed since it had about half the samples.
    fn estimate_noise(&mut self, image: &Image, samples: u32) {
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
        self.earlier = Some((image.clone(), samples));
    }

    fn publish(&self, side: Side, image: Image, samples: u32, preview: bool) {
        let header = FrameHeader {
            id: 0,
            epoch: self.epoch,
            side,
            input: self.input,
            width: image.width,
            height: image.height,
            samples,
            preview,
            media: "image/png",
        };
        let (image, version, settings) = (Arc::new(image), self.version, self.settings.clone());
        self.shared.keep(Kept { image, header, version, settings });
        self.publisher.add(&self.shared, side);
    }

    /// Shows the last pictures in the colours of other settings.
    fn show_again(&self) {
        for &side in self.sides() {
            let Some(mut kept) = self.shared.kept(side) else { continue };
            kept.header.epoch = self.epoch;
            kept.settings = self.settings.clone();
            self.shared.keep(kept);
            self.publisher.add(&self.shared, side);
        }
    }

    /// Tells how far the picture is, a few times a second.
    fn report(&mut self, samples: u32, activity: Activity) {
        if self.told.is_some_and(|told| told.elapsed() < PUBLISH) {
            return;
        }
        self.told = Some(Instant::now());
        let [a, b] = self.progress;
        let Progress { rays, time } = a.and(b.rays, b.time);
        let seconds = time.as_secs_f64();
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

fn is_finite(motion: &Motion) -> bool {
    let Motion { input: _, orbit, pan, zoom, at, look, fly } = motion;
    let pairs = [*orbit, *pan, *look, at.unwrap_or_default()];
    pairs.as_flattened().iter().chain(fly).chain([zoom]).all(|x| x.is_finite())
        && Vec3::from(*fly).abs().max_element() < 1e6
}
