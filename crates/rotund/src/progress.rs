//! Progress of a render: a bar on a terminal, a plain line now and then elsewhere.

#![expect(clippy::print_stderr, reason = "progress is for the person, not for a pipe")]

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rotund_trace::Progress;
use std::io::{IsTerminal as _, stderr};
use std::time::Duration;

/// Time between lines if standard error is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);
/// Columns of a terminal that the bar keeps to.
const TERMINAL_COLUMNS: usize = 80;
/// Letters of a label that are shown.
const LONGEST_LABEL: usize = 16;
/// Steps of the bar.
const STEPS: u64 = 1000;
/// Longest text of rate and time: `999.99 Mrays/s, 99 h 59 min left`.
const LONGEST_STATE: usize = 33;

/// Shows samples, rays per second and the remaining time of one render on standard error.
pub(crate) struct Meter {
    label: String,
    samples: u32,
    bar: Option<ProgressBar>,
    next_line: Duration,
}

impl Meter {
    pub(crate) fn new(label: &str, samples: u32) -> Self {
        let bar = stderr().is_terminal().then(|| bar(label, samples, ProgressDrawTarget::stderr()));
        Self { label: label.to_owned(), samples, bar, next_line: LINE_EVERY }
    }

    /// Shows the state of a render.
    pub(crate) fn update(&mut self, progress: &Progress<'_>) {
        let (done, elapsed) = (progress.film.samples(), progress.elapsed);
        let state = state(progress.fraction(), progress.rays, elapsed);
        if let Some(bar) = &self.bar {
            show(bar, done, self.samples, progress.fraction(), &state);
        } else if elapsed >= self.next_line && done < self.samples {
            self.next_line = elapsed + LINE_EVERY;
            eprintln!("{}: {done} of {} samples, {state}", self.label, self.samples);
        }
    }

    /// Removes the bar. After an interruption, a line answers the signal before the files are
    /// written, which takes seconds if they are large.
    pub(crate) fn finish(self, interrupted: bool) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
        if interrupted {
            eprintln!("stopping: writing the samples so far; a second signal ends at once");
        }
    }
}

/// Returns a bar whose line fits into 80 columns whatever it shows.
fn bar(label: &str, samples: u32, target: ProgressDrawTarget) -> ProgressBar {
    let label: String = label.chars().take(LONGEST_LABEL).collect();
    let counts = 2 * samples.to_string().len() + "/".len();
    let text = label.chars().count() + " [] ".len() + counts + ", ".len() + LONGEST_STATE;
    let room = TERMINAL_COLUMNS.saturating_sub(text);
    let template = format!("{{prefix}} [{{bar:{}}}] {{msg}}", room.min(32));
    let style = ProgressStyle::with_template(&template).expect("a template that indicatif reads");
    let bar = ProgressBar::with_draw_target(Some(STEPS), target);
    bar.with_style(style.progress_chars("=> ")).with_prefix(label)
}

/// Moves the bar. It follows the fraction, which grows within the first sample too.
fn show(bar: &ProgressBar, done: u32, samples: u32, fraction: f64, state: &str) {
    bar.set_message(format!("{done}/{samples}, {state}"));
    bar.set_position((fraction * STEPS as f64) as u64);
}

/// Writes the rate and the remaining time, if this fraction of the work took so long.
fn state(fraction: f64, rays: u64, elapsed: Duration) -> String {
    let seconds = elapsed.as_secs_f64();
    let left = seconds * (1.0 / fraction.max(1e-9) - 1.0);
    let rate = rays as f64 / seconds.max(1e-9);
    format!("{}, {} left", rays_per_second(rate), time(left))
}

/// Writes a rate of rays with its unit.
pub(crate) fn rays_per_second(rate: f64) -> String {
    if rate >= 1e9 {
        format!("{:.2} Grays/s", rate / 1e9)
    } else if rate >= 1e6 {
        format!("{:.2} Mrays/s", rate / 1e6)
    } else {
        format!("{:.0} krays/s", rate / 1e3)
    }
}

