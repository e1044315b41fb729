//! The command `view` opens a window with a live pair.
//!
//! Two threads have one device each: `work` renders, and `window` draws. So the window responds during long frames, and
//! a lost device can be replaced without the other one. Frames pass through the host. This costs a copy of some
//! megabytes, and works for every option and adapter.
//!
//! `control` moves the eyes, and `head` turns inside an equirectangular pair. `settings` holds the state, and `show`
//! draws it on the surface of `screen`. `panel` draws the text of `status`, `save` writes pictures, and `replay`
//! performs recorded input.
//!
//! The text uses a bitmap font. A library of widgets would add some twenty crates, need a newer Rust, and bring fonts
//! under licences of their own.

mod control;
mod head;
mod keys;
mod panel;
mod replay;
mod save;
mod screen;
mod settings;
mod show;
mod status;
mod window;
mod work;

use std::{error::Error, path::PathBuf};

use clap::Args;
use serde_json::json;
use winit::event_loop::EventLoop;

use self::{
    save::Origin,
    settings::Settings,
    window::{App, Output, Plan, Tally},
    work::{Said, Worker},
};
use crate::{
    arguments::{Global, Purpose, Subject, above_zero},
    summary::Summary,
    target::EyesArguments,
    usage::Usage,
};

/// Maximum side of a window in pixels.
const MOST: u32 = 16_384;

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Folder for pictures that the key P writes
    #[arg(long, short, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Width in metres of the display that comfort is computed for
    #[arg(long, value_name = "METRES", default_value_t = 0.6, value_parser = above_zero, allow_hyphen_values = true)]
    display_width: f32,
    /// Hide the text over the picture
    #[arg(long)]
    no_text: bool,
    /// Close the window after N whole pictures (drafts do not count)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Write what the window shows when it closes, as PNG
    #[arg(long, value_name = "FILE", requires = "frames")]
    screenshot: Option<PathBuf>,
    /// Perform the steps of a file instead of mouse and key input
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    #[command(flatten)]
    subject: Subject,
    #[command(flatten)]
    eyes: EyesArguments,
}

impl Arguments {
    /// Returns what the window shows.
    #[allow(clippy::unnecessary_wraps, reason = "builds without a window have none")]
    pub(crate) fn subject(&self) -> Option<&Subject> {
        Some(&self.subject)
    }

    /// Returns the subject and the arguments of both eyes.
    #[cfg(test)]
    fn parts(&self) -> (&Subject, &EyesArguments) {
        (&self.subject, &self.eyes)
    }
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let steps = arguments.replay.as_deref().map(replay::read).transpose()?.unwrap_or_default();
    let plan = Plan { steps, frames: arguments.frames, screenshot: arguments.screenshot.clone() };
    let subject = &arguments.subject;
    let size = subject.size();
    if size.iter().any(|side| *side > MOST) {
        let [width, height] = size;
        return Err(Usage(format!("--size {width}x{height}: a window has at most {MOST} pixels per side")).into());
    }
    let origin = Origin::new(std::env::args_os(), subject.lights_stand_by_camera())?;
    // Open the event loop first, so that a missing display is reported before the scene is read.
    let events = EventLoop::with_user_event().build().map_err(|error| {
        let hint = if cfg!(target_os = "linux") { "; is DISPLAY or WAYLAND_DISPLAY set?" } else { "" };
        format!("no window can be opened: {error}{hint}")
    })?;
    let stage = subject.open(Purpose::Pictures, global)?;
    let settings = Settings::new(&stage, &arguments.eyes, size)?;
    let proxy = events.create_proxy();
    let say = move |said: Said| drop(proxy.send_event(said)); // sending fails if the window is closed
    let worker = Worker::new((stage.renderer, stage.uploaded), stage.scene.clone(), global.clone(), say)?;
    let name = if stage.name.is_empty() { "view".into() } else { stage.name };
    let output = Output { folder: arguments.out.clone(), name, origin, scene: stage.scene, quiet: global.quiet };
    let mut app = App::new(settings, plan, output, worker, (!arguments.no_text, arguments.display_width));
    events.run_app(&mut app)?;
    summary(app.tally, arguments.frames.is_some())
}

fn summary(tally: Tally, automatic: bool) -> Result<Summary, Box<dyn Error>> {
    let Tally { drafts, whole, longest, files, fault } = tally;
    if let Some(fault) = fault {
        return Err(fault.into());
    }
    let ms = 1e3 * longest.as_secs_f64();
    let text = match automatic {
        true => format!("{whole} whole pictures, {drafts} drafts; the window was busy for {ms:.1} ms at most\n"),
        false => String::new(),
    };
    let files = Vec::from_iter(files.iter().map(|file| file.to_string_lossy()));
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"), "whole": whole, "drafts": drafts, "longest_ms": ms, "files": files,
    });
    Ok(Summary { text, json, ..Summary::default() })
}
