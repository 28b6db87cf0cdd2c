//! What a client and the engine share: what waits for either, and the last pictures.

use crate::bell::Bell;
use crate::denoise::{Denoised, Guides};
use crate::message::{FrameHeader, Request};
use crate::outbox::Outbox;
use crate::settings::Settings;
use crate::side::Side;
use rotund_image::Image;
use rotund_scene::Camera;
use rotund_trace::{Film, Layers, Options, output};
use std::collections::VecDeque;
use std::mem;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A film that a client sees, with what made it.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The film.
    pub film: Film,
    /// The options of the render.
    pub options: Options,
    /// The camera.
    pub camera: Camera,
    /// The settings, for the methods and the overlap.
    pub settings: Settings,
    /// Which picture of a comparison it is.
    pub side: Side,
    /// Seconds that the film took.
    pub seconds: f64,
    /// Rays that were traced for it.
    pub rays: u64,
}

/// A reason why a picture cannot be saved.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages describe variants and fields")]
#[non_exhaustive]
pub enum SaveError {
    #[error("there is no picture yet")]
    Nothing,
    #[error("the picture is a preview; it can be saved once it is refined")]
    Preview,
    #[error("the picture is not denoised yet")]
    Noisy,
    #[error("the viewer has ended")]
    Ended,
    #[error("{problem}")]
    Render { problem: String },
    #[error(transparent)]
    Encode(#[from] rotund_image::EncodeError),
    #[error(transparent)]
    Layers(#[from] output::LayersError),
}

/// A question to the engine.
#[derive(Debug)]
pub(crate) enum Ask {
    Request(Request),
    Snapshots(Sender<Result<Vec<Snapshot>, SaveError>>),
    Layers(Sender<Result<Layers, SaveError>>),
}

/// The last picture of a side.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    pub(crate) image: Arc<Image>,
    pub(crate) header: FrameHeader,
    /// Number of the change since which the picture is of this camera and these settings.
    pub(crate) version: u64,
    pub(crate) settings: Settings,
    /// Present if the picture is to be denoised.
    pub(crate) guides: Option<Arc<Guides>>,
}

/// What client and engine share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) outbox: Outbox,
    inbox: Mutex<VecDeque<Ask>>,
    kept: Mutex<[Option<Kept>; 2]>,
    /// The last denoised picture of each side.
    denoised: Mutex<[Option<Denoised>; 2]>,
    closed: AtomicBool,
    /// Microseconds that the last picture took to be encoded.
    encoding: AtomicU64,
    bell: Arc<Bell>,
}

/// The most requests that wait; when more come, movements are dropped.
const MOST_REQUESTS: usize = 4096;

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    pub(crate) fn new(bell: Arc<Bell>) -> Self {
        Self {
            outbox: Outbox::default(),
            inbox: Mutex::default(),
            kept: Mutex::default(),
            denoised: Mutex::default(),
            closed: AtomicBool::new(false),
            encoding: AtomicU64::new(0),
            bell,
        }
    }

    pub(crate) fn kept(&self, side: Side) -> Option<Kept> {
        lock(&self.kept)[side as usize].clone()
    }

    pub(crate) fn keep(&self, kept: Kept) {
        let side = kept.header.side as usize;
        lock(&self.kept)[side] = Some(kept);
    }

    /// Returns the denoised picture of what the last picture of a side shows; it may have fewer
    /// samples.
    pub(crate) fn denoised(&self, kept: &Kept) -> Option<Denoised> {
        let side = kept.header.side as usize;
        let denoised = lock(&self.denoised)[side].clone();
        denoised.filter(|it| it.version == kept.version && kept.guides.is_some())
    }

    pub(crate) fn keep_denoised(&self, side: Side, denoised: Denoised) {
        lock(&self.denoised)[side as usize] = Some(denoised);
    }

    /// Returns how long it took to denoise the last pictures of both sides, if they are shown.
    pub(crate) fn denoising(&self) -> Duration {
        let kept = lock(&self.kept).clone();
        kept.iter().flatten().filter_map(|kept| Some(self.denoised(kept)?.time)).sum()
    }

    /// Returns how long it took to encode the last picture.
    pub(crate) fn encoding(&self) -> Duration {
        Duration::from_micros(self.encoding.load(Ordering::Relaxed))
    }

    pub(crate) fn set_encoding(&self, time: Duration) {
        self.encoding.store(time.as_micros() as u64, Ordering::Relaxed);
    }

    /// Returns true once the client has gone.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Relaxed)
    }

    /// Returns what waits, in order.
    pub(crate) fn take_asks(&self) -> VecDeque<Ask> {
        mem::take(&mut *lock(&self.inbox))
    }

    /// Returns true if something waits that cannot be answered while rendering goes on.
    pub(crate) fn wants_attention(&self) -> bool {
        self.is_closed() || !lock(&self.inbox).is_empty()
    }

    /// Takes out the last question about a point, if nothing but such questions and answers to
    /// frames waits.
    pub(crate) fn take_inspection(&self) -> Option<[f32; 2]> {
        let mut inbox = lock(&self.inbox);
        let mut last = None;
        for ask in &*inbox {
            match ask {
                Ask::Request(Request::Inspect { at }) => last = Some(*at),
                _ => return None,
            }
        }
        inbox.clear();
        last
    }

    /// Ends the session: nothing waits any more, and whoever waits for an answer gets none.
    pub(crate) fn close(&self) {
        let mut inbox = lock(&self.inbox);
        self.closed.store(true, Ordering::Relaxed);
        inbox.clear();
        drop(inbox);
        self.outbox.close();
    }

    /// Ends the session, and tells the engine.
    pub(crate) fn leave(&self) {
        self.close();
        self.bell.ring();
    }

    /// Passes a question to the engine.
    pub(crate) fn ask(&self, ask: Ask) {
        let mut inbox = lock(&self.inbox);
        if inbox.len() < MOST_REQUESTS && !self.is_closed() {
            inbox.push_back(ask);
        }
        drop(inbox);
        self.bell.ring();
    }
}
