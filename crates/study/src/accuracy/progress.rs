//! Progress of the study: a bar on a terminal, a line for each shape elsewhere.

#![expect(clippy::print_stderr, reason = "progress is for the person, not for a pipe")]

use std::{
    io::{IsTerminal as _, stderr},
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};

/// Counts rows on standard error.
pub(crate) struct Progress {
    bar: ProgressBar,
    plain: bool,
    start: Instant,
}

impl Progress {
    pub(crate) fn new(rows: usize) -> Self {
        let plain = !stderr().is_terminal();
        let start = Instant::now();
        if plain {
            return Self { bar: ProgressBar::hidden(), plain, start };
        }
        let style = ProgressStyle::with_template("[{bar:32}] {pos}/{len} rows, {eta} left")
            .expect("a template that indicatif reads");
        let bar = ProgressBar::new(rows as u64).with_style(style.progress_chars("=> "));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, plain, start }
    }

    /// Returns a progress that prints nothing.
    #[cfg(test)]
    pub(crate) fn hidden() -> Self {
        Self { bar: ProgressBar::hidden(), plain: false, start: Instant::now() }
    }

    /// Counts a finished row.
    pub(crate) fn row(&self) {
        self.bar.inc(1);
    }

    /// Reports that all rows, joints and times of a shape are done.
    pub(crate) fn shape(&self, name: &str, rows: usize) {
        if self.plain {
            eprintln!(
                "{name}: {rows} rows measured after {:.0} s",
                self.start.elapsed().as_secs_f64()
            );
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(self) {
        self.bar.finish_and_clear();
    }
}
