//! How far a render has come: a bar on a terminal, a few plain lines elsewhere.

#![expect(clippy::print_stderr, reason = "progress is for the person, not for a pipe")]

use indicatif::{ProgressBar, ProgressStyle};
use rotund_trace::Progress;
use std::io::{IsTerminal as _, stderr};
use std::time::Duration;

/// Without a terminal a line is printed when this much time has passed since the last.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Shows samples, rays per second and the time left of one render on standard error.
pub(crate) struct Meter {
    label: String,
    samples: u32,
    bar: Option<ProgressBar>,
    next_line: Duration,
}

impl Meter {
    pub(crate) fn new(label: &str, samples: u32) -> Self {
        let bar = stderr().is_terminal().then(|| {
            let style = "{prefix:>9} [{bar:32}] {pos}/{len} samples, {msg}";
            let style =
                ProgressStyle::with_template(style).expect("a template that indicatif reads");
            let bar = ProgressBar::new(u64::from(samples)).with_style(style.progress_chars("=> "));
            bar.with_prefix(label.to_owned())
        });
        Self { label: label.to_owned(), samples, bar, next_line: LINE_EVERY }
    }

    /// Shows the state of a render.
    pub(crate) fn update(&mut self, progress: &Progress<'_>) {
        let (done, elapsed) = (progress.film.samples(), progress.elapsed);
        let seconds = elapsed.as_secs_f64();
        let left = seconds * (1.0 / progress.fraction().max(1e-9) - 1.0);
        let rate = progress.rays as f64 / seconds.max(1e-9);
        let state = format!("{}, {} left", rays_per_second(rate), time(left));
        if let Some(bar) = &self.bar {
            bar.set_position(u64::from(done));
            bar.set_message(state);
        } else if elapsed >= self.next_line && done < self.samples {
            self.next_line = elapsed + LINE_EVERY;
            eprintln!("{}: {done} of {} samples, {state}", self.label, self.samples);
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// `rate` as people read it.
pub(crate) fn rays_per_second(rate: f64) -> String {
    if rate >= 1e6 {
        format!("{:.2} Mrays/s", rate / 1e6)
    } else {
        format!("{:.0} krays/s", rate / 1e3)
    }
}

/// Seconds as people read them.
fn time(seconds: f64) -> String {
    let whole = seconds.ceil() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s:02} s"),
        (h, m, _) => format!("{h} h {m:02} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::{rays_per_second, time};

    #[test]
    fn rates_and_times_read_well() {
        assert_eq!(rays_per_second(1_234_567.0), "1.23 Mrays/s");
        assert_eq!(rays_per_second(56_700.0), "57 krays/s");
        let table =
            [(0.0, "0 s"), (59.5, "1 min 00 s"), (61.0, "1 min 01 s"), (7300.0, "2 h 01 min")];
        for (seconds, text) in table {
            assert_eq!(time(seconds), text);
        }
    }
}
