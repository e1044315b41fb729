//! Names of a sequence's pictures, and the record of their settings.

use std::{
    error::Error,
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

use serde_json::Value;
use stereotrace::{
    StereoPair,
    output::{Batch, Picture, write_whole},
};

use super::quilt::Fan;
use crate::{
    shown,
    target::{EyesArguments, Target, add_pair, add_picture, prepare_file},
    usage::Usage,
};

/// File that records the settings and inputs of a folder's pictures.
const RECORD: &str = "sequence.json";

/// Names of the pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Names {
    /// Several files for each pair, in this folder.
    Folder(PathBuf),
    /// One file for each pair. `before` and `behind` are the parts of its name around the number.
    Numbered { folder: PathBuf, before: String, digits: usize, behind: String },
    /// One file for each pair, in a folder, of which a film is made.
    Film(FilmPaths),
    /// Raw pictures on standard output.
    Stdout,
}

/// Places of a film and of its pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FilmPaths {
    pub(super) film: PathBuf,
    /// Folder of the pictures, beside the film.
    pub(super) folder: PathBuf,
}

impl FilmPaths {
    /// Names of the pictures, as FFmpeg reads them.
    pub(super) const PATTERN: &str = "frame_%04d.png";

    /// Returns the places for a name with the extension of a film.
    fn of(film: &Path) -> Option<Self> {
        let mut name = film.file_name()?.to_owned();
        name.push(".frames");
        let is_film = ["mp4", "mkv"].iter().any(|it| film.extension().is_some_and(|own| own.eq_ignore_ascii_case(it)));
        (is_film && !film.is_dir()).then(|| Self { film: film.to_owned(), folder: film.with_file_name(name) })
    }

    pub(super) fn is_matroska(&self) -> bool {
        self.film.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mkv"))
    }
}

/// What the pictures show, which decides their names.
#[derive(Clone, Debug)]
pub(super) enum Content {
    Eyes(EyesArguments),
    /// Quilts with this number of columns and of rows, and the quality of JPEG files.
    Quilt([u32; 2], Fan, u8),
}

/// A rendered picture of the sequence.
pub(super) enum Rendered<'a> {
    Pair(&'a StereoPair, &'a EyesArguments),
    /// A quilt, and the quality of a JPEG file.
    Quilt(Picture, u8),
}

impl Names {
    /// Interprets the value of --out. The folder of a film's pictures is not made yet.
    pub(super) fn of(out: &Path) -> Result<Self, Usage> {
        if out.as_os_str() == "-" {
            return Ok(Self::Stdout);
        }
        if let Some(paths) = FilmPaths::of(out) {
            prepare_file(&paths.film)?;
            return Ok(Self::Film(paths));
        }
        let target = Target::of(out)?;
        let Target::File(file) = target else { return Ok(Self::Folder(out.to_owned())) };
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let parts = name.split_once('%').and_then(|(before, rest)| {
            let (digits, behind) = rest.split_once('d')?;
            let digits = if digits.is_empty() { Some(1) } else { digits.parse().ok() };
            digits.filter(|digits| *digits <= 9).map(|digits| (before.to_owned(), digits, behind.to_owned()))
        });
        let Some((before, digits, behind)) = parts else {
            let advice = "give a name with a number format, like frame_%04d.png, or a folder";
            return Err(Usage(format!("{}: several pictures can't share one name; {advice}", shown(&file))));
        };
        Ok(Self::Numbered { folder: file.parent().unwrap_or(Path::new("")).to_owned(), before, digits, behind })
    }

    /// Returns the folder of the pictures.
    pub(super) fn folder(&self) -> Option<&Path> {
        match self {
            Self::Folder(folder) | Self::Numbered { folder, .. } | Self::Film(FilmPaths { folder, .. }) => Some(folder),
            Self::Stdout => None,
        }
    }

    /// Returns the files of a picture.
    pub(super) fn files(&self, frame: u32, content: &Content) -> Vec<PathBuf> {
        match (self, content) {
            (Self::Folder(folder), Content::Eyes(eyes)) => {
                let both = eyes.packing.map_or("anaglyph".into(), |packing| packing.to_string());
                ["left", "right", &both].map(|name| folder.join(format!("{name}_{frame:04}.png"))).to_vec()
            }
            (Self::Folder(folder), Content::Quilt(..)) => vec![folder.join(format!("quilt_{frame:04}.png"))],
            (Self::Numbered { folder, before, digits, behind }, _) => {
                let digits = *digits;
                vec![folder.join(format!("{before}{frame:0digits$}{behind}"))]
            }
            (Self::Film(paths), _) => {
                vec![paths.folder.join(FilmPaths::PATTERN.replace("%04d", &format!("{frame:04}")))]
            }
            (Self::Stdout, _) => Vec::new(),
        }
    }

    pub(super) fn are_there(&self, frame: u32, content: &Content) -> bool {
        self.files(frame, content).iter().all(|file| file.exists())
    }
}

impl Rendered<'_> {
    /// Writes the picture's files and those of the batch, or none. Without files, its pixels go to standard output.
    /// Returns the size of the picture of all views.
    pub(super) fn write(&self, mut batch: Batch, files: &[PathBuf]) -> Result<[u32; 2], Box<dyn Error>> {
        let whole = match self {
            Self::Pair(pair, eyes) => &eyes.picture(&pair.left, &pair.right),
            Self::Quilt(quilt, _) => quilt,
        };
        match (self, files) {
            (_, []) => print_rgb(whole)?,
            (Self::Pair(pair, eyes), [one]) => add_pair(&mut batch, one, pair, None, eyes)?,
            (Self::Pair(pair, eyes), files) => {
                let (left, right) = eyes.ordered(&pair.left, &pair.right);
                for (file, picture) in files.iter().zip([&left.picture(), &right.picture(), whole]) {
                    batch.add_png(file, picture)?;
                }
            }
            (Self::Quilt(quilt, quality), [file, ..]) => add_picture(&mut batch, file, quilt, *quality)?,
        }
        batch.commit()?;
        Ok([whole.width, whole.height])
    }
}

/// Writes a picture's red, green and blue to standard output.
fn print_rgb(picture: &Picture) -> Result<(), String> {
    let rgb: Vec<u8> = picture.rgba8.iter().flat_map(|[red, green, blue, _]| [*red, *green, *blue]).collect();
    io::stdout().write_all(&rgb).map_err(|error| format!("standard output: {error}"))
}

/// Returns whether a folder has this record of its pictures' settings and inputs.
pub(super) fn is_recorded(record: &Value, folder: &Path) -> bool {
    let found = fs::read(folder.join(RECORD)).ok().and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
    found.is_some_and(|found| found == *record)
}

/// Writes the record of the pictures' settings and inputs. If the folder has the same record, its pictures are kept.
/// Pictures of another record are an error. With `overwrite` they are removed first, so that an interrupted sequence
/// does not contain them.
pub(super) fn keep(
    record: &Value,
    folder: &Path,
    overwrite: bool,
    there: impl FnOnce() -> Vec<PathBuf>,
) -> Result<(), Box<dyn Error>> {
    if is_recorded(record, folder) && !overwrite {
        return Ok(());
    }
    for picture in there().into_iter().filter(|picture| picture.exists()) {
        if !overwrite {
            let advice = "was made with different files, settings or version; use another folder, or --overwrite";
            return Err(format!("{}: it {advice}", shown(&picture)).into());
        }
        fs::remove_file(&picture).map_err(|error| format!("{}: {error}", shown(&picture)))?;
    }
    Ok(write_whole(folder.join(RECORD), format!("{record:#}\n").as_bytes())?)
}
