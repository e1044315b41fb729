//! Films, which FFmpeg makes from a sequence's pictures.

use std::{error::Error, fs, io, ops::Range, path::Path, process::Command};

use stereotrace::output::Packing;

use super::names::{Content, FilmPaths};
use crate::{
    shown,
    stop::{Interrupted, Stop},
    target::EyesArguments,
};

/// Oldest major version of FFmpeg that is accepted.
const OLDEST: u32 = 4;
/// Encoder of the films. They play almost everywhere.
const ENCODER: &str = "libx264";
/// Quality of the films; 0 is lossless, 23 the encoder's default.
const QUALITY: &str = "16";
/// H.264 with 4:2:0 has even sides. Pairs lose the last row or column of an odd side. If they were scaled, packings
/// that alternate rows, columns or pixels would mix both eyes.
const CROPPED: &str = "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,scale=";
/// Quilts with an odd side are scaled, since players divide a side by the number of views.
const SCALED: &str = "scale=trunc(iw/2)*2:trunc(ih/2)*2:";
/// Colours are those of sRGB.
const COLORS: &str = "out_color_matrix=bt709:out_range=tv,format=yuv420p";
/// Film in the folder of the pictures, before it is whole.
const ENCODED: &str = "film.mkv";
/// The same as MP4.
const WRAPPED: &str = "film.mp4";
/// Number of lines of FFmpeg's own message that an error repeats.
const LINES: usize = 3;

/// How a film marks the places of the views, for players and televisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Marking {
    /// Value of x264's option frame-packing.
    packing: u32,
    /// Value of Matroska's StereoMode, as FFmpeg names it.
    mode: &'static str,
}

impl Marking {
    /// Returns the marking of pictures of both eyes, or `None` for pictures that players show as they are.
    fn of(eyes: &EyesArguments) -> Option<Self> {
        // Players expect the left view first.
        if eyes.swap {
            return None;
        }
        match eyes.packing? {
            Packing::SideBySide | Packing::HalfSideBySide => Some(Self { packing: 3, mode: "left_right" }),
            Packing::TopBottom | Packing::HalfTopBottom => Some(Self { packing: 4, mode: "top_bottom" }),
            _ => None,
        }
    }
}

/// Checks that an FFmpeg is installed that can make films.
///
/// # Errors
/// Fails if there is none, or if it is too old or lacks the encoder.
pub(super) fn check(film: &Path) -> Result<(), String> {
    let told = |options: &[&str]| {
        run(Command::new("ffmpeg").args(options)).map_err(|fault| format!("{}: {fault}", shown(film)))
    };
    let version = told(&["-version"])?;
    // Versions of releases are like 5.1.9-0+deb12u1 or n7.1. Builds between releases have others, and are accepted.
    let name = version.split_whitespace().nth(2).unwrap_or_default();
    let major = name.trim_start_matches('n').split('.').next().and_then(|major| major.parse::<u32>().ok());
    if let Some(major) = major.filter(|major| *major < OLDEST) {
        return Err(format!("{}: films need FFmpeg {OLDEST} or newer; this is {major} ({name})", shown(film)));
    }
    match told(&["-hide_banner", "-encoders"])?.split_whitespace().any(|word| word == ENCODER) {
        true => Ok(()),
        false => Err(format!("{}: this FFmpeg ({name}) lacks the encoder {ENCODER}", shown(film))),
    }
}

/// Makes a film of the pictures with these numbers, whole or not at all.
pub(super) fn make(
    paths: &FilmPaths,
    numbers: &Range<u32>,
    fps: f32,
    content: &Content,
    stop: &Stop,
) -> Result<(), Box<dyn Error>> {
    if stop.is_asked_for() {
        return Err(Interrupted::InFilm.into());
    }
    let done = make_in_folder(paths, numbers, fps, content);
    if done.is_err() {
        for name in [ENCODED, WRAPPED] {
            // It need not be there.
            let _ = fs::remove_file(paths.folder.join(name));
        }
    }
    match done {
        // The signal ends FFmpeg too.
        Err(_) if stop.is_asked_for() => Err(Interrupted::InFilm.into()),
        other => other.map_err(|fault| format!("{}: {fault}", shown(&paths.film)).into()),
    }
}

/// Makes the film in the folder of the pictures, and moves it to its place.
fn make_in_folder(paths: &FilmPaths, numbers: &Range<u32>, fps: f32, content: &Content) -> Result<(), String> {
    let (even, marking) = match content {
        Content::Eyes(eyes) => (CROPPED, Marking::of(eyes)),
        Content::Quilt(..) => (SCALED, None),
    };
    let mut encode = ffmpeg(&paths.folder);
    encode.args(["-framerate", &fps.to_string(), "-start_number", &numbers.start.to_string()]);
    encode.args(["-i", FilmPaths::PATTERN, "-frames:v", &numbers.len().to_string()]);
    encode.args(["-vf", &format!("{even}{COLORS}"), "-c:v", ENCODER, "-crf", QUALITY]);
    encode.args(["-color_range", "tv", "-colorspace", "bt709", "-color_primaries", "bt709"]);
    encode.args(["-color_trc", "iec61966-2-1"]);
    if let Some(Marking { packing, mode }) = marking {
        encode.args(["-x264-params", &format!("frame-packing={packing}")]);
        encode.args(["-metadata:s:v:0", &format!("stereo_mode={mode}")]);
    }
    run(encode.arg(ENCODED))?;
    let encoded = paths.folder.join(ENCODED);
    let moved = if paths.is_matroska() {
        fs::rename(&encoded, &paths.film)
    } else {
        // MP4's box st3d comes only from the StereoMode of another file.
        let mut wrap = ffmpeg(&paths.folder);
        wrap.args(["-i", ENCODED, "-c", "copy", "-strict", "unofficial", "-movflags", "+faststart", WRAPPED]);
        run(&mut wrap)?;
        fs::rename(paths.folder.join(WRAPPED), &paths.film).and_then(|()| fs::remove_file(&encoded))
    };
    moved.map_err(|error| error.to_string())
}

/// Returns a command that runs in the folder of the pictures. So names of folders, which need not be Unicode, are no
/// part of its arguments.
fn ffmpeg(folder: &Path) -> Command {
    let mut command = Command::new("ffmpeg");
    command.args(["-hide_banner", "-nostdin", "-v", "error", "-y"]).current_dir(folder);
    command
}

/// Runs FFmpeg, and returns what it prints.
///
/// # Errors
/// Fails with the last lines of FFmpeg's own message.
fn run(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            let advice = "install it, for example by `apt-get install ffmpeg`, or give a folder for the pictures alone";
            format!("FFmpeg makes the films, and no ffmpeg is on the PATH; {advice}")
        }
        _ => format!("ffmpeg can't be run: {error}"),
    })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let message = String::from_utf8_lossy(&output.stderr);
    let lines = Vec::from_iter(message.lines().filter(|line| !line.trim().is_empty()));
    let last = &lines[lines.len().saturating_sub(LINES)..];
    Err(format!("ffmpeg failed ({}): {}", output.status, last.join(" ")))
}
