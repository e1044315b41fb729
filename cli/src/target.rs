//! Writes output files and folders, and combines both eyes into one picture.

use std::{
    error::Error,
    fs, io,
    path::{Path, PathBuf},
};

use clap::Args;
use stereotrace::{
    Equirectangular, GroundTruth, Pose, Span, StereoPair, View,
    output::{Anaglyph, Batch, Combination, ExrColor, Packing, Picture},
};

use crate::{shown, usage::Usage};

/// File name extensions of pictures that can be written.
const WRITTEN: [&str; 6] = ["png", "jpg", "jpeg", "jps", "mpo", "exr"];
/// File name extensions of pictures that can't be written. They are refused, since they would otherwise become names of
/// folders.
const NOT_WRITTEN: [&str; 11] = ["avif", "bmp", "gif", "hdr", "heic", "mkv", "mp4", "tga", "tif", "tiff", "webp"];

/// Options that combine both eyes into one picture.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "How to view it")]
pub(crate) struct EyesArguments {
    /// Colours of the anaglyph: dubois or dubois-lcd (red-cyan with little ghosting), grey, colour, half-colour,
    /// green-magenta or amber-blue
    #[arg(long, value_name = "KIND", default_value_t)]
    pub(crate) anaglyph: Anaglyph,
    /// Place the eyes side by side, or by another packing, instead of an anaglyph: side-by-side, half-side-by-side,
    /// cross-eyed, top-bottom, half-top-bottom, row-interlaced, column-interlaced or checkerboard
    ///
    /// By default it is top-bottom for --projection 360, and side-by-side for 180.
    #[arg(long, value_name = "KIND", conflicts_with = "anaglyph")]
    pub(crate) packing: Option<Packing>,
    /// Exchange the eyes in all output except the re-trace and shadow maps
    #[arg(long)]
    pub(crate) swap: bool,
    /// Quality of JPEG, JPS and MPO files, 1 to 100
    #[arg(long, value_name = "Q", default_value_t = 92, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) quality: u8,
}

impl EyesArguments {
    /// Returns the views in the order of output: left, right; exchanged by --swap.
    pub(crate) fn ordered<'a>(&self, left: &'a View, right: &'a View) -> (&'a View, &'a View) {
        if self.swap { (right, left) } else { (left, right) }
    }

    /// Returns these options with the packing that players of equirectangular pictures expect, unless one is given.
    pub(crate) fn suiting(&self, pose: &Pose) -> Self {
        let usual = |around: Equirectangular| match around.span {
            Span::Full => Packing::TopBottom,
            Span::Half => Packing::SideBySide,
        };
        Self { packing: self.packing.or(pose.projection.equirectangular().map(usual)), ..self.clone() }
    }

    /// Returns the name of the file with the packing of a scene's views, without its extension. Players of
    /// equirectangular pictures read the projection and the packing from the name.
    pub(crate) fn packed_name(packing: Packing, pose: &Pose, scene: &str) -> String {
        let Some(Equirectangular { span, .. }) = pose.projection.equirectangular() else { return packing.to_string() };
        let tag = match (span, packing) {
            (Span::Full, Packing::TopBottom) => "360_TB".into(),
            (Span::Full, Packing::SideBySide) => "360_LR".into(),
            (Span::Half, Packing::TopBottom) => "180x180_3dv".into(),
            (Span::Half, Packing::SideBySide) => "180x180_3dh".into(),
            (Span::Full, other) => format!("360_{other}"),
            (Span::Half, other) => format!("180x180_{other}"),
        };
        format!("{scene}_{tag}")
    }

    /// Returns how one picture shows both views: by the packing if one is given, else as an anaglyph.
    pub(crate) fn combination(&self) -> Combination {
        self.packing.map_or(Combination::Anaglyph(self.anaglyph), Combination::Packed)
    }

    /// Returns one picture of both views.
    pub(crate) fn picture(&self, left: &View, right: &View) -> Picture {
        let (left, right) = self.ordered(left, right);
        self.combination().picture(left, right)
    }
}

/// Destination of output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// Several files in a folder.
    Folder(PathBuf),
    /// One file.
    File(PathBuf),
}

