//! The threads that turn images into the bytes of frames, while the next are rendered.
//!
//! Noise is removed by a thread of its own, since that takes long: frames of another camera do not
//! wait for it.

use crate::denoise::{Denoise, Denoised};
use crate::develop::{Tone, encoded};
use crate::message::Event;
use crate::queue::Queue;
use crate::shared::{Kept, Shared};
use crate::side::Side;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

/// What waits to be encoded and to be denoised.
#[derive(Debug)]
pub(crate) struct Publisher {
    frames: Queue,
    noisy: Queue,
    denoiser: Option<Arc<dyn Denoise>>,
}

impl Publisher {
    /// Starts the threads, which end by [`Self::end`].
    pub(crate) fn start(denoiser: Option<Arc<dyn Denoise>>) -> Arc<Self> {
        let (frames, noisy) = (Queue::default(), Queue::default());
        let publisher = Arc::new(Self { frames, noisy, denoiser });
        let own = Arc::clone(&publisher);
        thread::spawn(move || {
            while let Some((shared, side)) = own.frames.next() {
                publish(&shared, side);
            }
        });
        if let Some(denoiser) = publisher.denoiser.clone() {
            let own = Arc::clone(&publisher);
            thread::spawn(move || {
                while let Some((shared, side)) = own.noisy.next() {
                    if denoise(&*denoiser, &shared, side) {
                        own.frames.add(&shared, side);
                    }
                }
            });
        }
        publisher
    }

    /// Whether noise can be removed.
    pub(crate) fn can_denoise(&self) -> bool {
        self.denoiser.is_some()
    }

    /// Asks for the last picture of a side to be sent.
    pub(crate) fn add(&self, shared: &Arc<Shared>, side: Side) {
        let Some(kept) = shared.kept(side) else { return };
        let denoised = shared.denoised(&kept);
        let is_noisy = denoised.as_ref().is_none_or(|it| it.samples < kept.header.samples);
        if kept.guides.is_some() && is_noisy {
            self.noisy.add(shared, side);
        }
        // Until there is a denoised picture the plain one is shown.
        if denoised.is_none_or(|it| it.samples == kept.header.samples) {
            self.frames.add(shared, side);
        }
    }

    /// Asks for the last frame of a side to be sent again, in other colours.
    pub(crate) fn repeat(&self, shared: &Arc<Shared>, side: Side) {
        self.frames.add(shared, side);
    }

    pub(crate) fn end(&self) {
        self.frames.end();
        self.noisy.end();
    }
}

/// Removes the noise of the last picture of a side; returns true if it is still the last one's.
fn denoise(denoiser: &dyn Denoise, shared: &Shared, side: Side) -> bool {
    let Some(kept) = shared.kept(side) else { return false };
    let Kept { image, version, guides: Some(guides), .. } = kept else { return false };
    let start = Instant::now();
    match denoiser.denoise(&image, &guides) {
        Ok(image) => {
            let (image, time) = (Arc::new(image), start.elapsed());
            let samples = kept.header.samples;
            shared.keep_denoised(side, Denoised { image, version, samples, time });
            shared.kept(side).is_some_and(|kept| kept.version == version)
        }
        Err(text) => {
            shared.outbox.post(Event::Problem { text });
            false
        }
    }
}

/// Encodes the last picture of a side, and puts it into the outbox.
fn publish(shared: &Shared, side: Side) {
    let Some(kept) = shared.kept(side) else { return };
    let start = Instant::now();
    let mut header = kept.header;
    let image = match shared.denoised(&kept) {
        Some(denoised) => {
            header.denoised = true;
            header.samples = denoised.samples;
            denoised.image
        }
        None => kept.image,
    };
    let image = Tone::of(&kept.settings).apply(&image);
    match encoded(&image, !header.preview) {
        Ok((bytes, media)) => {
            header.media = media;
            if !header.preview {
                shared.set_encoding(start.elapsed());
            }
            shared.outbox.post_frame(header, bytes);
        }
        Err(error) => {
            let text = format!("the picture cannot be encoded: {error}");
            shared.outbox.post(Event::Problem { text });
        }
    }
}
