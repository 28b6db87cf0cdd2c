//! What all requests share.

use super::guard::Guard;
use axum::body::Body;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use rotund_viewer::{Session, Viewer};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Pages that are open at once.
const MOST_SESSIONS: usize = 16;

/// What all requests share.
#[derive(Debug)]
pub(super) struct Server {
    pub(super) guard: Guard,
    pub(super) viewer: Viewer,
    /// Name of the scene.
    pub(super) scene: String,
    /// The command line of a render of the same scene, without camera and settings.
    pub(super) render: String,
    /// Whether the scene is the file of a shape by itself.
    pub(super) is_lone: bool,
    /// Why noise cannot be removed, if it cannot.
    pub(super) without_denoiser: Option<String>,
    pub(super) sessions: Sessions,
}

/// The open sockets by their numbers, which never come again.
#[derive(Debug, Default)]
pub(super) struct Sessions(Mutex<(u64, BTreeMap<u64, Arc<Session>>)>);

impl Sessions {
    fn with<T>(&self, work: impl FnOnce(&mut (u64, BTreeMap<u64, Arc<Session>>)) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Adds a session, unless there are too many.
    pub(super) fn add(&self, viewer: &Viewer) -> Option<(u64, Arc<Session>)> {
        self.with(|(last, open)| {
            if open.len() >= MOST_SESSIONS {
                return None;
            }
            *last += 1;
            let session = Arc::new(viewer.connect());
            open.insert(*last, Arc::clone(&session));
            Some((*last, session))
        })
    }

    /// Forgets a session, which ends its work.
    pub(super) fn remove(&self, number: u64) {
        let session = self.with(|(_, open)| open.remove(&number));
        drop(session);
    }

    /// Returns the session of an open socket.
    pub(super) fn find(&self, number: u64) -> Option<Arc<Session>> {
        self.with(|(_, open)| open.get(&number).cloned())
    }
}

/// Returns an answer of one sentence.
pub(super) fn plain(status: StatusCode, sentence: impl Into<Body>) -> Response {
    let media = HeaderValue::from_static("text/plain; charset=utf-8");
    (status, [(header::CONTENT_TYPE, media)], sentence.into()).into_response()
}
