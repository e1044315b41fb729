//! Writes pictures and maps in their file formats.

use std::path::Path;

use super::{Batch, write_whole};
#[cfg(feature = "png")]
use super::{Picture, PngRows};
use crate::{Error, MISS, View, message::counted};

/// All whole numbers up to this one are exact in f32.
const LARGEST_EXACT_ID: u32 = 1 << 24;

/// Writes one number per pixel as a grey PFM picture. `values` are row-major, `[height][width]`, top row first; the
/// file holds little-endian f32, bottom row first. Unknown values are `f32::INFINITY`.
///
/// # Errors
/// [`Error::Io`] if there are not `width * height` values, or the file cannot be written.
pub fn save_pfm(path: impl AsRef<Path>, width: u32, height: u32, values: &[f32]) -> Result<(), Error> {
    let path = path.as_ref();
    write_whole(path, &pfm(path, width, height, values)?)
}

/// Writes one id per pixel in the format of [`save_pfm`]; [`MISS`] becomes -1.
///
/// # Errors
/// Those of [`save_pfm`], and [`Error::Io`] naming an id over 2^24, above which f32 skips whole numbers.
pub fn save_ids_pfm(path: impl AsRef<Path>, width: u32, height: u32, ids: &[u32]) -> Result<(), Error> {
    let path = path.as_ref();
    save_pfm(path, width, height, &id_values(path, ids)?)
}

/// Returns the bytes of a PFM picture; `path` is for errors.
fn pfm(path: &Path, width: u32, height: u32, values: &[f32]) -> Result<Vec<u8>, Error> {
    check_count(path, width, height, values.len())?;
    Ok(pfm_bytes("Pf", [width, height], values, 1))
}

/// Returns the bytes of a PFM picture with `of_pixel` values per pixel.
fn pfm_bytes(kind: &str, [width, height]: [u32; 2], values: &[f32], of_pixel: usize) -> Vec<u8> {
    let mut bytes = format!("{kind}\n{width} {height}\n-1.0\n").into_bytes();
    bytes.reserve(4 * values.len());
    for row in values.chunks_exact((of_pixel * width as usize).max(1)).rev() {
        bytes.extend(row.iter().flat_map(|value| value.to_le_bytes()));
    }
    bytes
}

/// Converts ids to the values of a PFM picture.
fn id_values(path: &Path, ids: &[u32]) -> Result<Vec<f32>, Error> {
    let number = |&id: &u32| match id {
        MISS => Ok(-1.0),
        0..=LARGEST_EXACT_ID => Ok(id as f32),
        _ => Err(Error::unwritable(
            path,
            format!("id {id} is over {LARGEST_EXACT_ID}, the largest that a PFM file's f32 holds exactly"),
        )),
    };
    ids.iter().map(number).collect()
}

pub(super) fn check_count(path: &Path, width: u32, height: u32, count: usize) -> Result<(), Error> {
    if u64::from(width) * u64::from(height) == count as u64 {
        return Ok(());
    }
    let pixels = counted(count, "pixel", "pixels");
    Err(Error::unwritable(path, format!("a picture of {width}x{height} cannot be written from {pixels}")))
}

impl View {
    /// Writes [`View::primitive`] as a PFM picture, with -1 for misses ([`save_ids_pfm`]).
    ///
    /// # Errors
    /// Those of [`save_ids_pfm`].
    pub fn save_primitive_ids(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        save_ids_pfm(path, self.width, self.height, &self.primitive)
    }

    /// Writes [`View::object`] as a PFM picture, with -1 for misses ([`save_ids_pfm`]).
    ///
    /// # Errors
    /// Those of [`save_ids_pfm`].
    pub fn save_object_ids(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        save_ids_pfm(path, self.width, self.height, &self.object)
    }

    /// Writes [`View::depth`] in world units as a PFM picture, with infinity for misses ([`save_pfm`]).
    ///
    /// # Errors
    /// Those of [`save_pfm`].
    pub fn save_depth(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        save_pfm(path, self.width, self.height, &self.depth)
    }
}

