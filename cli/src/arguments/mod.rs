//! The command line: what every command takes. Each command's own arguments stand with the command.

mod camera;
mod light;
mod picture;
mod reading;
mod subject;
mod values;

pub(crate) use self::{
    camera::CameraArguments,
    light::LightArguments,
    picture::PictureArguments,
    reading::ReadingArguments,
    subject::{Stage, Subject, depths},
    values::{above_zero, frames, size},
};

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use stereotrace::Gpu;

use crate::{
    commands::{compare, dataset, info, render, sequence, views},
    view,
};

const AFTER: &str = "\
Examples:
  stereotrace render                                      the built-in hall: left, right and anaglyph, into out/
  stereotrace render bunny.obj --out bunny.png            an anaglyph of your model, seen from a corner
  stereotrace render room.obj --eye 0,1.6,3 --target 0,1,0 --packing side-by-side --out room.jpg
  stereotrace sequence bunny.obj --orbit 72 --out turn    a turntable, a picture a file
  stereotrace views --quilt 9x5 --size 512x512 --interaxial-px 2
  stereotrace view bunny.obj                              a window with a live anaglyph
  stereotrace dataset room.obj --pairs 200 --layout kitti --size 1242x375 --out data
  stereotrace compare sponza.obj --methods bracket,atomic how exact each is, and what it costs
  stereotrace info bunny.obj                              what is in it, and what this machine renders with

Exit status: 0 where all was written, 1 where something could not be read, rendered or written, 2 for a command line that says nothing
that can be done, 130 where SIGINT or SIGTERM ended `sequence` or `dataset`: after the pair at hand, and the same command makes the rest; a second
signal does not wait. Errors are one line on standard error.
STEREOTRACE_ADAPTER chooses the adapter where --adapter does not, NO_COLOR keeps colours off.";

/// Ray-traces stereo pairs on the GPU for little more than one eye's price, and says how exact the second eye is
#[derive(Clone, Debug, Parser)]
#[command(name = "stereotrace", version, after_help = AFTER, propagate_version = true, max_term_width = 110)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What every command takes.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "All commands")]
pub(crate) struct Global {
    /// Say nothing but warnings and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Print what was done as one JSON object in place of a table
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// What to render with: `software`, or a part of an adapter's name [default: STEREOTRACE_ADAPTER, else the
    /// fastest]
    #[arg(long, value_name = "NAME", global = true)]
    adapter: Option<String>,
}

impl Global {
    pub(crate) fn gpu(&self) -> Result<Gpu, stereotrace::Error> {
        match &self.adapter {
            Some(name) => Gpu::open(name.as_str()),
            None => Gpu::new(),
        }
    }
}

#[derive(Clone, Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a stereo pair, and an anaglyph or another picture of both eyes
    Render(Box<render::Arguments>),
    /// Render many pairs along a path of cameras, or around an object, into numbered files or to ffmpeg
    Sequence(Box<sequence::Arguments>),
    /// Render any number of views from left to right, as files or as a quilt for a light-field display
    Views(Box<views::Arguments>),
    /// Show a live pair in a window, to be turned and flown through (in builds with the feature `view`)
    View(Box<view::Arguments>),
    /// Render pairs with ground truth for stereo vision: disparities, occlusion, calibration, as loaders expect them
    Dataset(Box<dataset::Arguments>),
    /// Say what each method costs and gets wrong on a scene, against tracing both eyes
    Compare(Box<compare::Arguments>),
    /// Say what is in a scene file, how comfortable its picture is, and what this machine renders with
    Info(Box<info::Arguments>),
    /// Print completions for a shell
    Completions {
        /// Whose
        shell: Shell,
    },
    /// Print the manual page, as `man` reads it
    Man,
}
