//! What waits to be sent to a client: the latest of everything, so memory is bounded.

use crate::message::{Event, Frame, FrameHeader, Request, Side};
use crate::session::Output;
use std::collections::VecDeque;
use std::mem;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Frames that a client may have received but not shown yet.
const IN_FLIGHT: usize = 2;
/// Time after which frames count as shown even if the client does not say so.
const SHOWN_AFTER: Duration = Duration::from_secs(5);
/// The most problems and inspections that wait; older ones are dropped.
const MOST_EVENTS: usize = 16;

/// What waits to be sent to a client.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    content: Mutex<Content>,
    filled: Condvar,
}

#[derive(Debug, Default)]
struct Content {
    closed: bool,
    state: Option<Event>,
    status: Option<Event>,
    loading: Option<Event>,
    /// Problems and answers.
    others: VecDeque<Event>,
    frames: [Option<Frame>; 2],
    /// Ids of the frames that have been given out and not shown, with the time.
    in_flight: Vec<(u64, Instant)>,
    next_id: u64,
    /// Frames of earlier epochs are dropped.
    epoch: u64,
}

impl Outbox {
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an event; replaces one of the same kind that waits, if the latest is all that counts.
    pub(crate) fn post(&self, event: Event) {
        let mut content = self.lock();
        match event {
            Event::State(ref state) => {
                content.epoch = state.epoch;
                // A picture of before must not be taken for one of this state.
                for frame in &mut content.frames {
                    *frame = frame.take().filter(|frame| frame.header.epoch >= state.epoch);
                }
                content.state = Some(event);
            }
            Event::Status(_) => content.status = Some(event),
            Event::Loading { .. } => content.loading = Some(event),
            Event::Inspection(_) | Event::Problem { .. } | Event::Solved => {
                if content.others.len() == MOST_EVENTS {
                    content.others.pop_front();
                }
                content.others.push_back(event);
            }
        }
        self.filled.notify_all();
    }

    /// Adds a frame, which replaces one of the same side that waits, unless it is of an epoch that
    /// is over.
    pub(crate) fn post_frame(&self, mut header: FrameHeader, bytes: Vec<u8>) {
        let mut content = self.lock();
        if header.epoch < content.epoch {
            return;
        }
        content.next_id += 1;
        header.id = content.next_id;
        let side = header.side as usize;
        content.frames[side] = Some(Frame { header, bytes });
        self.filled.notify_all();
    }

    /// Takes note that a frame has been shown, and all before it.
    pub(crate) fn shown(&self, request: &Request) {
        if let Request::Shown { frame } = *request {
            self.lock().in_flight.retain(|(id, _)| *id > frame);
            self.filled.notify_all();
        }
    }

    /// Ends all waiting.
    pub(crate) fn close(&self) {
        self.lock().closed = true;
        self.filled.notify_all();
    }

    /// Waits for something to send, at most this long.
    pub(crate) fn next(&self, timeout: Duration) -> Option<Output> {
        let end = Instant::now() + timeout;
        let mut content = self.lock();
        loop {
            if content.closed {
                return None;
            }
            if let Some(output) = content.take() {
                return Some(output);
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            let wait = self.filled.wait_timeout(content, left);
            content = wait.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl Content {
    fn take(&mut self) -> Option<Output> {
        // The state comes before the frames that show it.
        let event = self.state.take().or_else(|| self.loading.take());
        let event = event.or_else(|| self.others.pop_front());
        if let Some(event) = event {
            return Some(Output::Event(event));
        }
        self.in_flight.retain(|(_, since)| since.elapsed() < SHOWN_AFTER);
        if self.in_flight.len() < IN_FLIGHT {
            // The side that has waited longer goes first.
            let id = |frame: &Option<Frame>| frame.as_ref().map_or(u64::MAX, |it| it.header.id);
            let side = usize::from(id(&self.frames[1]) < id(&self.frames[0]));
            if let Some(frame) = mem::take(&mut self.frames[side]) {
                self.in_flight.push((frame.header.id, Instant::now()));
                return Some(Output::Frame(frame));
            }
        }
        self.status.take().map(Output::Event)
    }
}

impl Side {
    /// Both sides, in the order of their indices.
    pub(crate) const ALL: [Self; 2] = [Self::Chosen, Self::Vanilla];
}
