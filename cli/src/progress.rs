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
/// Least number of pictures whose first one does not count for the remaining time. It compiles the kernels, and may have
/// more samples than the others.
const MANY: u32 = 10;
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
        let (first, before) = *self.first.get_or_insert_with(|| (Instant::now(), share));
        if share - before >= TELLING {
            let left = first.elapsed().as_secs_f64() * (1.0 - share) / (share - before);
            what += &format!(", about {left:.0} s left");
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

    /// Counts a finished picture.
    pub(crate) fn next(&mut self) {
        self.pictures.1 += 1;
        if let (MANY.., 1) = self.pictures {
            self.first = Some((Instant::now(), 1.0 / f64::from(self.pictures.0)));
        }
    }

    /// Removes the bar, so that the next output begins on a clean line.
    pub(crate) fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}
