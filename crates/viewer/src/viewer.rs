//! The viewer: a scene, and threads that load it and render it for all clients in turn.

use crate::board::Board;
use crate::content::Content;
use crate::denoise::Denoise;
use crate::engine::Engine;
use crate::place::Place;
use crate::session::Session;
use crate::shared::Shared;
use crate::watch::Watch;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, SystemTime};

/// Time between two looks at the files of the scene.
const LOOK: Duration = Duration::from_millis(300);

/// A viewer of a scene. Dropping it ends its threads and all its clients.
///
/// ```
/// use rotund_viewer::{Content, Event, Output, Request, Viewer};
/// use rotund_scene::{Camera, Material, Scene, Shape};
/// use std::time::Duration;
///
/// let viewer = Viewer::open(|| {
///     let mut scene = Scene::default();
///     scene.cameras.push(Camera::default());
///     scene.add(Shape::points([[0.0, 0.0, -5.0].into()], 1.0), Material::default());
///     Ok(Content { name: "ball".into(), scene, warnings: vec![], files: vec![] })
/// });
/// viewer.loaded()?;
/// let session = viewer.connect();
/// session.request(Request::Size { width: 60, height: 40, keep_aspect: false });
/// let picture = loop {
///     match session.next(Duration::from_secs(60)).expect("a picture") {
///         Output::Frame(frame) if !frame.header.preview => break frame,
///         _ => {}
///     }
/// };
/// assert_eq!((picture.header.width, picture.header.media), (60, "image/png"));
/// # Ok::<(), String>(())
/// ```
#[derive(Debug)]
pub struct Viewer {
    board: Arc<Board>,
}

impl Viewer {
    /// Starts to load and to render, on threads of its own and those of the global rayon pool.
    ///
    /// `load` is called again when one of the files of the content changes, until it succeeds; its
    /// error is one sentence for people. Clients keep their cameras, and the picture that they have
    /// until the new one is there.
    #[must_use]
    pub fn open(load: impl FnMut() -> Result<Content, String> + Send + 'static) -> Self {
        Self::open_with(Vec::new(), None, load)
    }

    /// Does the same, and watches `files` until the scene has been loaded once: if it cannot be, it
    /// is tried again when one of them changes. Afterwards the files of the content are watched.
    ///
    /// With a `denoiser`, clients may set [`crate::Settings::denoise`].
    #[must_use]
    pub fn open_with(
        files: Vec<PathBuf>,
        denoiser: Option<Arc<dyn Denoise>>,
        load: impl FnMut() -> Result<Content, String> + Send + 'static,
    ) -> Self {
        let board = Arc::new(Board::default());
        board.set_loading("reading the scene");
        let engine = Engine::new(Arc::clone(&board), denoiser);
        thread::spawn(move || engine.run());
        let own = Arc::clone(&board);
        thread::spawn(move || load_and_watch(&own, files, load));
        Self { board }
    }

    /// Waits until the scene has been loaded for the first time, or could not be.
    ///
    /// # Errors
    ///
    /// The error of the loader, or that of a scene that is not valid.
    pub fn loaded(&self) -> Result<(), String> {
        self.board.first()
    }

    /// Adds a client. It gets pictures once it has said how large they should be.
    #[must_use]
    pub fn connect(&self) -> Session {
        let shared = Arc::new(Shared::new(Arc::clone(&self.board.bell)));
        self.board.news().arrived.push(Arc::clone(&shared));
        self.board.bell.ring();
        Session::new(shared)
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.board.end();
    }
}

/// Loads the scene, and again after changes of its files, until the viewer ends.
fn load_and_watch(
    board: &Board,
    files: Vec<PathBuf>,
    mut load: impl FnMut() -> Result<Content, String>,
) {
    let mut watch = Watch::new(files, SystemTime::now());
    loop {
        let start = SystemTime::now();
        let result = load().and_then(|content| {
            watch = Watch::new(content.files.clone(), start);
            board.set_loading("building the trees");
            Place::new(content).map(Box::new).map_err(|error| error.to_string())
        });
        board.set_loaded(result);
        while !watch.has_settled_change() {
            if board.news().ended {
                return;
            }
            thread::sleep(LOOK);
        }
        watch.accept();
        board.set_loading("reading the scene again");
    }
}
