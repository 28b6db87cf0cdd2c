//! Pictures that wait for a thread.

use crate::shared::Shared;
use crate::side::Side;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Pictures that wait for a thread: at most one of each side of a client.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    content: Mutex<Content>,
    filled: Condvar,
}

#[derive(Debug, Default)]
struct Content {
    jobs: VecDeque<(Arc<Shared>, Side)>,
    ended: bool,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn add(&self, shared: &Arc<Shared>, side: Side) {
        let mut content = self.lock();
        let waits = |(of, which): &(Arc<Shared>, Side)| Arc::ptr_eq(of, shared) && *which == side;
        if !content.jobs.iter().any(waits) {
            content.jobs.push_back((Arc::clone(shared), side));
            self.filled.notify_one();
        }
    }

    pub(crate) fn end(&self) {
        self.lock().ended = true;
        self.filled.notify_all();
    }

    /// Waits for a job; `None` after the end.
    pub(crate) fn next(&self) -> Option<(Arc<Shared>, Side)> {
        let mut content = self.lock();
        loop {
            if content.ended {
                return None;
            }
            if let Some(job) = content.jobs.pop_front() {
                return Some(job);
            }
            content = self.filled.wait(content).unwrap_or_else(PoisonError::into_inner);
        }
    }
}
