//! Where pictures go, and what becomes of both eyes.

use std::{
    error::Error,
    fs, io,
    path::{Path, PathBuf},
};

use clap::Args;
use stereotrace::{
    GroundTruth, StereoPair, View,
    output::{Anaglyph, Batch, ExrColor, Packing, Picture, anaglyph, packed},
};

use crate::shown;

/// Endings of pictures that are written.
const WRITTEN: [&str; 6] = ["png", "jpg", "jpeg", "jps", "mpo", "exr"];
/// Endings of pictures that aren't: a folder of such a name is not what is meant.
const NOT_WRITTEN: [&str; 8] = ["avif", "bmp", "gif", "hdr", "tga", "tif", "tiff", "webp"];

/// How both eyes become one picture.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Both eyes in one picture")]
pub(crate) struct EyesArguments {
    /// Colours of the anaglyph: dubois, dubois-lcd, grey, colour, half-colour, green-magenta or amber-blue
    #[arg(long, value_name = "KIND", default_value_t)]
    pub(crate) anaglyph: Anaglyph,
    /// In its place: side-by-side, half-side-by-side, cross-eyed, top-bottom, half-top-bottom, row-interlaced,
    /// column-interlaced or checkerboard
    #[arg(long, value_name = "KIND", conflicts_with = "anaglyph")]
    pub(crate) packing: Option<Packing>,
    /// Exchange the eyes in everything that is written, except the re-trace and shadow maps
    #[arg(long)]
    pub(crate) swap: bool,
    /// Of JPEG, JPS and MPO files, 1 to 100
    #[arg(long, value_name = "Q", default_value_t = 92, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) quality: u8,
}

impl EyesArguments {
    /// The eyes as they are written: left and right.
    pub(crate) fn ordered<'a>(&self, left: &'a View, right: &'a View) -> (&'a View, &'a View) {
        if self.swap { (right, left) } else { (left, right) }
    }

    /// The one picture: a packing if one is asked for, else the anaglyph.
    pub(crate) fn picture(&self, left: &View, right: &View) -> Picture {
        let (left, right) = self.ordered(left, right);
        match self.packing {
            Some(packing) => packed(left, right, packing),
            None => anaglyph(left, right, self.anaglyph),
        }
    }
}

/// Where pictures go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// Several files in a folder.
    Folder(PathBuf),
    /// One file.
    File(PathBuf),
}

impl Target {
    /// A name with a picture's ending is a file, unless a folder has it; all else is a folder, which is made.
    pub(crate) fn of(path: &Path) -> Result<Self, Box<dyn Error>> {
        let ending = ending(path);
        if !path.is_dir() && WRITTEN.contains(&&*ending) {
            if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
                make_folder(folder)?;
            }
            check_writable(path.parent().unwrap_or(path), path)?;
            return Ok(Self::File(path.to_owned()));
        }
        if !path.is_dir() && NOT_WRITTEN.contains(&&*ending) {
            let endings = WRITTEN.join(", .");
            return Err(format!("{}: pictures are written as .{endings}", shown(path)).into());
        }
        make_folder(path)?;
        check_writable(path, path)?;
        Ok(Self::Folder(path.to_owned()))
    }
}

/// Fails before anything is rendered that could not be written: makes a file in the folder, and removes it.
fn check_writable(folder: &Path, target: &Path) -> Result<(), String> {
    let probe = folder.join(format!(".stereotrace-{}", std::process::id()));
    let written = fs::File::create(&probe).and_then(|_| fs::remove_file(&probe));
    written.map_err(|error| format!("{}: nothing can be written there: {error}", shown(target)))
}

/// Makes a folder to write into.
fn make_folder(path: &Path) -> Result<(), String> {
    let fault = |error: io::Error| match path.exists() {
        true => format!("{}: it is no folder; --out takes a folder, or a picture's name like pair.png", shown(path)),
        false => format!("{}: the folder can't be made: {error}", shown(path)),
    };
    fs::create_dir_all(path).map_err(fault)
}

/// A picture's kind by its name's ending.
fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Whether a file of this name holds both eyes, whatever else is asked for.
pub(crate) fn is_open_exr(path: &Path) -> bool {
    ending(path) == "exr"
}

/// Adds a picture to what is written, of the kind that its name's ending says.
pub(crate) fn add_picture(
    batch: &mut Batch,
    path: &Path,
    picture: &Picture,
    quality: u8,
) -> Result<(), Box<dyn Error>> {
    match &*ending(path) {
        "png" => Ok(batch.add_png(path, picture)?),
        "jpg" | "jpeg" => Ok(batch.add_jpeg(path, picture, quality)?),
        other => Err(format!("{}: .{other} holds both eyes of a pair, not one picture", shown(path)).into()),
    }
}

/// Adds a file of both eyes, of the kind that its name's ending says.
pub(crate) fn add_pair(
    batch: &mut Batch,
    path: &Path,
    pair: &StereoPair,
    truth: Option<&GroundTruth>,
    eyes: &EyesArguments,
) -> Result<(), Box<dyn Error>> {
    let kind = ending(path);
    if kind == "exr" && eyes.swap {
        return Err(format!("{}: its parts are named left and right; --swap is for pictures", shown(path)).into());
    }
    let swapped = || {
        let mut swapped = pair.clone();
        std::mem::swap(&mut swapped.left, &mut swapped.right);
        swapped
    };
    match &*kind {
        "exr" => batch.add_exr(path, pair, truth, ExrColor::Half)?,
        "jps" if eyes.swap => batch.add_jps(path, &swapped(), eyes.quality)?,
        "jps" => batch.add_jps(path, pair, eyes.quality)?,
        "mpo" if eyes.swap => batch.add_mpo(path, &swapped(), eyes.quality)?,
        "mpo" => batch.add_mpo(path, pair, eyes.quality)?,
        _ => add_picture(batch, path, &eyes.picture(&pair.left, &pair.right), eyes.quality)?,
    }
    Ok(())
}
