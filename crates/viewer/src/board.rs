//! What is new for the engine: clients that have come, and scenes that have been loaded.

use crate::bell::Bell;
use crate::place::Place;
use crate::shared::Shared;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// What is new for the engine.
#[derive(Debug, Default)]
pub(crate) struct Board {
    pub(crate) bell: Arc<Bell>,
    news: Mutex<News>,
    /// Notified by the end of the first loading, and of the viewer.
    loaded: Condvar,
}

#[derive(Debug, Default)]
pub(crate) struct News {
    /// The viewer ends.
    pub(crate) ended: bool,
    /// Clients that have come.
    pub(crate) arrived: Vec<Arc<Shared>>,
    /// What is being loaded, since when.
    pub(crate) loading: Option<(&'static str, Instant)>,
    /// The end of loading.
    pub(crate) loaded: Option<Result<Box<Place>, String>>,
    /// The result of the first loading.
    first: Option<Result<(), String>>,
}

impl News {
    /// Returns true if the engine has to look at them.
    pub(crate) fn wait(&self) -> bool {
        self.ended || self.loaded.is_some() || !self.arrived.is_empty()
    }
}

impl Board {
    pub(crate) fn news(&self) -> MutexGuard<'_, News> {
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says what is being loaded.
    pub(crate) fn set_loading(&self, what: &'static str) {
        self.news().loading = Some((what, Instant::now()));
        self.bell.ring();
    }

    /// Hands over what has been loaded.
    pub(crate) fn set_loaded(&self, result: Result<Box<Place>, String>) {
        let mut news = self.news();
        news.loading = None;
        news.first.get_or_insert(result.as_ref().map(drop).map_err(String::clone));
        news.loaded = Some(result);
        drop(news);
        self.loaded.notify_all();
        self.bell.ring();
    }

    /// Waits until the scene has been loaded for the first time; returns what came of it.
    pub(crate) fn first(&self) -> Result<(), String> {
        let waits = |news: &mut News| news.first.is_none() && !news.ended;
        let news = self.loaded.wait_while(self.news(), waits);
        let news = news.unwrap_or_else(PoisonError::into_inner);
        news.first.clone().unwrap_or_else(|| Err("the viewer has ended".to_owned()))
    }

    pub(crate) fn end(&self) {
        self.news().ended = true;
        self.loaded.notify_all();
        self.bell.ring();
    }
}
