//! Progress of `rays` on large scenes: a line that changes on a terminal, a line for each stage
//! elsewhere.

#![expect(clippy::print_stderr, reason = "progress is for the person, not for a pipe")]

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal as _, stderr};
use std::time::{Duration, Instant};

/// Without a terminal, scenes of fewer primitives are measured silently.
const LARGE: usize = 4_000_000;

/// Prints the stages of one scene on standard error.
pub(super) struct Progress {
    scene: String,
    start: Instant,
    bar: Option<ProgressBar>,
    plain: bool,
}

impl Progress {
    pub(super) fn new(scene: &str, primitives: usize) -> Self {
        let is_terminal = stderr().is_terminal();
        let bar = is_terminal.then(|| {
            let style = ProgressStyle::with_template("{spinner} {prefix}: {msg}, {elapsed}")
                .expect("a template that indicatif reads");
            let bar = ProgressBar::new_spinner().with_style(style).with_prefix(scene.to_owned());
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let plain = !is_terminal && primitives >= LARGE;
        Self { scene: scene.to_owned(), start: Instant::now(), bar, plain }
    }

    /// Begins a stage.
    pub(super) fn stage(&self, what: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(what.to_owned());
        } else if self.plain {
            let (scene, seconds) = (&self.scene, self.start.elapsed().as_secs_f64());
            eprintln!("{scene}: {what}, after {seconds:.0} s");
        }
    }

    /// Begins the next of equal steps, `done` of which took the time since `since`.
    pub(super) fn step(&self, what: &str, done: usize, of: usize, since: Instant) {
        let number = done + 1;
        if done == 0 {
            return self.stage(&format!("{what} {number} of {of}"));
        }
        let left = since.elapsed().as_secs_f64() * (of - done) as f64 / done as f64;
        self.stage(&format!("{what} {number} of {of}, about {left:.0} s left"));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
