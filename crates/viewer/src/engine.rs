//! The thread that renders for all clients in turn.

use crate::board::Board;
use crate::denoise::Denoise;
use crate::message::Event;
use crate::place::Place;
use crate::publisher::Publisher;
use crate::seat::Seat;
use crate::shared::Shared;
use std::mem;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time between two reports of loading.
const LOADING: Duration = Duration::from_millis(250);

/// The thread that renders for all clients in turn.
pub(crate) struct Engine {
    board: Arc<Board>,
    publisher: Arc<Publisher>,
    place: Option<Box<Place>>,
    seats: Vec<Seat>,
    /// Index of the seat whose turn it is.
    turn: usize,
    /// The last loading failed, with this message.
    failed: Option<String>,
}

impl Engine {
    pub(crate) fn new(board: Arc<Board>, denoiser: Option<Arc<dyn Denoise>>) -> Self {
        let publisher = Publisher::start(denoiser);
        Self { board, publisher, place: None, seats: Vec::new(), turn: 0, failed: None }
    }

    /// Serves clients until the viewer ends.
    pub(crate) fn run(mut self) {
        loop {
            let ended = self.look_at_board();
            if ended {
                self.publisher.end();
                self.seats.iter().for_each(|seat| seat.shared.close());
                return;
            }
            self.seats.retain(|seat| !seat.shared.is_closed());
            for seat in &mut self.seats {
                for ask in seat.shared.take_asks() {
                    seat.handle(ask, self.place.as_deref_mut());
                }
            }
            match self.next_seat() {
                Ok(index) => self.serve(index),
                Err(wait) => self.board.bell.wait(wait),
            }
        }
    }

    /// Takes what is new: clients and scenes. Returns true if the viewer ends.
    fn look_at_board(&mut self) -> bool {
        let mut news = self.board.news();
        let arrived = mem::take(&mut news.arrived);
        let (loading, loaded, ended) = (news.loading, news.loaded.take(), news.ended);
        drop(news);
        for shared in arrived {
            let mut seat = Seat::new(shared, Arc::clone(&self.publisher));
            if let Some(place) = &self.place {
                seat.scene_changed(place);
            }
            if let Some(text) = self.failed.clone() {
                seat.shared.outbox.post(Event::Problem { text });
            }
            self.seats.push(seat);
        }
        match loaded {
            Some(Ok(place)) => {
                self.seats.iter_mut().for_each(|seat| seat.scene_changed(&place));
                // The memory of the old scene is free before the first picture of the new one.
                self.place = Some(place);
                if self.failed.take().is_some() {
                    self.seats.iter().for_each(|seat| seat.shared.outbox.post(Event::Solved));
                }
            }
            Some(Err(text)) => {
                self.failed = Some(text.clone());
                for seat in &self.seats {
                    seat.shared.outbox.post(Event::Problem { text: text.clone() });
                }
            }
            None => {}
        }
        if let Some((what, since)) = loading {
            let seconds = since.elapsed().as_secs_f32();
            for seat in &self.seats {
                seat.shared.outbox.post(Event::Loading { what: what.to_owned(), seconds });
            }
        }
        ended
    }

    /// Returns the next seat that has something to do, or else how long to wait for that; `None`
    /// until something is new. Whoever waits for a first picture does not wait for the refinements
    /// of all others.
    fn next_seat(&mut self) -> Result<usize, Option<Duration>> {
        let now = Instant::now();
        let mut earliest: Option<Instant> = None;
        let mut next = None;
        let count = self.seats.len();
        for index in (0..count).map(|offset| (self.turn + offset) % count) {
            let seat = &self.seats[index];
            let Some(at) = seat.ready_at(now).filter(|_| self.place.is_some()) else { continue };
            if at > now {
                earliest = Some(earliest.map_or(at, |other| other.min(at)));
            } else if seat.waits_for_picture() {
                next = Some(index);
                break;
            } else {
                next = next.or(Some(index));
            }
        }
        if let Some(index) = next {
            self.turn = (index + 1) % count;
            return Ok(index);
        }
        let wait = earliest.map(|at| at - now);
        let is_loading = self.board.news().loading.is_some();
        let report = is_loading.then_some(LOADING);
        Err(wait.map_or(report, |wait| Some(report.map_or(wait, |report| wait.min(report)))))
    }

    fn serve(&mut self, index: usize) {
        let Some(place) = &mut self.place else { return };
        let now = Instant::now();
        let is_ready = |seat: &Seat| seat.ready_at(now).is_some_and(|at| at <= now);
        let alone = self.seats.iter().filter(|seat| is_ready(seat)).count() == 1;
        // What the others want, movements above all, comes before the refinement of this one.
        let others: Vec<Arc<Shared>> =
            self.seats.iter().map(|seat| Arc::clone(&seat.shared)).collect();
        let board = &self.board;
        let interrupted = |own: &Shared| {
            let news = board.news().wait();
            news || own.wants_attention() || others.iter().any(|shared| shared.wants_attention())
        };
        self.seats[index].step(place, alone, &interrupted);
    }
}
