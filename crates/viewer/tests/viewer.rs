//! A viewer seen by a client: what it asks for, and what it gets.

mod support;

use rotund_image::{Format, encode};
use rotund_scene::{Camera, ElementKind, Environment, Material, Method, Scene, Shape};
use rotund_trace::{Options, World};
use rotund_viewer::{
    Activity, CameraText, Content, Event, Frame, Motion, Output, Request, Session, Settings, Side,
    State, Viewer,
};
use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use support::{PATIENCE, wait_for};

const SIZE: (u32, u32) = (90, 60);

/// Two balls, a line and a bent quad under a sky, seen by two cameras.
fn scene() -> Scene {
    let at = |x: f32, y: f32, z: f32| glam::Vec3::new(x, y, z);
    let cameras = vec![
        Camera {
            name: "front".into(),
            ..Camera::look_at(at(0.0, 1.0, 6.0), at(0.0, 0.5, 0.0), at(0.0, 1.0, 0.0))
        },
        Camera {
            name: "side".into(),
            ..Camera::look_at(at(6.0, 1.0, 0.0), at(0.0, 0.5, 0.0), at(0.0, 1.0, 0.0))
        },
    ];
    let mut scene = Scene { cameras, ..Scene::default() };
    scene.environments.push(Environment {
        name: "sky".into(),
        world_from_environment: Default::default(),
        emission: [0.6, 0.8, 1.0].into(),
        emission_tex: None,
    });
    let red = Material { color: at(0.8, 0.2, 0.1), ..Material::default() };
    scene.add(Shape::points([at(-1.0, 0.5, 0.0), at(0.3, 0.4, 0.5)], 0.5), red);
    scene.add(
        Shape::lines([at(-1.5, 1.2, 0.0), at(1.5, 1.6, 0.0)], [0.3, 0.1], [[0, 1]]),
        Material::default(),
    );
    let corners = [at(-2.0, 0.0, -2.0), at(2.0, 0.6, -2.0), at(2.0, 0.0, 2.0), at(-2.0, 0.3, 2.0)];
    scene.add(Shape::quads(corners, [[0, 1, 2, 3]]), Material::default());
    scene
}

fn content() -> Content {
    Content { name: "balls".into(), scene: scene(), warnings: vec![], files: vec![] }
}

fn open() -> Viewer {
    let viewer = Viewer::open(|| Ok(content()));
    viewer.loaded().expect("a valid scene");
    viewer
}

/// Connects a client that has a size and takes few samples.
fn connect(viewer: &Viewer) -> Session {
    let session = viewer.connect();
    session.request(Request::Size { width: SIZE.0, height: SIZE.1, keep_aspect: false });
    session.request(Request::Settings { settings: few() });
    session
}

fn few() -> Settings {
    Settings { samples: 8, bounces: 3, ..Settings::default() }
}

fn wait_for_event<T>(
    session: &Session,
    what: &str,
    mut wanted: impl FnMut(&Event) -> Option<T>,
) -> T {
    wait_for(session, what, |output| match output {
        Output::Event(event) => wanted(event),
        Output::Frame(_) => None,
    })
}

fn wait_for_state(session: &Session, wanted: impl Fn(&State) -> bool) -> State {
    wait_for_event(session, "state", |event| match event {
        Event::State(state) if wanted(state) => Some((**state).clone()),
        _ => None,
    })
}

/// Returns the finished picture of a side.
fn wait_for_finished(session: &Session, side: Side, epoch: u64) -> Frame {
    wait_for(session, "finished picture", |output| match output {
        Output::Frame(frame)
            if frame.header.side == side
                && frame.header.epoch >= epoch
                && !frame.header.preview
                && frame.header.samples == few().samples =>
        {
            Some(frame.clone())
        }
        _ => None,
    })
}

fn wait_for_problem(session: &Session) -> String {
    wait_for_event(session, "problem", |event| match event {
        Event::Problem { text } => Some(text.clone()),
        _ => None,
    })
}

