//! Writes ground truth as PNG files of one channel: disparities in KITTI's format, ids, and masks.

use std::path::Path;

use super::{
    Batch,
    file::{PngKind, check_count, png_bytes},
};
use crate::{Error, EyeTruth, MISS, Occlusion};

/// Number of sample values per pixel of disparity.
const KITTI_STEPS: f64 = 256.0;

/// Number of sample values per pixel of disparity in Sintel's format.
const SINTEL_STEPS: f64 = 16_384.0;
/// Disparity in pixels from which Sintel's files can't hold it.
pub(crate) const SINTEL_DISPARITIES: f32 = 1024.0;

/// Largest id that fits 16 bits, since ids are stored as id + 1, and 0 means a miss.
const LARGEST_ID: u32 = u16::MAX as u32 - 1;

impl Batch {
    /// Adds disparities as a 16-bit grey PNG file in KITTI's format: `round(256 d)`, and 0 where `is_valid` is false.
    /// As in KITTI's own code, a positive disparity that would round to 0 becomes 1. Use [`EyeTruth::surfaces`] for
    /// `disp_occ` and [`EyeTruth::surfaces_of_both`] for `disp_noc`. As in KITTI, sky is not valid.
    ///
    /// # Errors
    /// [`Error::Io`], naming the pixel, for a valid disparity that the format can't hold: one of 256 or more, zero or
    /// negative. With off-axis cameras, points on the screen and behind it have disparities of zero or less.
    /// [`Error::Io`] also for lists that are not `width * height` long, and as [`Batch::add`].
    pub fn add_kitti_disparity(
        &mut self,
        path: impl AsRef<Path>,
        width: u32,
        height: u32,
        disparity: &[f32],
        is_valid: &[bool],
    ) -> Result<(), Error> {
        let path = path.as_ref();
        check_count(path, width, height, disparity.len())?;
        check_count(path, width, height, is_valid.len())?;
        let pixels = disparity.iter().zip(is_valid).enumerate();
        let samples = pixels.map(|(index, (&d, &valid))| match valid {
            true => kitti_sample(d).map_err(|reason| {
                let (column, row) = (index % width as usize, index / width as usize);
                Error::unwritable(path, format!("disparity {d} px at column {column}, row {row} {reason}"))
            }),
            false => Ok(0),
        });
        self.add_grey16(path, width, height, &samples.collect::<Result<Vec<_>, _>>()?)
    }

    /// Adds disparities as an 8-bit colour PNG file in Sintel's format: red, green and blue are the bytes of
    /// `round(16384 d)`, the highest first. Readers compute `4 r + g / 64 + b / 16384`.
    ///
    /// # Errors
    /// [`Error::Io`], naming the pixel, for a disparity that the format can't hold: one of 1024 or more, a negative one
    /// or NaN. [`Error::Io`] also for a list that is not `width * height` long, and as [`Batch::add`].
    pub fn add_sintel_disparity(
        &mut self,
        path: impl AsRef<Path>,
        width: u32,
        height: u32,
        disparity: &[f32],
    ) -> Result<(), Error> {
        let path = path.as_ref();
        check_count(path, width, height, disparity.len())?;
        let samples = disparity.iter().enumerate().map(|(index, &d)| {
            let steps = (f64::from(d) * SINTEL_STEPS).round();
            if (0.0..SINTEL_STEPS * f64::from(SINTEL_DISPARITIES)).contains(&steps) {
                let [_, bytes @ ..] = (steps as u32).to_be_bytes();
                return Ok(bytes);
            }
            let (column, row) = (index % width as usize, index / width as usize);
            let reason = "is not between 0 and 1024, so Sintel's PNG file can't hold it; write a PFM file";
            Err(Error::unwritable(path, format!("disparity {d} px at column {column}, row {row} {reason}")))
        });
        let samples = samples.collect::<Result<Vec<[u8; 3]>, _>>()?;
        let kind = PngKind { color: png::ColorType::Rgb, depth: png::BitDepth::Eight, is_srgb: false };
        self.add(path, &png_bytes(path, width, height, kind, samples.as_flattened())?)
    }

