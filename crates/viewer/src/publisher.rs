//! The thread that turns images into the bytes of frames, while the next are rendered.

use crate::develop::{Tone, encoded};
use crate::message::Event;
use crate::shared::Shared;
use crate::side::Side;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Instant;

/// Pictures that wait to be encoded: at most one of each side of a client.
#[derive(Debug, Default)]
pub(crate) struct Publisher {
    queue: Mutex<Queue>,
    filled: Condvar,
}

#[derive(Debug, Default)]
struct Queue {
    jobs: VecDeque<(Arc<Shared>, Side)>,
    ended: bool,
}

impl Publisher {
    /// Starts the thread, which ends by [`Self::end`].
    pub(crate) fn start() -> Arc<Self> {
        let publisher = Arc::new(Self::default());
        let own = Arc::clone(&publisher);
        thread::spawn(move || {
            while let Some((shared, side)) = own.next() {
                publish(&shared, side);
            }
        });
        publisher
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks for the last picture of a side to be sent.
    pub(crate) fn add(&self, shared: &Arc<Shared>, side: Side) {
        let mut queue = self.lock();
        let waits = |(of, which): &(Arc<Shared>, Side)| Arc::ptr_eq(of, shared) && *which == side;
        if !queue.jobs.iter().any(waits) {
            queue.jobs.push_back((Arc::clone(shared), side));
            self.filled.notify_one();
        }
    }

    pub(crate) fn end(&self) {
        self.lock().ended = true;
        self.filled.notify_all();
    }

    fn next(&self) -> Option<(Arc<Shared>, Side)> {
        let mut queue = self.lock();
        loop {
            if queue.ended {
                return None;
            }
            if let Some(job) = queue.jobs.pop_front() {
                return Some(job);
            }
            queue = self.filled.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Encodes the last picture of a side, and puts it into the outbox.
fn publish(shared: &Shared, side: Side) {
    let Some(kept) = shared.kept(side) else { return };
    let start = Instant::now();
    let mut header = kept.header;
    let image = Tone::of(&kept.settings).apply((*kept.image).clone());
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