/// Returns the PNG that a render without a viewer makes.
fn rendered(camera: &Camera, methods: [Method; 3]) -> Vec<u8> {
    let mut scene = scene();
    let kinds = [ElementKind::Points, ElementKind::Lines, ElementKind::Quads];
    for (kind, method) in kinds.into_iter().zip(methods) {
        scene.set_method(kind, method);
    }
    scene.cameras = vec![camera.clone()];
    let options =
        Options { width: SIZE.0, height: SIZE.1, samples: 8, bounces: 3, ..Options::default() };
    let film = World::new(&scene).expect("valid").render(0, &options).expect("a picture");
    encode(&film.image(), Format::Png).expect("a PNG")
}

use Method::{Enhanced, Vanilla};

#[test]
fn the_picture_at_rest_is_that_of_a_render_to_the_bit() {
    let viewer = open();
    let session = connect(&viewer);
    let state = wait_for_state(&session, |state| state.settings == few());
    let frame = wait_for_finished(&session, Side::Chosen, state.epoch);
    assert_eq!(frame.header.media, "image/png");
    assert_eq!(frame.bytes, rendered(&Camera::from(&state.camera), [Enhanced; 3]));
    assert_eq!(frame.bytes, session.png().expect("a picture"), "what is saved is what is shown");
}

#[test]
fn boxes_switch_methods_and_the_wipe_shows_vanilla_beside() {
    let viewer = open();
    let session = connect(&viewer);
    let settings = Settings { points: false, wipe: true, ..few() };
    session.request(Request::Settings { settings: settings.clone() });
    let state = wait_for_state(&session, |state| state.settings == settings);
    let (mut chosen, mut vanilla) = (None, None);
    wait_for(&session, "both sides", |output| {
        if let Output::Frame(frame) = output {
            let header = frame.header;
            assert!(header.epoch >= state.epoch || header.samples < 8, "an old picture as new");
            if !header.preview && header.samples == 8 && header.epoch == state.epoch {
                let side = if header.side == Side::Chosen { &mut chosen } else { &mut vanilla };
                *side = Some(frame.bytes.clone());
            }
        }
        (chosen.is_some() && vanilla.is_some()).then_some(())
    });
    let camera = Camera::from(&state.camera);
    assert_eq!(chosen, Some(rendered(&camera, [Vanilla, Enhanced, Enhanced])));
    assert_eq!(vanilla, Some(rendered(&camera, [Vanilla; 3])));
    let snapshots = session.snapshots().expect("both films");
    assert_eq!(
        snapshots.iter().map(|it| it.side).collect::<Vec<_>>(),
        [Side::Chosen, Side::Vanilla]
    );
}

#[test]
fn a_movement_is_shown_by_a_preview_that_names_it() {
    let viewer = open();
    let session = connect(&viewer);
    let state = wait_for_state(&session, |state| state.settings == few());
    wait_for_finished(&session, Side::Chosen, state.epoch);
    session.request(Request::Grab { at: [0.5, 0.5] });
    for input in 1..=5 {
        session.request(Request::Move(Motion { input, orbit: [0.05, 0.0], ..Motion::default() }));
    }
    let (mut preview, mut moved) = (None, None);
    let (preview, moved) = wait_for(&session, "preview and state", |output| {
        match output {
            Output::Frame(frame) if frame.header.input == 5 => {
                preview = preview.or(Some(frame.header));
            }
            Output::Event(Event::State(state)) => moved = Some((**state).clone()),
            _ => {}
        }
        preview.zip(moved.clone())
    });
    assert!(preview.preview && preview.samples == 1, "{preview:?}");
    assert_eq!(moved.epoch, state.epoch, "a movement shows the same thing");
    session.request(Request::Release {});
    let frame = wait_for(&session, "finished picture", |output| match output {
        Output::Frame(frame) if frame.header.samples == 8 && frame.header.input == 5 => {
            Some(frame.clone())
        }
        _ => None,
    });
    assert_eq!(frame.bytes, rendered(&Camera::from(&moved.camera), [Enhanced; 3]));
}