    /// Adds ids as a 16-bit grey PNG file: 0 for [`MISS`], else the id + 1.
    ///
    /// # Errors
    /// [`Error::Io`], naming an id over 65,534, which does not fit; for a list that is not `width * height` long; and
    /// as [`Batch::add`].
    pub fn add_ids_png(&mut self, path: impl AsRef<Path>, width: u32, height: u32, ids: &[u32]) -> Result<(), Error> {
        let path = path.as_ref();
        check_count(path, width, height, ids.len())?;
        let sample = |&id: &u32| match id {
            MISS => Ok(0),
            0..=LARGEST_ID => Ok(id as u16 + 1),
            _ => Err(Error::unwritable(
                path,
                format!(
                    "id {id} is over {LARGEST_ID}, the largest that a PNG file of 16 bits holds; an OpenEXR file \
                     (Batch::add_exr) holds every id, a PFM file (save_ids_pfm) those up to 16777216"
                ),
            )),
        };
        self.add_grey16(path, width, height, &ids.iter().map(sample).collect::<Result<Vec<_>, _>>()?)
    }

    /// Adds a visibility mask like Middlebury's `mask0nocc.png`: 255 where the other eye sees the same point, 128 where
    /// the point is hidden or outside the other picture. The value 0, for unknown, is not used. Sky is treated like any
    /// point.
    ///
    /// # Errors
    /// [`Error::Io`] for a list that is not `width * height` long, and as [`Batch::add`].
    pub fn add_nocc_mask(&mut self, path: impl AsRef<Path>, truth: &EyeTruth) -> Result<(), Error> {
        let grey = |found: &Occlusion| if *found == Occlusion::Visible { 255 } else { 128 };
        self.add_grey8(path.as_ref(), [truth.width, truth.height], &Vec::from_iter(truth.occlusion.iter().map(grey)))
    }

    /// Adds the mask of [`Batch::add_nocc_mask`] with 0, for unknown, at sky. Use this mask with disparities that leave
    /// sky unknown.
    pub(crate) fn add_known_nocc_mask(&mut self, path: impl AsRef<Path>, truth: &EyeTruth) -> Result<(), Error> {
        let pixels = truth.occlusion.iter().zip(truth.surfaces());
        let grey = pixels.map(|(found, is_surface)| match (is_surface, found) {
            (false, _) => 0,
            (true, Occlusion::Visible) => 255,
            (true, _) => 128,
        });
        self.add_grey8(path.as_ref(), [truth.width, truth.height], &Vec::from_iter(grey))
    }

    /// Adds an occlusion mask: 0 where the other eye sees the point, 255 where a surface hides it, 128 where it lies
    /// outside the other picture.
    ///
    /// # Errors
    /// As [`Batch::add_nocc_mask`].
    pub fn add_occlusion(&mut self, path: impl AsRef<Path>, truth: &EyeTruth) -> Result<(), Error> {
        let grey = |found: &Occlusion| match found {
            Occlusion::Visible => 0,
            Occlusion::Hidden => 255,
            Occlusion::OutOfFrame => 128,
        };
        self.add_grey8(path.as_ref(), [truth.width, truth.height], &Vec::from_iter(truth.occlusion.iter().map(grey)))
    }

    /// Adds a sky mask: 255 at sky, else 0.
    ///
    /// # Errors
    /// As [`Batch::add_nocc_mask`].
    pub fn add_sky_mask(&mut self, path: impl AsRef<Path>, truth: &EyeTruth) -> Result<(), Error> {
        self.add_mask(path, [truth.width, truth.height], &truth.sky())
    }

    /// Adds a mask as an 8-bit grey PNG file: 255 where it is true, else 0.
    pub(crate) fn add_mask(&mut self, path: impl AsRef<Path>, size: [u32; 2], mask: &[bool]) -> Result<(), Error> {
        let grey = mask.iter().map(|&is_set| if is_set { 255 } else { 0 });
        self.add_grey8(path.as_ref(), size, &Vec::from_iter(grey))
    }

    /// Adds an 8-bit grey PNG file.
    pub(crate) fn add_grey8(&mut self, path: &Path, size: [u32; 2], samples: &[u8]) -> Result<(), Error> {
        let [width, height] = size;
        check_count(path, width, height, samples.len())?;
        let kind = PngKind { color: png::ColorType::Grayscale, depth: png::BitDepth::Eight, is_srgb: false };
        self.add(path, &png_bytes(path, width, height, kind, samples)?)
    }

