//! The bell by which clients and the loader wake the engine.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A bell that stays rung until it is heard.
#[derive(Debug, Default)]
pub(crate) struct Bell {
    rung: Mutex<bool>,
    condition: Condvar,
}

impl Bell {
    fn lock(&self) -> MutexGuard<'_, bool> {
        self.rung.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says that something is new.
    pub(crate) fn ring(&self) {
        *self.lock() = true;
        self.condition.notify_all();
    }

    /// Waits until something is new, at most this long if there is a limit.
    pub(crate) fn wait(&self, limit: Option<Duration>) {
        let rung = self.lock();
        let quiet = |rung: &mut bool| !*rung;
        let mut rung = match limit {
            None => self.condition.wait_while(rung, quiet).unwrap_or_else(PoisonError::into_inner),
            Some(limit) => {
                let wait = self.condition.wait_timeout_while(rung, limit, quiet);
                wait.unwrap_or_else(PoisonError::into_inner).0
            }
        };
        *rung = false;
    }
}
