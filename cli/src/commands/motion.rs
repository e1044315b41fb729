//! Defines the camera motion of `sequence` and `dataset`: an orbit or a path of key frames.

use std::{error::Error, f32::consts::TAU, path::PathBuf};

use clap::Args;
use stereotrace::{CameraPath, StereoCamera};

use crate::{arguments::Subject, shown};

/// Maximum number of pictures, so that the digits of file names suffice.
pub(super) const MOST: u32 = 1_000_000;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "How it moves")]
pub(super) struct MotionArguments {
    /// Move the camera once around its target in N pictures
    #[arg(
        long,
        value_name = "N",
        conflicts_with = "path",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST))
    )]
    pub(super) orbit: Option<u32>,
    /// Move the camera along a JSON file's list of cameras, in the format of --cameras
    ///
    /// With `frame` a camera is a key frame; without it, each camera makes one picture.
    #[arg(long, value_name = "FILE")]
    pub(super) path: Option<PathBuf>,
}

#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a command has one value")]
pub(super) enum Motion {
    Orbit(StereoCamera, u32),
    Path(CameraPath),
}

impl MotionArguments {
    /// Returns the motion of the options, or `None` without such an option.
    pub(super) fn motion(&self, subject: &Subject, camera: StereoCamera) -> Result<Option<Motion>, Box<dyn Error>> {
        let Some(file) = &self.path else {
            return Ok(self.orbit.map(|frames| Motion::Orbit(camera, frames)));
        };
        let [width, height] = subject.size();
        let path = CameraPath::from_json_within(file, width, height, &subject.reading.limits())?;
        let path = subject.projected_path(path);
        match path.frames() {
            count if count > MOST => Err(format!("{}: {count} frames; the maximum is {MOST}", shown(file)).into()),
            _ => Ok(Some(Motion::Path(path))),
        }
    }
}

impl Motion {
    pub(super) fn frames(&self) -> u32 {
        match self {
            Self::Orbit(_, frames) => *frames,
            Self::Path(path) => path.frames(),
        }
    }

    /// Returns the camera of a picture. Between two pictures, the number has a fraction.
    pub(super) fn at(&self, frame: f64) -> StereoCamera {
        match self {
            Self::Orbit(camera, frames) => camera.orbited(TAU * frame as f32 / *frames as f32),
            Self::Path(path) => path.at(frame as f32),
        }
    }
}
