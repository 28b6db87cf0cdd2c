//! The lengths of batches and passes: how often a render reports, and how long a report is awaited.

use std::time::Duration;

/// Duration of a batch of pixels, after which progress is reported.
const BATCH_TIME: Duration = Duration::from_millis(50);
/// Age of a batch after which threads leave the rest of it for later. So reports come within 0.1 s
/// even where pixels are suddenly slower than those before.
const BATCH_LIMIT: Duration = Duration::from_millis(70);
/// Passes over the pixels get longer until they take between half of this and this.
const PASS_TIME: Duration = Duration::from_millis(500);
/// Longest time that the samples of one pixel in one pass may take, on average over a batch.
const PIXEL_TIME: Duration = Duration::from_millis(20);
/// Number of runs of a batch for each thread: so many that threads which finish early wait little.
const RUNS_PER_THREAD: usize = 64;
/// Largest number of consecutive pixels that a thread takes at once.
const LONGEST_RUN: usize = 256;
/// Number of samples between two looks at the clock, and the least of a run: so many that they
/// outweigh the time to read the clock and to distribute runs.
const STRIDE: usize = 16;
/// Pixels of the first batch, whose speed is not known yet.
const FIRST_BATCH: usize = 4096;

/// How many pixels are rendered between two reports, and how many samples of each.
///
/// A render makes passes over all pixels. A pass takes one sample of each pixel at first, and twice
/// as many as the last one while that took less than half of [`PASS_TIME`]. It is divided into
/// batches of consecutive pixels, whose number follows the measured speed, and a batch into runs,
/// which are the unit of work of a thread. The clock decides only when something is reported, never
/// what a pixel becomes.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    threads: usize,
    /// Pixels of the next batch.
    batch: usize,
    /// Samples per pixel of the current pass.
    pass_samples: u32,
    /// Time that this pass has taken so far.
    pass_time: Duration,
    /// Largest mean time of a pixel over a batch of this pass, on one thread.
    pixel_time: Duration,
}

impl Schedule {
    pub(super) fn new(threads: usize) -> Self {
        Self {
            threads: threads.max(1),
            batch: FIRST_BATCH,
            pass_samples: 1,
            pass_time: Duration::ZERO,
            pixel_time: Duration::ZERO,
        }
    }

    /// Samples per pixel of the current pass.
    pub(super) fn pass_samples(&self) -> u32 {
        self.pass_samples
    }

    /// Largest number of pixels of the next batch.
    pub(super) fn batch(&self) -> usize {
        self.batch
    }

    /// Number of consecutive pixels of a run, for a batch of this many pixels.
    pub(super) fn run(&self, batch: usize) -> usize {
        (batch / (self.threads * RUNS_PER_THREAD)).clamp(self.stride(), LONGEST_RUN)
    }

    /// Number of pixels of a run between two looks at the clock.
    pub(super) fn stride(&self) -> usize {
        STRIDE.div_ceil(self.pass_samples as usize)
    }

    /// True if the rest of a batch of this age is left for later.
    pub(super) fn is_over(age: Duration) -> bool {
        age >= BATCH_LIMIT
    }

    /// Adapts the length of batches: the last one finished `pixels` pixels.
    pub(super) fn batch_took(&mut self, pixels: usize, time: Duration) {
        self.pass_time += time;
        let seconds = time.as_secs_f64().max(1e-9);
        let aim = pixels as f64 * BATCH_TIME.as_secs_f64() / seconds;
        self.batch = (aim as usize).clamp(self.batch / 8, self.batch.saturating_mul(4)).max(1);
        if pixels > 0 {
            let of_pixel = time.mul_f64(self.threads.min(pixels) as f64 / pixels as f64);
            self.pixel_time = self.pixel_time.max(of_pixel);
        }
    }

    /// Chooses the number of samples of the next pass.
    pub(super) fn pass_ended(&mut self) {
        let short = self.pass_time < PASS_TIME / 2 && self.pixel_time < PIXEL_TIME / 2;
        if let (true, Some(samples)) = (short, self.pass_samples.checked_mul(2)) {
            self.pass_samples = samples;
            self.batch = (self.batch / 2).max(1);
        }
        (self.pass_time, self.pixel_time) = (Duration::ZERO, Duration::ZERO);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Renders on a simulated clock. `cost` is the time of one sample of a pixel; returns the
    /// length of each batch in time and pixels, and the largest number of samples of a pass.
    fn simulate(
        pixels: usize,
        threads: usize,
        samples: u32,
        cost: impl Fn(usize) -> Duration,
    ) -> (Vec<(Duration, usize)>, u32) {
        let mut schedule = Schedule::new(threads);
        let (mut batches, mut most, mut done) = (Vec::new(), 0, 0);
        while done < samples {
            let pass = schedule.pass_samples().min(samples - done);
            let mut next = 0;
            while next < pixels {
                let length = schedule.batch().min(pixels - next);
                // Threads take runs in turn; the earliest that is free takes the next.
                let mut free = vec![Duration::ZERO; threads];
                let mut finished = 0;
                while finished < length {
                    let thread = free.iter_mut().min().expect("a thread");
                    if finished > 0 && Schedule::is_over(*thread) {
                        break;
                    }
                    let end = length.min(finished + schedule.run(length));
                    while finished < end {
                        let stride = schedule.stride().min(end - finished);
                        let start = next + finished;
                        *thread +=
                            (start..start + stride).map(|p| cost(p) * pass).sum::<Duration>();
                        finished += stride;
                        if Schedule::is_over(*thread) {
                            break;
                        }
                    }
                }
                let time = *free.iter().max().expect("a thread");
                batches.push((time, finished));
                schedule.batch_took(finished, time);
                next += finished;
            }
            schedule.pass_ended();
            (done, most) = (done + pass, most.max(pass));
        }
        (batches, most)
    }

    #[test]
    fn a_report_comes_within_a_tenth_of_a_second_whatever_the_size() {
        let micros = Duration::from_micros;
        for threads in [1, 2, 16, 128] {
            for (why, side, samples, cost) in [
                ("one pixel", 1, 1 << 20, [10, 10]),
                ("a thumbnail", 40, 1 << 12, [10, 10]),
                ("a large picture", 4000, 2, [10, 10]),
                ("a large picture of expensive pixels", 1000, 2, [200, 200]),
                ("glass below a sky", 1000, 8, [1, 200]),
            ] {
                let pixels = side * side;
                let (batches, _) = simulate(pixels, threads, samples, |pixel| {
                    micros(cost[usize::from(pixel > pixels / 2)])
                });
                let (longest, _) = batches.iter().max().expect("a batch");
                assert!(*longest < Duration::from_millis(100), "{why}, {threads}: {longest:?}");
                // Short enough to react, but not so short that threads wait for each other.
                let total: Duration = batches.iter().map(|(time, _)| *time).sum();
                let mean = total / batches.len() as u32;
                assert!(total < BATCH_TIME || mean > BATCH_TIME / 8, "{why}, {threads}: {mean:?}");
            }
        }
    }

    #[test]
    fn passes_get_longer_while_they_are_fast() {
        let (_, most) = simulate(100 * 100, 2, 1 << 10, |_| Duration::from_micros(4));
        // One sample of each pixel takes 20 ms: passes of 16 take 320 ms.
        assert_eq!(most, 16);
    }
}
