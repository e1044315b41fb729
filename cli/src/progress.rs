//! How far the work is: a bar with the time left on a terminal, plain lines now and then elsewhere.

use std::{
    io::{self, IsTerminal, Write},
    ops::ControlFlow,
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::arguments::Global;

/// What is done sooner shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);
/// Between two plain lines.
const INTERVAL: Duration = Duration::from_secs(10);
/// Steps of the bar.
const STEPS: u64 = 10_000;

pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    /// Plain lines are written.
    plain: bool,
    begin: Instant,
    last: Instant,
    /// Pictures in all, and how many are there already.
    pictures: (u32, u32),
}

impl Progress {
    /// Of so many pictures.
    pub(crate) fn new(global: &Global, pictures: u32) -> Self {
        let on_terminal = io::stderr().is_terminal();
        let begin = Instant::now();
        Self { bar: None, plain: !on_terminal && !global.quiet, begin, last: begin, pictures: (pictures, 0) }
            .with_bar(on_terminal && !global.quiet)
    }

    fn with_bar(mut self, wanted: bool) -> Self {
        if wanted {
            let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
            let template = "{wide_bar} {percent:>3}% {msg}, {eta} left";
            bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
            self.bar = Some(bar);
        }
        self
    }

    /// Within a picture; it never asks to stop.
    pub(crate) fn show(&mut self, progress: stereotrace::Progress) -> ControlFlow<()> {
        let (all, done) = self.pictures;
        let share = (f64::from(done) + f64::from(progress.done)) / f64::from(all.max(1));
        let what = match all {
            1 => progress.pass.to_owned(),
            _ => format!("picture {} of {all}", done + 1),
        };
        if let Some(bar) = self.bar.as_ref().filter(|_| self.begin.elapsed() > PATIENCE) {
            if bar.is_hidden() {
                bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            bar.set_message(what);
            bar.set_position((share * STEPS as f64) as u64);
        } else if self.plain && self.last.elapsed() > INTERVAL && share > 0.0 {
            self.last = Instant::now();
            let left = self.begin.elapsed().as_secs_f64() * (1.0 - share) / share;
            let _ = writeln!(io::stderr(), "{:.0}%, {what}, about {left:.0} s left", 100.0 * share);
        }
        ControlFlow::Continue(())
    }

    /// A picture is there.
    pub(crate) fn next(&mut self) {
        self.pictures.1 += 1;
    }

    /// Takes the bar away, so that what is printed next has the line to itself.
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
