//! Shows progress, as a bar with the remaining time on a terminal, else as plain lines at intervals.

use std::{
    io::{self, IsTerminal, Write},
    ops::ControlFlow,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::arguments::Global;

/// Time before the bar appears.
const PATIENCE: Duration = Duration::from_millis(500);
/// Interval between plain lines.
const INTERVAL: Duration = Duration::from_secs(10);
/// Share of the work between the first report and the first estimate of the remaining time.
const TELLING: f64 = 0.05;
/// Least number of pictures whose median time gives the remaining time. The first ones compile kernels, and would make
/// a mean too long.
const MANY: u32 = 10;
/// Number of pictures, the last ones, whose times are kept.
const KEPT: usize = 1000;
/// Number of steps of the bar.
const STEPS: u64 = 10_000;

pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    /// Whether to write plain lines in place of a bar.
    plain: bool,
    begin: Instant,
    /// Time and share of finished work at the first report. Kernels are compiled before it.
    first: Option<(Instant, f64)>,
    last: Instant,
    /// Times of the last finished pictures, and the end of the last one.
    times: Vec<Duration>,
    ended: Instant,
    /// Total number of pictures, and number of finished pictures.
    pictures: (u32, u32),
}

impl Progress {
    /// Begins the progress display for `pictures` pictures.
    pub(crate) fn new(global: &Global, pictures: u32) -> Self {
        let on_terminal = io::stderr().is_terminal();
        let begin = Instant::now();
        Self {
            bar: None,
            plain: !on_terminal && !global.quiet,
            begin,
            first: None,
            last: begin,
            times: Vec::new(),
            ended: begin,
            pictures: (pictures, 0),
        }
        .with_bar(on_terminal && !global.quiet)
    }

    fn with_bar(mut self, wanted: bool) -> Self {
        if wanted {
            let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
            let template = "{wide_bar} {percent:>3}% {msg}";
            bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
            self.bar = Some(bar);
        }
        self
    }

    /// Shows progress within a picture. The returned value never stops rendering.
    pub(crate) fn show(&mut self, progress: stereotrace::Progress) -> ControlFlow<()> {
        let (all, done) = self.pictures;
        let share = (f64::from(done) + f64::from(progress.done)) / f64::from(all.max(1));
        let mut what = match all {
            1 => progress.pass.to_owned(),
            _ => format!("picture {} of {all}", done + 1),
        };
        if let Some(left) = self.left(share) {
            what += &format!(", about {:.0} s left", left.as_secs_f64());
        }
        if let Some(bar) = self.bar.as_ref().filter(|_| self.begin.elapsed() > PATIENCE) {
            if bar.is_hidden() {
                bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            bar.set_message(what);
            bar.set_position((share * STEPS as f64) as u64);
        } else if self.plain && self.last.elapsed() > INTERVAL && share > 0.0 {
            self.last = Instant::now();
            let _ = writeln!(io::stderr(), "{:.0}%, {what}", 100.0 * share);
        }
        ControlFlow::Continue(())
    }

    /// Returns the remaining time, if enough is finished to estimate it.
    fn left(&mut self, share: f64) -> Option<Duration> {
        let (first, before) = *self.first.get_or_insert_with(|| (Instant::now(), share));
        let (all, done) = self.pictures;
        if all < MANY {
            let is_enough = share - before >= TELLING;
            return is_enough.then(|| first.elapsed().mul_f64((1.0 - share) / (share - before)));
        }
        let is_enough = done >= 2 && 10 * done >= all;
        is_enough.then(|| median(&self.times).mul_f64(f64::from(all) * (1.0 - share)))
    }

    /// Counts a finished picture.
    pub(crate) fn next(&mut self) {
        let now = Instant::now();
        if self.times.len() == KEPT {
            self.times.remove(0);
        }
        self.times.push(now - self.ended);
        (self.ended, self.pictures.1) = (now, self.pictures.1 + 1);
    }

    /// Removes the bar, so that the next output begins on a clean line.
    pub(crate) fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn median(times: &[Duration]) -> Duration {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first pictures of a film compile kernels, and take much longer than the others.
    #[test]
    fn the_time_left_is_true_after_a_tenth_of_the_pictures() {
        let now = Instant::now();
        let seconds = |seconds: f64| Duration::from_secs_f64(seconds);
        let mut progress = Progress {
            bar: None,
            plain: false,
            begin: now,
            first: None,
            last: now,
            times: vec![seconds(1.0); 2],
            ended: now,
            pictures: (60, 2),
        };
        assert_eq!(progress.left(2.5 / 60.0), None);
        progress.times = [20.0, 6.0, 1.0, 1.1, 0.9, 1.0].map(seconds).to_vec();
        progress.pictures.1 = 6;
        let left = progress.left(0.1).unwrap().as_secs_f64();
        assert!((left - 54.0 * 1.05).abs() < 54.0 * 0.1, "{left}");
        progress.pictures = (1, 0);
        progress.first = Some((now.checked_sub(seconds(10.0)).unwrap(), 0.0));
        let left = progress.left(0.25).unwrap().as_secs_f64();
        assert!((left - 30.0).abs() < 1.0, "{left}");
        (0..2 * KEPT).for_each(|_| progress.next());
        assert_eq!(progress.times.len(), KEPT);
    }
}
