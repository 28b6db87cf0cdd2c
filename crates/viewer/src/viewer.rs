//! The viewer: a scene, and threads that load it and render it for all clients in turn.

use crate::engine::Engine;
use crate::place::Place;
use crate::session::{Session, Shared};
use crate::watch::Watch;
use rotund_scene::Scene;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

/// Time between two looks at the files of the scene.
const LOOK: Duration = Duration::from_millis(300);

/// A loaded scene.
#[derive(Debug)]
pub struct Content {
    /// Name of the scene.
    pub name: String,
    /// The scene, which has at least one camera.
    pub scene: Scene,
    /// Warnings of the loader.
    pub warnings: Vec<String>,
    /// Files that the scene was read from, which are watched for changes.
    pub files: Vec<PathBuf>,
}

/// What clients, loader and engine tell each other.
#[derive(Debug, Default)]
pub(crate) struct Bell {
    board: Mutex<Board>,
    rung: Condvar,
}

/// What is new for the engine.
#[derive(Debug, Default)]
pub(crate) struct Board {
    /// Something is new.
    pub(crate) rung: bool,
    /// The viewer ends.
    pub(crate) ended: bool,
    /// A client has come.
    pub(crate) arrived: Vec<Arc<Shared>>,
    /// What is being loaded, since when.
    pub(crate) loading: Option<(&'static str, Instant)>,
    /// The end of loading.
    pub(crate) loaded: Option<Result<Box<Place>, String>>,
    /// The result of the first loading, for [`Viewer::loaded`].
    first: Option<Result<(), String>>,
}

impl Bell {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Board> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells the engine that something is new.
    pub(crate) fn ring(&self) {
        self.lock().rung = true;
        self.rung.notify_all();
    }

    /// Waits until something is new, at most this long if there is a limit.
    pub(crate) fn wait(&self, limit: Option<Duration>) {
        let board = self.lock();
        let quiet = |board: &mut Board| !board.rung && !board.ended;
        let mut board = match limit {
            None => self.rung.wait_while(board, quiet).unwrap_or_else(PoisonError::into_inner),
            Some(limit) => {
                let wait = self.rung.wait_timeout_while(board, limit, quiet);
                wait.unwrap_or_else(PoisonError::into_inner).0
            }
        };
        board.rung = false;
    }

    fn set_loading(&self, what: Option<&'static str>) {
        self.lock().loading = what.map(|what| (what, Instant::now()));
        self.ring();
    }
}

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
    bell: Arc<Bell>,
}

impl Viewer {
    /// Starts to load and to render, on threads of its own and those of the global rayon pool.
    ///
    /// `load` is called again when one of the files of the content changes, until it succeeds; its
    /// error is one sentence for people. Clients keep their cameras, and the picture that they have
    /// until the new one is there.
    #[must_use]
    pub fn open(load: impl FnMut() -> Result<Content, String> + Send + 'static) -> Self {
        Self::open_watching(Vec::new(), load)
    }

    /// Does the same, and watches `files` until the scene has been loaded once: if it cannot be, it
    /// is tried again when one of them changes. Afterwards the files of the content are watched.
    #[must_use]
    pub fn open_watching(
        files: Vec<PathBuf>,
        load: impl FnMut() -> Result<Content, String> + Send + 'static,
    ) -> Self {
        let bell = Arc::new(Bell::default());
        bell.set_loading(Some("reading the scene"));
        let engine = Engine::new(Arc::clone(&bell));
        thread::spawn(move || engine.run());
        let own = Arc::clone(&bell);
        thread::spawn(move || load_and_watch(&own, files, load));
        Self { bell }
    }

    /// Waits until the scene has been loaded for the first time, or could not be.
    ///
    /// # Errors
    ///
    /// The error of the loader, or that of a scene that is not valid.
    pub fn loaded(&self) -> Result<(), String> {
        let board = self.bell.lock();
        let waits = |board: &mut Board| board.first.is_none() && !board.ended;
        let board = self.bell.rung.wait_while(board, waits);
        let board = board.unwrap_or_else(PoisonError::into_inner);
        board.first.clone().unwrap_or_else(|| Err("the viewer has ended".to_owned()))
    }

    /// Adds a client. It gets pictures once it has said how large they should be.
    #[must_use]
    pub fn connect(&self) -> Session {
        let shared = Arc::new(Shared::new(Arc::clone(&self.bell)));
        self.bell.lock().arrived.push(Arc::clone(&shared));
        self.bell.ring();
        Session::new(shared)
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.bell.lock().ended = true;
        self.bell.ring();
    }
}

/// Loads the scene, and again after changes of its files, until the viewer ends.
fn load_and_watch(
    bell: &Bell,
    files: Vec<PathBuf>,
    mut load: impl FnMut() -> Result<Content, String>,
) {
    let mut watch = Watch::new(files, SystemTime::now());
    loop {
        let start = SystemTime::now();
        let result = load().and_then(|content| {
            watch = Watch::new(content.files.clone(), start);
            bell.set_loading(Some("building the trees"));
            Place::new(content).map(Box::new).map_err(|error| error.to_string())
        });
        let told = result.as_ref().map(drop).map_err(String::clone);
        let mut board = bell.lock();
        board.loading = None;
        board.first.get_or_insert(told);
        board.loaded = Some(result);
        drop(board);
        bell.ring();
        while !watch.has_settled_change() {
            if bell.lock().ended {
                return;
            }
            thread::sleep(LOOK);
        }
        watch.accept();
        bell.set_loading(Some("reading the scene again"));
    }
}