impl Target {
    /// Interprets a name with a picture's extension as a file, unless a folder of that name exists. All other names are
    /// folders, which are created.
    ///
    /// # Errors
    /// Fails if a picture can't be written there, or not in the format of that extension.
    pub(crate) fn of(path: &Path) -> Result<Self, Usage> {
        let ending = ending(path);
        if !path.is_dir() && WRITTEN.contains(&&*ending) {
            prepare_file(path)?;
            return Ok(Self::File(path.to_owned()));
        }
        if !path.is_dir() && NOT_WRITTEN.contains(&&*ending) {
            let endings = WRITTEN.join(", .");
            return Err(Usage(format!("{}: pictures can be written as .{endings}", shown(path))));
        }
        make_folder(path)?;
        check_writable(path, path)?;
        Ok(Self::Folder(path.to_owned()))
    }
}

/// Creates the folder of a file, and checks that the file can be written.
pub(crate) fn prepare_file(path: &Path) -> Result<(), Usage> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        make_folder(folder)?;
    }
    check_writable(path.parent().unwrap_or(path), path)
}

/// Creates a file in the folder and removes it, so that an unwritable target fails before rendering.
fn check_writable(folder: &Path, target: &Path) -> Result<(), Usage> {
    let probe = folder.join(format!(".stereotrace-{}", std::process::id()));
    let written = fs::File::create(&probe).and_then(|_| fs::remove_file(&probe));
    written.map_err(|error| Usage(format!("{}: can't write there: {error}", shown(target))))
}

/// Creates the output folder.
pub(crate) fn make_folder(path: &Path) -> Result<(), Usage> {
    let fault = |error: io::Error| match path.exists() {
        true => format!("{}: it is not a folder; --out takes a folder, or a picture's name like pair.png", shown(path)),
        false => format!("{}: the folder can't be created: {error}", shown(path)),
    };
    fs::create_dir_all(path).map_err(|error| Usage(fault(error)))
}

/// Returns a file name's extension in lower case.
fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Returns whether the file name ends in .exr.
pub(crate) fn is_open_exr(path: &Path) -> bool {
    ending(path) == "exr"
}

/// Returns whether the file name ends in .vr.jpg, as the names of VR photos do.
fn is_vr_photo(path: &Path) -> bool {
    ending(path) == "jpg" && ending(Path::new(path.file_stem().unwrap_or_default())) == "vr"
}

/// Returns whether the file name is a PNG file's.
pub(crate) fn is_png(path: &Path) -> bool {
    ending(path) == "png"
}

/// Returns whether the file name is that of one picture, and not of a file that holds both views.
pub(crate) fn is_single_picture(path: &Path) -> bool {
    is_png(path) || ["jpg", "jpeg"].contains(&&*ending(path)) && !is_vr_photo(path)
}

/// Checks that the file name is that of one picture, and not of a file of both eyes.
pub(crate) fn check_one_picture(path: &Path) -> Result<(), Usage> {
    match &*ending(path) {
        "png" | "jpg" | "jpeg" => Ok(()),
        other => Err(Usage(format!("{}: .{other} holds both eyes of a pair, not one picture", shown(path)))),
    }
}

/// Adds a picture to the batch as a PNG or JPEG file, by the extension of its name.
pub(crate) fn add_picture(
    batch: &mut Batch,
    path: &Path,
    picture: &Picture,
    quality: u8,
) -> Result<(), Box<dyn Error>> {
    check_one_picture(path)?;
    match is_png(path) {
        true => batch.add_png(path, picture)?,
        false => batch.add_jpeg(path, picture, quality)?,
    }
    Ok(())
}

/// Adds a file of both eyes to the batch, in the format of its name's extension.
pub(crate) fn add_pair(
    batch: &mut Batch,
    path: &Path,
    pair: &StereoPair,
    truth: Option<&GroundTruth>,
    eyes: &EyesArguments,
) -> Result<(), Box<dyn Error>> {
    let kind = ending(path);
    if kind == "exr" && eyes.swap {
        return Err(format!("{}: its parts are named left and right, so --swap does not apply", shown(path)).into());
    }
    let swapped = || {
        let mut swapped = pair.clone();
        std::mem::swap(&mut swapped.left, &mut swapped.right);
        swapped
    };
    if is_vr_photo(path) {
        let pair = if eyes.swap { &swapped() } else { pair };
        return Ok(batch.add_vr_jpeg(path, pair, eyes.quality)?);
    }
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
