//! Pictures without noise: beside the plain ones, never instead of them, and without delay.

mod support;

use rotund_image::{Format, Image, decode};
use rotund_scene::{Camera, Environment, Material, Scene, Shape};
use rotund_viewer::{
    Content, Denoise, Event, Frame, Guides, Motion, Output, Request, Session, Settings, Viewer,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use support::wait_for;

const SIZE: (u32, u32) = (60, 40);

/// Makes every picture green, after a while.
#[derive(Debug, Default)]
struct Green {
    pause: Duration,
    calls: AtomicUsize,
}

impl Denoise for Green {
    fn denoise(&self, noisy: &Image, guides: &Arc<Guides>) -> Result<Image, String> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        assert_eq!(guides.albedo.len(), noisy.pixels.len());
        assert_eq!(guides.normal.len(), noisy.pixels.len());
        std::thread::sleep(self.pause);
        Ok(Image::from_fn(noisy.width, noisy.height, |_, _| [0.0, 1.0, 0.0, 1.0]))
    }
}

fn content() -> Content {
    let mut scene = Scene::default();
    scene.cameras.push(Camera::default());
    scene.environments.push(Environment {
        name: "sky".into(),
        world_from_environment: Default::default(),
        emission: [0.6, 0.8, 1.0].into(),
        emission_tex: None,
    });
    scene.add(Shape::points([[0.0, 0.0, -5.0].into()], 1.0), Material::default());
    Content { name: "ball".into(), scene, warnings: vec![], files: vec![] }
}

fn open(denoiser: Option<Arc<Green>>) -> (Viewer, Session) {
    let denoiser = denoiser.map(|it| it as Arc<dyn Denoise>);
    let viewer = Viewer::open_with(vec![], denoiser, || Ok(content()));
    viewer.loaded().expect("a valid scene");
    let session = viewer.connect();
    session.request(Request::Size { width: SIZE.0, height: SIZE.1, keep_aspect: false });
    (viewer, session)
}

fn few(denoise: bool) -> Settings {
    Settings { samples: 4, denoise, ..Settings::default() }
}

fn frame(session: &Session, what: &str, wanted: impl Fn(&Frame) -> bool) -> Frame {
    wait_for(session, what, |output| match output {
        Output::Frame(frame) if wanted(frame) => Some(frame.clone()),
        _ => None,
    })
}

fn is_green(bytes: &[u8]) -> bool {
    let image = Image::from(decode(bytes, Format::Png).expect("a PNG"));
    image.srgb_bytes().iter().all(|pixel| *pixel == [0, 255, 0, 255])
}

#[test]
fn the_denoised_picture_is_shown_and_the_plain_one_is_kept() {
    let green = Arc::new(Green::default());
    let (_viewer, session) = open(Some(Arc::clone(&green)));
    session.request(Request::Settings { settings: few(false) });
    let plain = frame(&session, "plain picture", |it| it.header.samples == 4);
    assert!(!plain.header.denoised && !is_green(&plain.bytes));
    assert!(session.denoised_png().is_err(), "there is none");
    session.request(Request::Settings { settings: few(true) });
    let shown = frame(&session, "denoised picture", |it| it.header.denoised);
    assert_eq!((shown.header.samples, shown.header.preview), (4, false));
    assert!(is_green(&shown.bytes));
    assert_eq!(session.png().expect("a picture"), plain.bytes, "the plain one is saved as such");
    assert_eq!(session.denoised_png().expect("a picture"), shown.bytes);
    // Neither colours nor the way back need the denoiser again.
    let calls = green.calls.load(Ordering::Relaxed);
    session.request(Request::Settings { settings: Settings { filmic: true, ..few(true) } });
    frame(&session, "other colours", |it| it.header.denoised && it.bytes != shown.bytes);
    session.request(Request::Settings { settings: few(false) });
    let back = frame(&session, "plain picture again", |it| !it.header.denoised);
    assert_eq!(back.bytes, plain.bytes);
    session.request(Request::Settings { settings: few(true) });
    frame(&session, "denoised picture again", |it| it.header.denoised);
    assert_eq!(green.calls.load(Ordering::Relaxed), calls, "it was denoised before");
}

#[test]
fn both_sides_of_a_comparison_are_denoised() {
    let (_viewer, session) = open(Some(Arc::default()));
    session.request(Request::Settings { settings: Settings { wipe: true, ..few(false) } });
    frame(&session, "plain picture", |it| it.header.side as usize == 1 && it.header.samples == 4);
    session.request(Request::Settings { settings: Settings { wipe: true, ..few(true) } });
    let mut seen = [false; 2];
    frame_until(&session, |it| {
        seen[it.header.side as usize] |= it.header.denoised && it.header.samples == 4;
        seen == [true; 2]
    });
}

fn frame_until(session: &Session, mut wanted: impl FnMut(&Frame) -> bool) {
    wait_for(session, "frames", |output| match output {
        Output::Frame(frame) => wanted(frame).then_some(()),
        Output::Event(_) => None,
    });
}

#[test]
fn a_hand_does_not_wait_for_the_denoiser() {
    let pause = Duration::from_secs(3);
    let green = Arc::new(Green { pause, ..Green::default() });
    let (_viewer, session) = open(Some(Arc::clone(&green)));
    session.request(Request::Settings { settings: few(true) });
    wait_for(&session, "call", |_| (green.calls.load(Ordering::Relaxed) > 0).then_some(()));
    let start = Instant::now();
    let orbit = Motion { input: 7, orbit: [0.2, 0.1], ..Motion::default() };
    session.request(Request::Move(orbit));
    frame(&session, "picture from elsewhere", |it| it.header.input == 7);
    assert!(start.elapsed() < pause / 2, "it takes {:?}", start.elapsed());
    // What was being denoised shows another place.
    let late = frame(&session, "denoised picture", |it| it.header.denoised);
    assert_eq!(late.header.input, 7);
}

#[test]
fn without_a_denoiser_the_picture_stays_as_it_is_and_the_other_settings_hold() {
    let (_viewer, session) = open(None);
    session.request(Request::Settings { settings: Settings { seed: 5, ..few(true) } });
    let problem = wait_for(&session, "problem", |output| match output {
        Output::Event(Event::Problem { text }) => Some(text.clone()),
        _ => None,
    });
    assert!(problem.contains("noise"), "{problem}");
    let shown = frame(&session, "picture", |it| it.header.samples == 4);
    assert!(!shown.header.denoised);
    let snapshots = session.snapshots().expect("a film");
    assert_eq!(snapshots[0].settings, Settings { seed: 5, ..few(false) });
}
