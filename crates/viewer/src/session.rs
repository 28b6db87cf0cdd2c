//! One client of a viewer.

use crate::develop::{Tone, encoded};
use crate::message::{Output, Request};
use crate::shared::{Ask, SaveError, Shared, Snapshot};
use crate::side::Side;
use rotund_trace::output;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

/// A client of a viewer, with its own camera and settings. Dropping it ends its work.
#[derive(Debug)]
pub struct Session {
    shared: Arc<Shared>,
}

impl Session {
    pub(crate) fn new(shared: Arc<Shared>) -> Self {
        Self { shared }
    }

    /// Passes on a request. Never waits for rendering.
    pub fn request(&self, request: Request) {
        if matches!(request, Request::Shown { .. }) {
            self.shared.outbox.shown(&request);
        } else {
            self.shared.ask(Ask::Request(request));
        }
    }

    /// Waits for the next message or picture, at most this long; `None` if none comes, or if the
    /// viewer has ended.
    ///
    /// Only the latest picture, state and status are kept, so a client that does not ask uses no
    /// more memory. At most two frames are given out before [`Request::Shown`] answers the first,
    /// so pictures do not queue up on the way either.
    #[must_use]
    pub fn next(&self, timeout: Duration) -> Option<Output> {
        self.shared.outbox.next(timeout)
    }

    /// Returns the picture that is shown, as the bytes of a PNG: of the last frame of
    /// [`Side::Chosen`], in the same colours, with its noise.
    ///
    /// # Errors
    ///
    /// If there is no picture yet.
    pub fn png(&self) -> Result<Vec<u8>, SaveError> {
        let kept = self.shared.kept(Side::Chosen).ok_or(SaveError::Nothing)?;
        let image = Tone::of(&kept.settings).apply(&kept.image);
        Ok(encoded(&image, true)?.0)
    }

    /// Returns the picture that is shown without its noise, as the bytes of a PNG.
    ///
    /// # Errors
    ///
    /// If there is none yet.
    pub fn denoised_png(&self) -> Result<Vec<u8>, SaveError> {
        let kept = self.shared.kept(Side::Chosen).ok_or(SaveError::Nothing)?;
        let denoised = self.shared.denoised(&kept).ok_or(SaveError::Noisy)?;
        let image = Tone::of(&kept.settings).apply(&denoised.image);
        Ok(encoded(&image, true)?.0)
    }

    /// Returns the picture that is shown as linear radiance with its layers, as the bytes of an
    /// EXR; see [`output::encode_layers`]. Exposure and tone curve are left out.
    ///
    /// # Errors
    ///
    /// If there is only a preview yet, or layers do not fit into memory.
    pub fn exr(&self) -> Result<Vec<u8>, SaveError> {
        let kept = self.shared.kept(Side::Chosen).ok_or(SaveError::Nothing)?;
        if kept.header.preview {
            return Err(SaveError::Preview);
        }
        let (reply, answer) = channel();
        self.shared.ask(Ask::Layers(reply));
        let layers = answer.recv().map_err(|_| SaveError::Ended)??;
        Ok(output::encode_layers(&kept.image, &layers)?)
    }

    /// Returns the films that are shown: that of [`Side::Chosen`], and that of [`Side::Vanilla`] if
    /// they are compared.
    ///
    /// # Errors
    ///
    /// If there are only previews yet.
    pub fn snapshots(&self) -> Result<Vec<Snapshot>, SaveError> {
        let (reply, answer) = channel();
        self.shared.ask(Ask::Snapshots(reply));
        answer.recv().map_err(|_| SaveError::Ended)?
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.leave();
    }
}