#[cfg(feature = "png")]
impl Picture {
    /// Writes the picture as a PNG file with 8 bits per channel, marked as sRGB.
    ///
    /// # Errors
    /// [`Error::Io`] if there are not `width * height` pixels or none at all, or the file cannot be written.
    pub fn save_png(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let mut batch = Batch::new();
        batch.add_png(path, self)?;
        batch.commit().map(drop)
    }
}

/// Sample format of a PNG file.
#[cfg(feature = "png")]
pub(super) struct PngKind {
    pub(super) color: png::ColorType,
    pub(super) depth: png::BitDepth,
    /// Whether the file is marked as sRGB. It is false for samples that are not colours.
    pub(super) is_srgb: bool,
}

#[cfg(feature = "png")]
impl PngKind {
    pub(super) fn encoder<W: std::io::Write>(&self, to: W, width: u32, height: u32) -> png::Encoder<'static, W> {
        let mut encoder = png::Encoder::new(to, width, height);
        encoder.set_color(self.color);
        encoder.set_depth(self.depth);
        encoder.set_compression(png::Compression::Fast);
        if self.is_srgb {
            encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        }
        encoder
    }
}

/// Returns the bytes of a PNG file with these samples. 16-bit samples are big-endian.
#[cfg(feature = "png")]
pub(super) fn png_bytes(path: &Path, width: u32, height: u32, kind: PngKind, samples: &[u8]) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let written = kind.encoder(&mut bytes, width, height).write_header().and_then(|mut writer| {
        writer.write_image_data(samples)?;
        writer.finish()
    });
    written.map_err(|error| Error::unwritable(path, error))?;
    Ok(bytes)
}

impl Batch {
    /// Adds a picture in the format of [`Picture::save_png`].
    ///
    /// # Errors
    /// Those of [`Picture::save_png`].
    #[cfg(feature = "png")]
    pub fn add_png(&mut self, path: impl AsRef<Path>, picture: &Picture) -> Result<(), Error> {
        let mut rows = PngRows::new(path, picture.width, picture.height)?;
        rows.write(&picture.rgba8)?;
        self.add_png_rows(rows)
    }

    /// Adds one number per pixel in the format of [`save_pfm`], for example depths, distances, or disparities in
    /// Middlebury's convention.
    ///
    /// # Errors
    /// Those of [`save_pfm`].
    pub fn add_pfm(&mut self, path: impl AsRef<Path>, width: u32, height: u32, values: &[f32]) -> Result<(), Error> {
        let path = path.as_ref();
        self.add(path, &pfm(path, width, height, values)?)
    }

    /// Adds ids as Scene Flow's indices: 0 for [`MISS`], else the id + 1.
    ///
    /// # Errors
    /// Those of [`save_pfm`], and [`Error::Io`] naming an index over 2^24, which f32 does not hold exactly.
    #[cfg(feature = "png")] // used by data set layouts
    pub(crate) fn add_indices_pfm(
        &mut self,
        path: impl AsRef<Path>,
        width: u32,
        height: u32,
        ids: &[u32],
    ) -> Result<(), Error> {
        let indices = Vec::from_iter(ids.iter().map(|id| id.wrapping_add(1)));
        let values = id_values(path.as_ref(), &indices)?;
        self.add_pfm(path, width, height, &values)
    }

    /// Adds three numbers per pixel, such as normals, as a colour PFM picture (`PF`), otherwise in the format of
    /// [`save_pfm`].
    ///
    /// # Errors
    /// Those of [`save_pfm`].
    pub fn add_pfm_color(
        &mut self,
        path: impl AsRef<Path>,
        width: u32,
        height: u32,
        values: &[[f32; 3]],
    ) -> Result<(), Error> {
        let path = path.as_ref();
        check_count(path, width, height, values.len())?;
        self.add(path, &pfm_bytes("PF", [width, height], values.as_flattened(), 3))
    }

