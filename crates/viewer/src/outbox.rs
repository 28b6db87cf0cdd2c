//! What waits to be sent to a client: the latest of everything, so memory is bounded.

use crate::message::{Event, Frame, FrameHeader, Output, Request};
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
                content.start_epoch(state.epoch);
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
    /// Drops the pictures of before, which must not be taken for one of this epoch.
    fn start_epoch(&mut self, epoch: u64) {
        self.epoch = epoch;
        for frame in &mut self.frames {
            *frame = frame.take().filter(|frame| frame.header.epoch >= epoch);
        }
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{Activity, Status};
    use crate::side::Side;

    const NOW: Duration = Duration::ZERO;

    fn header(side: Side, epoch: u64, samples: u32) -> FrameHeader {
        let (id, input, width, height, media) = (0, 0, 1, 1, "image/png");
        let (preview, denoised) = (false, false);
        FrameHeader { id, epoch, side, input, width, height, samples, preview, denoised, media }
    }

    fn status(samples: u32) -> Event {
        Event::Status(Status {
            epoch: 0,
            activity: Activity::Refining,
            samples,
            wanted: 9,
            rays_per_second: 1.0,
            seconds: 1.0,
            noise: None,
            fireflies: 0,
        })
    }

    /// Returns the samples of the frames that are given out until there are none.
    fn frames(outbox: &Outbox) -> Vec<u32> {
        std::iter::from_fn(|| outbox.next(NOW))
            .filter_map(|output| match output {
                Output::Frame(frame) => Some(frame.header.samples),
                Output::Event(_) => None,
            })
            .collect()
    }

    #[test]
    fn a_client_that_does_not_read_finds_the_latest_of_everything_only() {
        let outbox = Outbox::default();
        for samples in 1..=1000 {
            outbox.post(status(samples));
            outbox.post_frame(header(Side::Chosen, 0, samples), vec![0; 1000]);
            outbox.post(Event::Problem { text: samples.to_string() });
        }
        let outputs: Vec<Output> = std::iter::from_fn(|| outbox.next(NOW)).collect();
        assert_eq!(outputs.len(), MOST_EVENTS + 2, "problems, a frame and a status");
        let last = |output: &Output| match output {
            Output::Event(Event::Status(status)) => status.samples == 1000,
            Output::Frame(frame) => frame.header.samples == 1000,
            Output::Event(_) => false,
        };
        assert_eq!(outputs.iter().filter(|output| last(output)).count(), 2);
    }

    #[test]
    fn frames_wait_until_earlier_ones_have_been_shown() {
        let outbox = Outbox::default();
        let post = |samples| outbox.post_frame(header(Side::Chosen, 0, samples), vec![]);
        let mut given = Vec::new();
        for samples in 1..=5 {
            post(samples);
            given.extend(frames(&outbox));
        }
        assert_eq!(given, [1, 2], "no more than two are on their way");
        outbox.shown(&Request::Shown { frame: 2 });
        assert_eq!(frames(&outbox), [5], "those between have been replaced");
    }

    #[test]
    fn frames_of_an_earlier_epoch_are_not_given_out() {
        let outbox = Outbox::default();
        outbox.post_frame(header(Side::Chosen, 1, 1), vec![]);
        outbox.post_frame(header(Side::Vanilla, 2, 2), vec![]);
        outbox.lock().start_epoch(2);
        // Encoded late.
        outbox.post_frame(header(Side::Chosen, 1, 3), vec![]);
        assert_eq!(frames(&outbox), [2]);
    }

    #[test]
    fn waiting_ends_when_something_comes_or_the_session_ends() {
        let outbox = Outbox::default();
        std::thread::scope(|scope| {
            let first = scope.spawn(|| outbox.next(Duration::from_secs(60)));
            outbox.post(Event::Solved);
            assert!(first.join().expect("no panic").is_some());
            let second = scope.spawn(|| outbox.next(Duration::from_secs(60)));
            outbox.close();
            assert!(second.join().expect("no panic").is_none());
        });
    }
}
