//! The pictures of a pair, written as its rows arrive.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use stereotrace::{
    Pose, View,
    output::{Batch, Combination, PairRows, Picture, PngRows},
};

use crate::target::{EyesArguments, Target, add_picture, is_png, is_single_picture};

/// Picture files of a pair, and what its views show.
pub(crate) struct Pictures {
    files: Vec<PictureFile>,
    eyes: EyesArguments,
    pub(crate) seen: Seen,
}

/// Depths that the views show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// Nearest and farthest depth that either eye sees, in world units. The farthest is infinite if there is sky.
    pub(crate) depths: (f32, f32),
    /// Whether the left eye sees only sky.
    pub(crate) only_sky: bool,
}

struct PictureFile {
    content: Content,
    to: Destination,
}

/// The views in a picture.
enum Content {
    Left,
    Right,
    Both(PairRows),
}

enum Destination {
    Png(Box<PngRows>),
    /// A file in a format that is written from a whole picture.
    Whole(PathBuf, Picture),
}

impl Pictures {
    /// Creates the pictures of a target: a folder's left view, right view, anaglyph and packing, or the picture of both
    /// views. A file of another kind has none.
    pub(crate) fn new(
        target: &Target,
        eyes: &EyesArguments,
        pose: &Pose,
        scene: &str,
    ) -> Result<Self, stereotrace::Error> {
        let of_both = |path: &Path, combination| PictureFile::of_both(path, combination, pose.size);
        let files = match target {
            Target::File(path) if is_single_picture(path) => vec![of_both(path, eyes.combination())?],
            Target::File(_) => Vec::new(),
            Target::Folder(folder) => {
                let mut files = vec![
                    PictureFile::of_view(&folder.join("left.png"), Content::Left, pose)?,
                    PictureFile::of_view(&folder.join("right.png"), Content::Right, pose)?,
                    of_both(&folder.join("anaglyph.png"), Combination::Anaglyph(eyes.anaglyph))?,
                ];
                if let Some(packing) = eyes.packing {
                    let name = EyesArguments::packed_name(packing, pose, scene) + ".png";
                    files.push(of_both(&folder.join(name), Combination::Packed(packing))?);
                }
                files
            }
        };
        let seen = Seen { depths: (f32::INFINITY, 0.0), only_sky: true };
        Ok(Self { files, eyes: eyes.clone(), seen })
    }

    /// Takes the next rows of both views.
    pub(crate) fn write(&mut self, left: &View, right: &View) -> Result<(), stereotrace::Error> {
        let ranges = [left, right].map(View::depth_range);
        for (near, far) in ranges {
            let depths = &mut self.seen.depths;
            *depths = (depths.0.min(near), depths.1.max(far));
        }
        self.seen.only_sky &= ranges[0].0 == f32::INFINITY;
        let (left, right) = self.eyes.ordered(left, right);
        self.files.iter_mut().try_for_each(|file| file.write(left, right))
    }

    /// Adds the files to the batch, when all rows have been taken.
    pub(crate) fn add_to(self, batch: &mut Batch) -> Result<(), Box<dyn Error>> {
        for PictureFile { content, mut to } in self.files {
            if let Content::Both(both) = content {
                to.write(&both.rest())?;
            }
            match to {
                Destination::Png(rows) => batch.add_png_rows(*rows)?,
                Destination::Whole(path, picture) => add_picture(batch, &path, &picture, self.eyes.quality)?,
            }
        }
        Ok(())
    }
}

impl PictureFile {
    /// Creates a PNG file of a view, which names the projection of equirectangular pictures.
    fn of_view(path: &Path, content: Content, pose: &Pose) -> Result<Self, stereotrace::Error> {
        let [width, height] = pose.size;
        let rows = match pose.projection.equirectangular() {
            None => PngRows::new(path, width, height)?,
            Some(_) => PngRows::panorama(path, pose)?,
        };
        Ok(Self { content, to: Destination::Png(Box::new(rows)) })
    }

    fn of_both(path: &Path, combination: Combination, size: [u32; 2]) -> Result<Self, stereotrace::Error> {
        let [width, height] = combination.size(size);
        let to = match is_png(path) {
            true => Destination::Png(Box::new(PngRows::new(path, width, height)?)),
            false => Destination::Whole(
                path.into(),
                Picture::new(width, height, Vec::with_capacity(width as usize * height as usize)),
            ),
        };
        Ok(Self { content: Content::Both(PairRows::new(combination, size)), to })
    }

    fn write(&mut self, left: &View, right: &View) -> Result<(), stereotrace::Error> {
        match &mut self.content {
            Content::Left => self.to.write(&left.rgba8),
            Content::Right => self.to.write(&right.rgba8),
            Content::Both(both) => self.to.write(&both.next(left, right)),
        }
    }
}

impl Destination {
    fn write(&mut self, pixels: &[[u8; 4]]) -> Result<(), stereotrace::Error> {
        match self {
            Self::Png(rows) => rows.write(pixels),
            Self::Whole(_, picture) => {
                picture.rgba8.extend(pixels);
                Ok(())
            }
        }
    }
}