    /// Adds a view's depths in the format of [`View::save_depth`].
    ///
    /// # Errors
    /// Those of [`View::save_depth`].
    pub fn add_depth(&mut self, path: impl AsRef<Path>, view: &View) -> Result<(), Error> {
        let path = path.as_ref();
        self.add(path, &pfm(path, view.width, view.height, &view.depth)?)
    }

    /// Adds a view's primitive ids in the format of [`View::save_primitive_ids`].
    ///
    /// # Errors
    /// Those of [`View::save_primitive_ids`].
    pub fn add_primitive_ids(&mut self, path: impl AsRef<Path>, view: &View) -> Result<(), Error> {
        let path = path.as_ref();
        self.add(path, &pfm(path, view.width, view.height, &id_values(path, &view.primitive)?)?)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::tests::view;
    use super::*;
    use crate::folder::Folder;

    /// Reads a grey PFM file by the format's definition. Returns width, height, and the values with the top row first.
    fn read_pfm(path: &Path) -> (usize, usize, Vec<f32>) {
        let bytes = fs::read(path).unwrap();
        let mut lines = bytes.splitn(4, |&byte| byte == b'\n');
        let mut line = || lines.next().unwrap();
        assert_eq!(line(), b"Pf");
        let size = String::from_utf8(line().to_vec()).unwrap();
        let (width, height) = size.split_once(' ').unwrap();
        let (width, height): (usize, usize) = (width.parse().unwrap(), height.parse().unwrap());
        let scale: f32 = String::from_utf8(line().to_vec()).unwrap().parse().unwrap();
        assert!(scale < 0.0, "little-endian");
        let data = line();
        assert_eq!(data.len(), 4 * width * height);
        let at = |index: usize| f32::from_le_bytes(std::array::from_fn(|byte| data[4 * index + byte]));
        let turned = (0..height).flat_map(|y| (0..width).map(move |x| (height - 1 - y) * width + x));
        (width, height, turned.map(at).collect())
    }

    #[test]
    fn a_pfm_reads_back_and_its_bytes_are_as_specified() {
        let folder = Folder::new("pfm");
        let values = [1.5, -2.0, f32::INFINITY, 0.0, 1e-30, 6.25];
        let path = folder.file("a.pfm");
        save_pfm(&path, 3, 2, &values).unwrap();
        assert_eq!(read_pfm(&path), (3, 2, values.to_vec()));
        // The bytes are compared too, since a reader with the same wrong row order would hide the fault. The bottom row
        // comes first.
        let mut expected = b"Pf\n3 2\n-1.0\n".to_vec();
        expected.extend([0.0_f32, 1e-30, 6.25, 1.5, -2.0, f32::INFINITY].iter().flat_map(|v| v.to_le_bytes()));
        assert_eq!(fs::read(&path).unwrap(), expected);
        assert_eq!(folder.names(), ["a.pfm"]);
    }

    #[test]
    fn a_pfm_in_colour_has_three_values_a_pixel_and_its_bottom_row_first() {
        let folder = Folder::new("pfm_color");
        let path = folder.file("a.pfm");
        let mut batch = Batch::new();
        batch.add_pfm_color(&path, 1, 2, &[[1.0, 2.0, 3.0], [-1.0, -2.0, -3.0]]).unwrap();
        let message = batch.add_pfm_color(folder.file("b.pfm"), 2, 2, &[[0.0; 3]; 3]).unwrap_err().to_string();
        assert!(message.ends_with("b.pfm: a picture of 2x2 cannot be written from 3 pixels"), "{message}");
        batch.commit().unwrap();
        let mut expected = b"PF\n1 2\n-1.0\n".to_vec();
        expected.extend([-1.0_f32, -2.0, -3.0, 1.0, 2.0, 3.0].iter().flat_map(|v| v.to_le_bytes()));
        assert_eq!(fs::read(&path).unwrap(), expected);
    }

    #[test]
    fn a_wrong_number_of_values_is_an_error_and_writes_nothing() {
        let folder = Folder::new("count");
        let message = save_pfm(folder.file("a.pfm"), 2, 2, &[0.0; 3]).unwrap_err().to_string();
        assert!(message.contains("a.pfm: a picture of 2x2 cannot be written from 3 pixels"), "{message}");
        assert!(save_pfm(folder.file("a.pfm"), u32::MAX, u32::MAX, &[0.0]).is_err());
        assert!(folder.names().is_empty());
    }

    #[test]
    fn ids_are_exact_or_refused() {
        let folder = Folder::new("ids");
        let mut view = view(1, &[[0; 3]; 3]);
        view.primitive = vec![0, MISS, 1 << 24];
        view.object = vec![4, MISS, (1 << 24) + 1];
        let path = folder.file("ids.pfm");
        view.save_primitive_ids(&path).unwrap();
        assert_eq!(read_pfm(&path), (1, 3, vec![0.0, -1.0, 16_777_216.0]));
        let message = view.save_object_ids(folder.file("objects.pfm")).unwrap_err().to_string();
        assert!(message.contains("objects.pfm: id 16777217 is over 16777216"), "{message}");
        view.save_depth(&path).unwrap();
        assert_eq!(read_pfm(&path), (1, 3, vec![f32::INFINITY; 3]));
        assert_eq!(folder.names(), ["ids.pfm"]);
    }

    #[cfg(feature = "png")]
    #[test]
    fn a_png_reads_back_as_it_was() {
        let folder = Folder::new("png");
        let rgba8: Vec<_> = (0..6).map(|i| [40 * i, 255 - i, i, 255]).collect();
        let path = folder.file("a.png");
        Picture { width: 3, height: 2, rgba8: rgba8.clone() }.save_png(&path).unwrap();
        let read = image::open(&path).unwrap().into_rgba8();
        assert_eq!((read.width(), read.height()), (3, 2));
        assert_eq!(read.as_raw(), rgba8.as_flattened());
        // The PNG standard's sRGB chunk has one byte, the rendering intent: relative colorimetric.
        assert!(fs::read(&path).unwrap().windows(9).any(|part| part == b"\0\0\0\x01sRGB\x01"));
        assert_eq!(folder.names(), ["a.png"]);
    }

    #[cfg(feature = "png")]
    #[test]
    fn a_batch_writes_what_each_picture_writes_alone() {
        let folder = Folder::new("kinds");
        let mut view = view(2, &[[1, 2, 3], [4, 5, 6]]);
        view.primitive = vec![7, MISS];
        let picture = view.picture();
        picture.save_png(folder.file("a.png")).unwrap();
        view.save_depth(folder.file("a.depth")).unwrap();
        view.save_primitive_ids(folder.file("a.ids")).unwrap();
        let mut batch = Batch::new();
        batch.add_png(folder.file("b.png"), &picture).unwrap();
        batch.add_depth(folder.file("b.depth"), &view).unwrap();
        batch.add_primitive_ids(folder.file("b.ids"), &view).unwrap();
        batch.commit().unwrap();
        for kind in ["png", "depth", "ids"] {
            let read = |name: &str| fs::read(folder.file(&format!("{name}.{kind}"))).unwrap();
            assert_eq!(read("a"), read("b"), "{kind}");
        }
    }

    #[cfg(feature = "png")]
    #[test]
    fn a_picture_of_no_size_or_the_wrong_one_is_an_error() {
        let folder = Folder::new("empty");
        let path = folder.file("a.png");
        assert!(Picture { width: 0, height: 0, rgba8: vec![] }.save_png(&path).is_err());
        assert!(Picture { width: 2, height: 2, rgba8: vec![[0; 4]; 3] }.save_png(&path).is_err());
        assert!(folder.names().is_empty());
    }
}