    /// Adds a 16-bit colour PNG file; `samples` must have `width * height` entries.
    pub(super) fn add_rgb16(
        &mut self,
        path: &Path,
        [width, height]: [u32; 2],
        samples: &[[u16; 3]],
    ) -> Result<(), Error> {
        let kind = PngKind { color: png::ColorType::Rgb, depth: png::BitDepth::Sixteen, is_srgb: false };
        let bytes: Vec<u8> = samples.as_flattened().iter().flat_map(|sample| sample.to_be_bytes()).collect();
        self.add(path, &png_bytes(path, width, height, kind, &bytes)?)
    }

    /// Adds a 16-bit grey PNG file; `samples` must have `width * height` entries.
    fn add_grey16(&mut self, path: &Path, width: u32, height: u32, samples: &[u16]) -> Result<(), Error> {
        let kind = PngKind { color: png::ColorType::Grayscale, depth: png::BitDepth::Sixteen, is_srgb: false };
        let bytes: Vec<u8> = samples.iter().flat_map(|sample| sample.to_be_bytes()).collect();
        self.add(path, &png_bytes(path, width, height, kind, &bytes)?)
    }
}

/// Returns KITTI's sample for a disparity, or the reason why there is none.
fn kitti_sample(disparity: f32) -> Result<u16, &'static str> {
    let steps = (f64::from(disparity) * KITTI_STEPS).round();
    match disparity {
        d if d.is_nan() => Err("is not a number"),
        d if d <= 0.0 => {
            Err("is not above 0, which KITTI's PNG file can't hold: render the pair with parallel cameras, whose \
             disparities are 0 at infinity, or write a PFM file")
        }
        _ if steps > f64::from(u16::MAX) => {
            Err("rounds to 256 or more, which KITTI's PNG file can't hold: render a smaller picture or a smaller \
             interaxial, or write a PFM file")
        }
        _ => Ok(steps.max(1.0) as u16),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;

    /// Reads a file with another crate and returns width, height and samples.
    fn read(path: &Path) -> (u32, u32, Vec<u16>) {
        match image::open(path).unwrap() {
            image::DynamicImage::ImageLuma16(read) => (read.width(), read.height(), read.into_raw()),
            image::DynamicImage::ImageLuma8(read) => {
                (read.width(), read.height(), read.as_raw().iter().map(|&sample| sample.into()).collect())
            }
            other => panic!("{:?}", other.color()),
        }
    }

    fn truth(occlusion: [Occlusion; 3], primitive: [u32; 3]) -> EyeTruth {
        EyeTruth {
            width: 3,
            height: 1,
            depth: vec![1.0; 3],
            distance: vec![1.0; 3],
            disparity: vec![1.0; 3],
            occlusion: occlusion.to_vec(),
            geometric_normal: vec![[0.0; 3]; 3],
            shading_normal: vec![[0.0; 3]; 3],
            primitive: primitive.to_vec(),
            object: primitive.to_vec(),
            material: primitive.to_vec(),
        }
    }

    #[test]
    fn kitti_has_256_steps_a_pixel_and_0_where_nothing_is_known() {
        let folder = Folder::new("kitti");
        let path = folder.file("a.png");
        let values = [1.0, 0.5 / 256.0, 1e-6, 255.998, 2.0 + 1.4 / 256.0, -7.0, f32::INFINITY, f32::NAN];
        let valid = [true, true, true, true, true, false, false, false];
        let mut batch = Batch::new();
        batch.add_kitti_disparity(&path, 4, 2, &values, &valid).unwrap();
        batch.commit().unwrap();
        assert_eq!(read(&path), (4, 2, vec![256, 1, 1, 65535, 513, 0, 0, 0]));
    }

    #[test]
    fn what_kitti_cannot_hold_is_refused_with_its_pixel_and_what_to_do() {
        let folder = Folder::new("kitti_fault");
        for (value, words) in [
            (0.0, "disparity 0 px at column 1, row 2 is not above 0"),
            (
                -3.5,
                "disparity -3.5 px at column 1, row 2 is not above 0, which KITTI's PNG file can't hold: render the \
                 pair with parallel",
            ),
            (255.999, "rounds to 256 or more"),
            (256.0, "rounds to 256 or more"),
            (f32::INFINITY, "disparity inf px at column 1, row 2 rounds to 256 or more"),
            (f32::NAN, "is not a number"),
        ] {
            let values = [1.0, 1.0, 1.0, 1.0, 1.0, value];
            let add = |valid| Batch::new().add_kitti_disparity(folder.file("a.png"), 2, 3, &values, valid);
            let message = add(&[true; 6]).unwrap_err().to_string();
            assert!(message.contains("a.png: ") && message.contains(words), "{message}");
            add(&[true, true, true, true, true, false]).unwrap();
        }
        assert!(Batch::new().add_kitti_disparity(folder.file("a.png"), 2, 3, &[1.0; 6], &[true; 5]).is_err());
        assert!(folder.names().is_empty());
    }

    #[test]
    fn sintel_has_16384_steps_a_pixel_in_three_bytes() {
        let folder = Folder::new("sintel");
        let path = folder.file("a.png");
        let values = [0.0, 1.0, 4.0, 1_023.999_9, 0.5 / 16_384.0, 77.125];
        let mut batch = Batch::new();
        batch.add_sintel_disparity(&path, 3, 2, &values).unwrap();
        batch.commit().unwrap();
        let image::DynamicImage::ImageRgb8(read) = image::open(&path).unwrap() else { panic!() };
        // As in Sintel's own reader.
        let disparity = |pixel: &image::Rgb<u8>| {
            let [r, g, b] = pixel.0.map(f64::from);
            r * 4.0 + g / 64.0 + b / 16_384.0
        };
        for (pixel, value) in read.pixels().zip(values) {
            assert!((disparity(pixel) - f64::from(value)).abs() <= 0.5 / 16_384.0, "{value}: {pixel:?}");
        }
        for value in [-0.01, 1024.0, f32::INFINITY, f32::NAN] {
            let add = Batch::new().add_sintel_disparity(folder.file("b.png"), 2, 2, &[0.0, 0.0, 0.0, value]);
            let message = add.unwrap_err().to_string();
            assert!(message.contains(&format!("b.png: disparity {value} px at column 1, row 1 is not")), "{message}");
        }
    }

    #[test]
    fn ids_begin_behind_nothing_and_end_at_16_bits() {
        let folder = Folder::new("ids_png");
        let path = folder.file("a.png");
        let mut batch = Batch::new();
        batch.add_ids_png(&path, 2, 2, &[MISS, 0, 1, 65_534]).unwrap();
        let message = batch.add_ids_png(folder.file("b.png"), 1, 1, &[65_535]).unwrap_err().to_string();
        assert!(message.contains("b.png: id 65535 is over 65534") && message.contains("OpenEXR"), "{message}");
        batch.commit().unwrap();
        assert_eq!(read(&path), (2, 2, vec![0, 1, 2, 65_535]));
        assert_eq!(folder.names(), ["a.png"]);
    }

    #[test]
    fn masks_are_as_their_definitions_say() {
        let folder = Folder::new("masks");
        let truth = truth([Occlusion::Visible, Occlusion::Hidden, Occlusion::OutOfFrame], [MISS, 3, 4]);
        let mut batch = Batch::new();
        batch.add_nocc_mask(folder.file("nocc"), &truth).unwrap();
        batch.add_occlusion(folder.file("occlusion"), &truth).unwrap();
        batch.add_sky_mask(folder.file("sky"), &truth).unwrap();
        batch.commit().unwrap();
        let grey = |name: &str| {
            let bytes = std::fs::read(folder.file(name)).unwrap();
            image::load_from_memory(&bytes).unwrap().into_luma8().into_raw()
        };
        assert_eq!(grey("nocc"), [255, 128, 128]);
        assert_eq!(grey("occlusion"), [0, 255, 128]);
        assert_eq!(grey("sky"), [255, 0, 0]);
        assert_eq!(truth.surfaces(), [false, true, true]);
        assert_eq!(truth.surfaces_of_both(), [false; 3]);
    }
}
