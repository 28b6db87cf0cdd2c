//! The engine's side of one client: camera, settings, and the pictures in progress.

use crate::buffers::Buffers;
use crate::denoise::Guides;
use crate::inspect::{inspect, ray};
use crate::message::{CameraText, Event, Inspection, Motion, Request, State};
use crate::place::Place;
use crate::publisher::Publisher;
use crate::rig::Rig;
use crate::settings::{LONGEST_SIDE, Settings};
use crate::shared::{Ask, SaveError, Shared, Snapshot};
use crate::side::Side;
use glam::Vec3;
use rotund_image::Image;
use rotund_scene::Camera;
use rotund_trace::{Film, Layers, Options, RenderError, World};
use std::sync::Arc;
use std::time::{Duration, Instant};

mod render;

/// Time after a movement during which another is awaited before the picture is refined, which
/// takes longer to interrupt.
const PAUSE: Duration = Duration::from_millis(80);
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
    /// The camera of the scene that is shown, as it was made for a picture of another aspect;
    /// `None` once a client has changed it.
    scene_camera: Option<Camera>,
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
    /// Present for sides that have been denoised.
    guides: [Option<Arc<Guides>>; 2],
    /// Films of before, for their memory.
    spare: [Option<Film>; 2],
    buffers: Buffers,
    published: Option<(Instant, Duration)>,
    told: Option<Instant>,
    progress: [Progress; 2],
    fireflies: u64,
    /// An earlier picture of the first film, and its samples.
    earlier: Option<(Arc<Image>, u32)>,
    noise: Option<f64>,
}

impl Seat {
    pub(crate) fn new(shared: Arc<Shared>, publisher: Arc<Publisher>) -> Self {
        Self {
            shared,
            publisher,
            rig: None,
            scene_camera: None,
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
            guides: [None, None],
            spare: [None, None],
            buffers: Buffers::default(),
            published: None,
            told: None,
            progress: [Progress::default(); 2],
            fireflies: 0,
            earlier: None,
            noise: None,
        }
    }

    /// Returns the moment from which on there is something to do, not before `now`; `None` if there
    /// is nothing.
    pub(crate) fn ready_at(&self, now: Instant) -> Option<Instant> {
        if self.rig.is_none() || self.asked.0 == 0 || self.phase == Phase::Done {
            return None;
        }
        Some(match self.moved {
            // The first preview after a movement is due at once.
            Some(moved) if !self.waits_for_picture() => now.max(moved + PAUSE),
            _ => now,
        })
    }

    /// Whether nothing shows the last change yet.
    pub(crate) fn waits_for_picture(&self) -> bool {
        matches!(self.phase, Phase::Preview(pixels) if pixels <= 0.0)
    }

    fn sides(&self) -> &'static [Side] {
        if self.settings.wipe { &Side::ALL } else { &Side::ALL[..1] }
    }

    /// Takes note of a scene that has been loaded: the picture starts anew, with the camera as it
    /// was, or the first one of the scene.
    pub(crate) fn scene_changed(&mut self, place: &Place) {
        match self.rig.take() {
            Some(own) => {
                let scene_camera = self.scene_camera.take();
                self.take_camera(Some(place), own.camera);
                self.scene_camera = scene_camera;
            }
            None => self.take_scene_camera(place, place.cameras()[0].clone()),
        }
        self.jump(Some(place));
    }

    fn take_camera(&mut self, place: Option<&Place>, camera: Camera) {
        // Without a scene the eye stands for the point that is looked at, until there is one.
        let eye = camera.world_from_camera.translation.into();
        let pivot = place.map_or(eye, |place| place.pivot(&camera));
        self.rig = Some(Rig::new(camera, pivot));
        self.scene_camera = None;
    }

    fn take_scene_camera(&mut self, place: &Place, camera: Camera) {
        self.take_camera(Some(place), camera.clone());
        self.scene_camera = Some(camera);
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
        self.guides = [None, None];
        self.spare_films();
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
        let Some(rig) = self.rig.as_mut().filter(|_| width > 0) else { return };
        if let Some(camera) = &self.scene_camera {
            rig.camera = camera.clone();
        }
        if !self.keep_aspect {
            let aspect = width as f32 / height as f32;
            if self.scene_camera.is_some() {
                rig.widen_to(aspect);
            }
            rig.camera.aspect = aspect;
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
                    Err(error) => {
                        // It is a camera by itself, and not the first of a scene.
                        let error = error.to_string().replacen("cameras[0]: ", "", 1);
                        self.problem(format_args!("the camera is refused: {error}"));
                    }
                    Ok(()) => {
                        self.take_camera(place.as_deref(), camera);
                        self.jump(place.as_deref());
                    }
                }
            }
            (Request::Release {}, _) => self.moved = None,
            (Request::Inspect { at }, Some(place)) => {
                if self.configure(place, Side::Chosen).is_ok() {
                    self.answer(&place.world(), at);
                }
            }
            (Request::Inspect { at }, None) => {
                // Whoever asks waits for an answer.
                let nothing = Inspection { at, pixel: [0, 0], value: None, hit: None };
                self.shared.outbox.post(Event::Inspection(Box::new(nothing)));
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
            // The memory of a large picture is not kept for a small one.
            (self.films, self.spare) = ([None, None], [None, None]);
            self.buffers = Buffers::default();
            self.jump(place);
        }
    }

    fn set_settings(&mut self, mut settings: Settings, place: Option<&Place>) {
        if let Err(error) = settings.validate() {
            return self.problem(format_args!("the settings are refused: {error}"));
        }
        if settings.denoise && !self.publisher.can_denoise() {
            // A link may come from a machine where it can.
            settings.denoise = false;
            self.problem("this viewer cannot remove noise: the picture is shown as it is");
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
            if self.sides().iter().any(|&side| self.lacks_guides(side)) {
                self.phase = Phase::Refine;
                self.published = None;
            }
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
                self.scene_camera = None;
                self.input = motion.input;
                self.moved = Some(Instant::now());
                return self.restart(Some(place));
            }
            Request::Focus { at } => {
                let Some(target) = pick(&rig.camera, at) else { return };
                rig.focus(target);
                self.scene_camera = None;
            }
            Request::FrameAll {} => {
                let (center, radius) = place.extent();
                rig.frame(center, radius);
                self.scene_camera = None;
            }
            Request::SceneCamera { index } => match place.cameras().get(index).cloned() {
                Some(camera) => {
                    self.take_scene_camera(place, camera);
                }
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
}

fn is_finite(motion: &Motion) -> bool {
    let Motion { input: _, orbit, pan, zoom, at, look, fly } = motion;
    let pairs = [*orbit, *pan, *look, at.unwrap_or_default()];
    pairs.as_flattened().iter().chain(fly).chain([zoom]).all(|x| x.is_finite())
        && Vec3::from(*fly).abs().max_element() < 1e6
}