#[test]
fn once_the_samples_are_there_nothing_more_comes() {
    let viewer = open();
    let session = connect(&viewer);
    wait_for_event(&session, "end", |event| match event {
        Event::Status(status) if status.activity == Activity::Done => {
            assert_eq!((status.samples, status.wanted), (8, 8));
            assert!(status.noise.is_some_and(|noise| noise > 0.0 && noise < 1.0), "{status:?}");
            assert!(status.rays_per_second > 0.0 && status.seconds > 0.0);
            Some(())
        }
        _ => None,
    });
    while let Some(output) = session.next(Duration::from_millis(100)) {
        if let Output::Frame(frame) = output {
            assert_eq!(frame.header.samples, 8, "the last picture");
            session.request(Request::Shown { frame: frame.header.id });
        }
    }
    assert!(session.next(Duration::from_millis(500)).is_none());
}

#[test]
fn more_samples_go_on_where_the_picture_is_and_exposure_renders_nothing() {
    let viewer = open();
    let session = connect(&viewer);
    let state = wait_for_state(&session, |state| state.settings == few());
    let before = wait_for_finished(&session, Side::Chosen, state.epoch);
    let bright = Settings { exposure: 1.0, ..few() };
    session.request(Request::Settings { settings: bright.clone() });
    let state = wait_for_state(&session, |state| state.settings == bright);
    let frame = wait_for(&session, "brighter picture", |output| match output {
        Output::Frame(frame) if frame.header.epoch == state.epoch => Some(frame.clone()),
        _ => None,
    });
    assert_eq!(frame.header.samples, 8, "the same samples in other colours");
    assert_ne!(frame.bytes, before.bytes);
    let more = Settings { samples: 16, ..bright };
    session.request(Request::Settings { settings: more });
    wait_for(&session, "refined picture", |output| match output {
        Output::Frame(frame) => {
            assert!(frame.header.samples >= 8 && !frame.header.preview, "{:?}", frame.header);
            (frame.header.samples == 16).then_some(())
        }
        Output::Event(_) => None,
    });
}

#[test]
fn an_inspection_names_what_is_there_with_its_error_bound() {
    let viewer = open();
    let session = connect(&viewer);
    let state = wait_for_state(&session, |state| state.settings == few());
    wait_for_finished(&session, Side::Chosen, state.epoch);
    // The ball on the left.
    let camera = Camera::from(&state.camera);
    let to_ball = camera.world_from_camera.inverse().transform_point3([-1.0, 0.5, 0.0].into());
    let film = glam::Vec2::new(camera.film, camera.film / camera.aspect);
    let on_film = to_ball.truncate() * (camera.lens / -to_ball.z) / film;
    let at = [0.5 + on_film.x, 0.5 - on_film.y];
    session.request(Request::Inspect { at });
    let found = wait_for_event(&session, "inspection", |event| match event {
        Event::Inspection(inspection) => Some((**inspection).clone()),
        _ => None,
    });
    let hit = found.hit.expect("the ball");
    assert_eq!((hit.kind, hit.element, hit.method), ("points", 0, "enhanced"));
    assert!(hit.error > 0.0 && hit.error < 1e-5, "{hit:?}");
    let radius = (glam::Vec3::from(hit.position) - glam::Vec3::new(-1.0, 0.5, 0.0)).length();
    assert!((radius - 0.5).abs() <= hit.error, "{radius}");
    assert!(found.value.is_some_and(|[r, _, b, a]| r > b && a == 1.0), "{:?}", found.value);
    session.request(Request::Inspect { at: [0.0, 0.0] });
    let sky = wait_for_event(&session, "inspection", |event| match event {
        Event::Inspection(inspection) => Some(inspection.hit.clone()),
        _ => None,
    });
    assert_eq!(sky, None);
}