/// Writes a duration in its two largest units.
fn time(seconds: f64) -> String {
    let whole = seconds.ceil() as u64;
    match (whole / 86_400, whole / 3600 % 24, whole / 60 % 60, whole % 60) {
        (0, 0, 0, s) => format!("{s} s"),
        (0, 0, m, s) => format!("{m} min {s:02} s"),
        (0, h, m, _) => format!("{h} h {m:02} min"),
        (d, h, _, _) => format!("{d} d {h:02} h"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::TermLike;
    use rotund_trace::{Film, FilmSample};
    use std::io;
    use std::sync::{Arc, Mutex};

    #[test]
    fn rates_and_times_read_well() {
        assert_eq!(rays_per_second(1_234_567.0), "1.23 Mrays/s");
        assert_eq!(rays_per_second(56_700.0), "57 krays/s");
        assert_eq!(rays_per_second(2.5e9), "2.50 Grays/s");
        let table = [
            (0.0, "0 s"),
            (59.5, "1 min 00 s"),
            (61.0, "1 min 01 s"),
            (7300.0, "2 h 01 min"),
            (90_000.0, "1 d 01 h"),
        ];
        for (seconds, text) in table {
            assert_eq!(time(seconds), text);
        }
    }

    #[test]
    fn the_time_left_is_that_of_this_run_whatever_the_film_had_before() {
        let mut film = Film::new(1, 1).expect("a film");
        film.accumulate(80, |_, _, _| FilmSample::default());
        // Half of the twenty missing samples took five seconds.
        let elapsed = Duration::from_secs(5);
        let progress = Progress { film: &film, samples: 10, total: 20, rays: 5_000_000, elapsed };
        let state = state(progress.fraction(), progress.rays, progress.elapsed);
        assert_eq!(state, "1.00 Mrays/s, 5 s left");
    }

    /// A terminal of 80 columns that records the lines that are drawn.
    #[derive(Clone, Debug, Default)]
    struct Recorder(Arc<Mutex<Vec<String>>>);

    impl TermLike for Recorder {
        fn width(&self) -> u16 {
            // Wide, since indicatif cuts what is longer than the terminal.
            400
        }
        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn write_line(&self, line: &str) -> io::Result<()> {
            self.write_str(line)
        }
        fn write_str(&self, text: &str) -> io::Result<()> {
            self.0.lock().expect("no panic").push(text.trim_end().to_owned());
            Ok(())
        }
        fn clear_line(&self) -> io::Result<()> {
            Ok(())
        }
        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn the_bar_fits_in_80_columns_whatever_it_shows() {
        let long_time = Duration::from_secs(359_000);
        let table = [
            ("vanilla", 64, 3, Duration::from_secs(10)),
            ("enhanced", 4096, 1, Duration::from_secs(86_399)),
            ("independent", 1 << 24, (1 << 24) - 1, long_time),
            (
                "a-name-that-is-longer-than-any-label",
                1 << 24,
                8_388_608,
                Duration::from_secs(86_000),
            ),
        ];
        for (label, samples, done, elapsed) in table {
            let terminal = Recorder::default();
            let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
            let bar = bar(label, samples, target);
            let rays = (999.99e6 * elapsed.as_secs_f64()) as u64;
            let fraction = f64::from(done) / f64::from(samples);
            show(&bar, done, samples, fraction, &state(fraction, rays, elapsed));
            bar.tick();
            let lines = terminal.0.lock().expect("no panic").clone();
            let line = lines.iter().max_by_key(|line| line.len()).expect("it draws");
            assert!(line.contains("999.99 Mrays/s") && line.ends_with("left"), "{line:?}");
            assert!(line.chars().count() <= 80, "{} columns: {line:?}", line.len());
        }
    }
}
