//! Defines the commands and the arguments that they share. Each command's own arguments are in `commands`.

mod camera;
mod light;
mod picture;
mod reading;
mod short_help;
mod subject;
mod time;
mod values;

#[cfg(feature = "view")]
pub(crate) use self::values::size;
pub(crate) use self::{
    camera::CameraArguments,
    light::LightArguments,
    picture::PictureArguments,
    reading::ReadingArguments,
    short_help::{command, whole_command},
    subject::{PREVIEW, Purpose, Stage, Subject, depths},
    time::TimeArguments,
    values::{ShutterArgument, above_zero, frames, shutter},
};

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use stereotrace::{Adapter, Gpu, Renderer, blocking::Wait};

use crate::{
    calibration,
    commands::{bench, compare, dataset, info, render, sequence, views},
    view,
};

const AFTER: &str = "\
Examples:
  stereotrace render                                      the built-in hall: left, right and anaglyph, into out/
  stereotrace render bunny.obj --out bunny.png            an anaglyph of your model
  stereotrace render room.obj --eye 0,1.6,3 --target 0,1,0 --packing side-by-side --out room.jpg
  stereotrace sequence bunny.obj --orbit 72 -o a.mp4      a turntable, as a film
  stereotrace views a.obj --display looking-glass-go      a quilt for a light-field display
  stereotrace view bunny.obj                              a window with a live anaglyph
  stereotrace dataset room.obj --pairs 200 --layout kitti --size 1242x375 --out data
  stereotrace compare sponza.obj --methods bracket,atomic cost and errors of these methods
  stereotrace bench                                       how fast this machine's adapter is, as a report
  stereotrace info bunny.obj                              what the file contains, and this machine's adapters

Exit status:
  0    everything was written
  1    something could not be read, rendered or written
  2    the command line is wrong, or --out can't be written
  130  SIGINT or SIGTERM ended `sequence` or `dataset` after the current pair. The same command then makes the
       rest. A second signal ends the command at once.
An error is one line on standard error.

Environment:
  STEREOTRACE_ADAPTER  adapter to render with, if --adapter is not given
  NO_COLOR             disables colours in the output";

/// Ray-trace stereo pairs on the GPU, reuse one eye's samples for the other, and measure the error of this reuse
#[derive(Clone, Debug, Parser)]
#[command(name = "stereotrace", version, after_help = AFTER, propagate_version = true, max_term_width = 110)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Options that all commands share.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "All commands")]
pub(crate) struct Global {
    /// Print only warnings and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Print the result as one JSON object instead of a table
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Graphics adapter: `software`, or a part of an adapter's name [default: STEREOTRACE_ADAPTER, else the fastest]
    #[arg(long, value_name = "NAME", global = true)]
    adapter: Option<String>,
    /// Trace rays by the adapter's ray queries, in hardware where it has some. They are experimental
    #[arg(long, global = true)]
    ray_queries: bool,
    /// First measure the adapter for the method auto, and keep the result in the user's cache folder for later runs
    #[arg(long, global = true)]
    pub(crate) calibrate: bool,
}

impl Global {
    pub(crate) fn gpu(&self) -> Result<Gpu, stereotrace::Error> {
        let adapter = self.adapter.as_deref().map_or(Adapter::FromEnv, Adapter::from);
        match self.ray_queries {
            true => Gpu::open_with_ray_queries(adapter).wait(),
            false => Gpu::open(adapter).wait(),
        }
    }

    /// Returns a renderer on the adapter, whose `auto` chooses by the adapter's calibration.
    pub(crate) fn renderer(&self, gpu: Gpu) -> Result<Renderer, stereotrace::Error> {
        calibration::renderer(gpu, self.calibrate)
    }
}

impl Command {
    /// Returns what the command renders, if it renders a scene that the command line names.
    pub(crate) fn subject(&self) -> Option<&Subject> {
        match self {
            Self::Render(arguments) => Some(&arguments.subject),
            Self::Sequence(arguments) => Some(&arguments.subject),
            Self::Views(arguments) => Some(&arguments.subject),
            Self::View(arguments) => arguments.subject(),
            Self::Dataset(arguments) => Some(&arguments.subject),
            Self::Compare(arguments) => Some(&arguments.subject),
            Self::Info(arguments) => Some(&arguments.subject),
            Self::Bench(_) | Self::Completions { .. } | Self::Man => None,
        }
    }
}

#[derive(Clone, Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a stereo pair as an anaglyph, side by side, or as separate views
    Render(Box<render::Arguments>),
    /// Render pairs or quilts along a camera path or around an object, as a film or as numbered files
    Sequence(Box<sequence::Arguments>),
    /// Render any number of views from left to right, as files or as a quilt for light-field displays
    Views(Box<views::Arguments>),
    /// Open a window with a live pair, and navigate by mouse and keys
    View(Box<view::Arguments>),
    /// Render pairs with ground truth for stereo vision, in known layouts
    ///
    /// Each pair has disparity, occlusion and calibration.
    Dataset(Box<dataset::Arguments>),
    /// Measure the cost and the errors of each method on a scene, against tracing both eyes
    Compare(Box<compare::Arguments>),
    /// Measure this machine's adapter with built-in scenes, and write a report to send
    Bench(bench::Arguments),
    /// Show what a scene file contains, how comfortable its picture is to view, and this machine's adapters
    Info(Box<info::Arguments>),
    /// Print completions for a shell
    Completions {
        /// Shell that the completions are for
        shell: Shell,
    },
    /// Print the manual page in roff, for `man`
    Man,
}