#[test]
fn what_has_no_meaning_is_refused_in_one_sentence_and_changes_nothing() {
    let viewer = open();
    let session = connect(&viewer);
    let state = wait_for_state(&session, |state| state.settings == few());
    let nan = |index: usize| {
        let mut camera = state.camera.clone();
        camera.frame[index] = f32::NAN;
        Request::Camera { camera }
    };
    let motion = |orbit, zoom| Request::Move(Motion { orbit, zoom, ..Motion::default() });
    let settings = |settings| Request::Settings { settings };
    let table = [
        (nan(0), "the camera is refused: "),
        (nan(11), "the camera is refused: "),
        (
            Request::Camera { camera: CameraText { lens: -1.0, ..CameraText::default() } },
            "the camera is refused: ",
        ),
        (Request::SceneCamera { index: 2 }, "there is no camera 2"),
        (Request::Size { width: 0, height: 9, keep_aspect: false }, "a picture has at least one"),
        (motion([f32::NAN, 0.0], 0.0), "a movement is not a finite number"),
        (motion([0.0, 0.0], f32::INFINITY), "a movement is not a finite number"),
        (
            settings(Settings { view: "normals".into(), ..few() }),
            "the settings are refused: there is no view",
        ),
        (
            settings(Settings { samples: 0, ..few() }),
            "the settings are refused: option `samples` is 0",
        ),
        (
            settings(Settings { samples: u32::MAX, ..few() }),
            "the settings are refused: samples are",
        ),
        (
            settings(Settings { clamp: Some(-1.0), ..few() }),
            "the settings are refused: option `clamp`",
        ),
        (
            settings(Settings { exposure: f32::NAN, ..few() }),
            "the settings are refused: the exposure",
        ),
    ];
    for (request, expected) in table {
        let text = format!("{request:?}");
        session.request(request);
        let problem = wait_for_problem(&session);
        assert!(problem.starts_with(expected), "{text}: {problem}");
    }
    session.request(Request::Size { width: 20_000, height: 10_000, keep_aspect: false });
    let problem = wait_for_problem(&session);
    assert!(problem.contains("reduced to 3840 x 1920"), "{problem}");
}

#[test]
fn two_clients_have_a_camera_each() {
    let viewer = open();
    let (one, two) = (connect(&viewer), connect(&viewer));
    two.request(Request::SceneCamera { index: 1 });
    let side = wait_for_state(&two, |state| state.camera.name == "side");
    let frame = wait_for_finished(&two, Side::Chosen, side.epoch);
    assert_eq!(frame.bytes, rendered(&Camera::from(&side.camera), [Enhanced; 3]));
    let front = wait_for_state(&one, |state| state.settings == few());
    assert_eq!(front.camera.name, "front");
    let frame = wait_for_finished(&one, Side::Chosen, front.epoch);
    assert_eq!(frame.bytes, rendered(&Camera::from(&front.camera), [Enhanced; 3]));
}

#[test]
fn a_new_client_does_not_wait_until_all_others_have_had_their_turn() {
    let viewer = open();
    let many: Vec<Session> = (0..12).map(|_| viewer.connect()).collect();
    for session in &many {
        session.request(Request::Size { width: 300, height: 200, keep_aspect: false });
        session.request(Request::Settings { settings: Settings { samples: 100_000, ..few() } });
    }
    wait_for_event(&many[11], "refinement", |event| match event {
        Event::Status(status) => (status.activity == Activity::Refining).then_some(()),
        _ => None,
    });
    let start = Instant::now();
    let session = connect(&viewer);
    wait_for(&session, "picture", |output| matches!(output, Output::Frame(_)).then_some(()));
    // A turn of each takes 0.3 s.
    assert!(start.elapsed() < Duration::from_millis(1800), "it takes {:?}", start.elapsed());
}

#[test]
fn an_upright_picture_shows_all_that_a_camera_of_the_scene_frames() {
    let viewer = open();
    let session = viewer.connect();
    let camera_at = |width, height| {
        session.request(Request::Size { width, height, keep_aspect: false });
        wait_for_state(&session, |state| state.width == width).camera
    };
    let lens = Camera::default().lens;
    let upright = camera_at(30, 60);
    assert_eq!((upright.aspect, upright.lens), (0.5, lens / 2.0), "1.5 times as wide as high");
    let turned = camera_at(60, 30);
    let widened = lens / (2.0 / 1.5);
    assert_eq!((turned.aspect, turned.lens), (2.0, widened), "the phone is turned");
    let own = CameraText { lens, ..turned };
    session.request(Request::Camera { camera: own.clone() });
    wait_for_state(&session, |state| state.camera == own);
    assert_eq!(camera_at(30, 60).lens, lens, "the camera is the client's now");
    camera_at(60, 30);
    session.request(Request::SceneCamera { index: 1 });
    let side = wait_for_state(&session, |state| state.camera.name == "side").camera;
    assert_eq!((side.aspect, side.lens), (2.0, widened), "wider than the scene's");
    session.request(Request::Move(Motion { orbit: [0.1, 0.0], ..Motion::default() }));
    session.request(Request::Release {});
    wait_for_state(&session, |state| state.camera.frame != side.frame);
    assert_eq!(camera_at(30, 60).lens, widened, "a hand has moved it");
}

#[test]
fn a_changed_file_is_loaded_again_and_a_broken_one_keeps_the_picture() {
    let path: PathBuf = std::env::temp_dir().join(format!("rotund-viewer-{}", std::process::id()));
    fs::write(&path, "0.5").expect("written");
    let loads = Arc::new(Mutex::new(0));
    let (file, counted) = (path.clone(), Arc::clone(&loads));
    let viewer = Viewer::open(move || {
        *counted.lock().expect("no panic") += 1;
        let text =
            fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let radius: f32 = text.parse().map_err(|_| format!("{text:?} is no radius"))?;
        let mut content = content();
        content.scene.shapes[0].radii.fill(radius);
        content.files = vec![file.clone()];
        Ok(content)
    });
    viewer.loaded().expect("a valid scene");
    let session = connect(&viewer);
    session.request(Request::SceneCamera { index: 1 });
    let before = wait_for_state(&session, |state| state.camera.name == "side");
    wait_for_finished(&session, Side::Chosen, before.epoch);
    fs::write(&path, "broken").expect("written");
    assert_eq!(wait_for_problem(&session), "\"broken\" is no radius");
    assert!(session.png().is_ok(), "the last good picture");
    fs::write(&path, "0.25").expect("written");
    wait_for_event(&session, "end of the problem", |event| {
        matches!(event, Event::Solved).then_some(())
    });
    fs::remove_file(&path).expect("removed");
    assert!(wait_for_problem(&session).contains("rotund-viewer"));
    assert_eq!(*loads.lock().expect("no panic"), 4);
    drop(session);
    let late = connect(&viewer);
    assert!(wait_for_problem(&late).contains("rotund-viewer"), "who comes later is told too");
}

#[test]
fn a_scene_that_cannot_be_loaded_is_an_error_of_the_first_loading() {
    let viewer = Viewer::open(|| Err("there is no such scene".to_owned()));
    assert_eq!(viewer.loaded(), Err("there is no such scene".to_owned()));
    let session = connect(&viewer);
    assert_eq!(wait_for_problem(&session), "there is no such scene");
}

#[test]
fn a_scene_that_is_mended_after_the_first_loading_failed_is_shown() {
    let path = std::env::temp_dir().join(format!("rotund-viewer-mended-{}", std::process::id()));
    fs::write(&path, "broken").expect("written");
    let file = path.clone();
    let viewer = Viewer::open_with(vec![path.clone()], None, move || {
        match fs::read_to_string(&file).expect("a file").as_str() {
            "broken" => Err("the scene is broken".to_owned()),
            _ => Ok(content()),
        }
    });
    assert!(viewer.loaded().is_err());
    let session = connect(&viewer);
    assert_eq!(wait_for_problem(&session), "the scene is broken");
    fs::write(&path, "mended").expect("written");
    let state = wait_for_state(&session, |state| state.scene == "balls");
    assert_eq!(state.settings, few(), "what was asked for before there was a scene");
    wait_for_finished(&session, Side::Chosen, state.epoch);
    fs::remove_file(&path).expect("removed");
}

#[test]
fn the_end_of_the_viewer_ends_its_sessions() {
    let viewer = open();
    let session = connect(&viewer);
    wait_for_state(&session, |_| true);
    drop(viewer);
    let end = Instant::now() + PATIENCE;
    while session.next(Duration::from_millis(50)).is_some() {
        assert!(Instant::now() < end);
    }
    assert!(session.snapshots().is_err());
}
