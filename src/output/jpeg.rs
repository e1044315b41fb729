//! Writes JPEG files, and files of both eyes: JPS has one picture of both views, MPO has two pictures.

use std::path::Path;

use image::{ImageBuffer, Rgba, codecs::jpeg::JpegEncoder};

use super::{Batch, Packing, Picture, file::check_count, packed};
use crate::{Error, StereoPair};

const APP2: u8 = 0xe2;
const APP3: u8 = 0xe3;

/// Marker content of a JPS file (`VRex`'s stereoscopic descriptor): the descriptor's length, the descriptor, and an
/// empty comment. The descriptor's bytes are the pixels between the views, flags, the layout (side by side), and the
/// type (stereo). No flag says that the left view is on the left.
const JPS_DESCRIPTOR: &[u8] = b"_JPSJPS_\0\x04\0\0\x02\x01\0\0";

/// Attribute of an MPO image that is one of several views of a scene (CIPA DC-007, "Multi-Frame Image: Disparity").
const DISPARITY: u32 = 0x0002_0002;
/// Attribute of the image that viewers show if they show only one image.
const REPRESENTATIVE: u32 = 0x2000_0000;
/// Unknown numerator and denominator.
const UNKNOWN: [u32; 2] = [u32::MAX; 2];

impl Picture {
    /// Returns the bytes of a JPEG file without chroma subsampling; `path` is for errors.
    pub(super) fn jpeg(&self, path: &Path, quality: u8) -> Result<Vec<u8>, Error> {
        if !(1..=100).contains(&quality) {
            let reason = format!("JPEG quality {quality}; it must be 1 to 100");
            return Err(Error::Options { option: "quality", reason });
        }
        check_count(path, self.width, self.height, self.rgba8.len())?;
        let pixels = self.rgba8.as_flattened();
        let image = ImageBuffer::<Rgba<u8>, _>::from_raw(self.width, self.height, pixels);
        let image = image.ok_or_else(|| Error::unwritable(path, "it has too few pixels"))?;
        let mut bytes = Vec::new();
        let encoded = JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(&image);
        encoded.map_err(|error| Error::unwritable(path, error))?;
        Ok(bytes)
    }
}

impl Batch {
    /// Adds a picture as a JPEG file without chroma subsampling, of quality 1 to 100. Alpha is dropped.
    ///
    /// # Errors
    /// [`Error::Options`] for a quality out of range; [`Error::Io`] if there are not `width * height` pixels or none at
    /// all, or a side is over 65,535 pixels, and as [`Batch::add`].
    pub fn add_jpeg(&mut self, path: impl AsRef<Path>, picture: &Picture, quality: u8) -> Result<(), Error> {
        let path = path.as_ref();
        self.add(path, &picture.jpeg(path, quality)?)
    }

    /// Adds a pair as a JPS file: a JPEG file of both views side by side, the right one on the left
    /// ([`Packing::CrossEyed`]), with a marker that states this layout.
    ///
    /// # Errors
    /// As [`Batch::add_jpeg`].
    pub fn add_jps(&mut self, path: impl AsRef<Path>, pair: &StereoPair, quality: u8) -> Result<(), Error> {
        let path = path.as_ref();
        let picture = packed(&pair.left, &pair.right, Packing::CrossEyed);
        let jpeg = picture.jpeg(path, quality)?;
        self.add(path, &with_segment(&jpeg, APP3, JPS_DESCRIPTOR))
    }

    /// Adds a pair as an MPO file (CIPA DC-007), the format of stereo cameras and televisions: a JPEG file of the left
    /// view, followed by one of the right view.
    ///
    /// # Errors
    /// As [`Batch::add_jpeg`].
    pub fn add_mpo(&mut self, path: impl AsRef<Path>, pair: &StereoPair, quality: u8) -> Result<(), Error> {
        let path = path.as_ref();
        let [left, right] = [&pair.left, &pair.right].map(|view| view.picture().jpeg(path, quality));
        self.add(path, &mpo(path, &left?, &right?)?)
    }
}

/// Inserts a segment into a JPEG file, after the JFIF segment at its start.
fn with_segment(jpeg: &[u8], marker: u8, content: &[u8]) -> Vec<u8> {
    with_segments(jpeg, &segment(marker, &[content]))
}

/// Inserts segments into a JPEG file, after the JFIF segment at its start.
pub(super) fn with_segments(jpeg: &[u8], segments: &[u8]) -> Vec<u8> {
    let (begin, rest) = jpeg.split_at(first_segment_end(jpeg));
    [begin, segments, rest].concat()
}

/// Returns a segment, whose content is given in parts.
pub(super) fn segment(marker: u8, content: &[&[u8]]) -> Vec<u8> {
    let content = content.concat();
    let length = (content.len() as u16 + 2).to_be_bytes();
    [&[0xff, marker], length.as_slice(), &content].concat()
}

/// Returns the end of the JFIF segment, which follows the file's first marker.
fn first_segment_end(jpeg: &[u8]) -> usize {
    4 + usize::from(u16::from_be_bytes([jpeg[4], jpeg[5]]))
}

fn mpo(path: &Path, left: &[u8], right: &[u8]) -> Result<Vec<u8>, Error> {
    let segment = |index| [b"MPF\0", mp_header(index).as_slice()].concat();
    let second = with_segment(right, APP2, &segment(Index::Second));
    // Sizes don't change the segment's length, so the first file's size is known in advance.
    let size = left.len() + 4 + segment(Index::First([0; 3])).len();
    // Offsets are relative to the MP header, which follows the marker, its length and the name.
    let header = first_segment_end(left) + 8;
    let numbers = [size, second.len(), size - header].map(|number| u32::try_from(number).ok());
    let [Some(first_size), Some(second_size), Some(second_place)] = numbers else {
        return Err(Error::unwritable(path, "an MPO file must be smaller than 4 GiB; choose a lower quality"));
    };
    let first = with_segment(left, APP2, &segment(Index::First([first_size, second_size, second_place])));
    Ok([first, second].concat())
}

/// Image of an MPO file. The first image holds the sizes of both images and the offset of the second.
#[derive(Clone, Copy)]
enum Index {
    First([u32; 3]),
    Second,
}

/// Returns the content after `MPF`: lists of fields in TIFF format, upper byte first. Only the first image has an
/// index; both have attributes.
fn mp_header(index: Index) -> Vec<u8> {
    let mut header = Fields(b"MM\0\x2a\0\0\0\x08".to_vec());
    let number = match index {
        Index::First([first_size, second_size, second_place]) => {
            // The header has three fields, then the entries of both images, then the attributes.
            let entries = header.0.len() as u32 + Fields::bytes(3);
            header.count(3);
            header.version();
            header.long(0xb001, 2);
            header.field(0xb002, 7, 32, entries);
            header.word(entries + 32);
            for [attribute, size, place] in
                [[REPRESENTATIVE | DISPARITY, first_size, 0], [DISPARITY, second_size, second_place]]
            {
                [attribute, size, place, 0].into_iter().for_each(|word| header.word(word));
            }
            1
        }
        Index::Second => 2,
    };
    let rationals = header.0.len() as u32 + Fields::bytes(5);
    header.count(5);
    header.version();
    header.long(0xb101, number);
    header.long(0xb204, 1); // the reference viewpoint
    header.field(0xb205, 10, 1, rationals); // angle of convergence
    header.field(0xb206, 5, 1, rationals + 8); // baseline in metres
    header.word(0);
    UNKNOWN.into_iter().chain(UNKNOWN).for_each(|word| header.word(word));
    header.0
}

/// A growing list of fields.
struct Fields(Vec<u8>);

impl Fields {
    /// Returns the size in bytes of a list of `count` fields. The list has the number of fields, 12 bytes for each
    /// field, and the offset of the next list.
    fn bytes(count: u32) -> u32 {
        2 + 12 * count + 4
    }

    fn count(&mut self, count: u16) {
        self.0.extend(count.to_be_bytes());
    }

    fn word(&mut self, word: u32) {
        self.0.extend(word.to_be_bytes());
    }

    /// Adds a field with `values` values; `value` is the value itself or their offset.
    fn field(&mut self, tag: u16, kind: u16, values: u32, value: u32) {
        self.0.extend(tag.to_be_bytes());
        self.0.extend(kind.to_be_bytes());
        self.word(values);
        self.word(value);
    }

    fn long(&mut self, tag: u16, value: u32) {
        self.field(tag, 4, 1, value);
    }

    fn version(&mut self) {
        self.field(0xb000, 7, 4, u32::from_be_bytes(*b"0100"));
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::tests::{pair, view};
    use super::*;
    use crate::folder::Folder;

    fn two() -> StereoPair {
        let grey = |level: u8| view(16, &[[level; 3]; 16 * 8]);
        pair(grey(30), grey(220))
    }

    fn written(name: &str, add: impl FnOnce(&mut Batch, &Path)) -> Vec<u8> {
        let folder = Folder::new(name);
        let path = folder.file("a.jpg");
        let mut batch = Batch::new();
        add(&mut batch, &path);
        batch.commit().unwrap();
        fs::read(&path).unwrap()
    }

    fn decoded(bytes: &[u8]) -> image::RgbImage {
        image::load_from_memory_with_format(bytes, image::ImageFormat::Jpeg).unwrap().into_rgb8()
    }

    #[test]
    fn a_jpeg_reads_back_nearly_as_it_was_and_quality_counts() {
        let colors: Vec<[u8; 3]> = (0..24 * 16_u32).map(|n| [(n % 24 * 10) as u8, (n / 24 * 15) as u8, 90]).collect();
        let picture = view(24, &colors).picture();
        let error_of = |quality| {
            let bytes = written("jpeg", |batch, path| batch.add_jpeg(path, &picture, quality).unwrap());
            let read = decoded(&bytes);
            assert_eq!(read.dimensions(), (24, 16));
            let errors = read.as_raw().iter().zip(colors.as_flattened()).map(|(a, b)| u32::from(a.abs_diff(*b)));
            (errors.max().unwrap(), bytes.len())
        };
        let ((fine, large), (coarse, small)) = (error_of(100), error_of(20));
        // The measured values are 2 and 18.
        assert!(fine <= 4 && coarse > 8 && large > small, "{fine} {coarse} {large} {small}");
        let one = written("jpeg1", |batch, path| batch.add_jpeg(path, &view(1, &[[7; 3]]).picture(), 90).unwrap());
        assert_eq!(decoded(&one).dimensions(), (1, 1));
    }

    #[test]
    fn what_jpeg_cannot_hold_is_refused() {
        let add = |picture: Picture, quality| {
            let mut batch = Batch::new();
            batch.add_jpeg("never.jpg", &picture, quality).unwrap_err().to_string()
        };
        let one = || view(1, &[[7; 3]]).picture();
        for quality in [0, 101] {
            assert!(add(one(), quality).contains(&format!("JPEG quality {quality}; it must be 1 to 100")));
        }
        let message = add(Picture::new(65_536, 1, vec![[0; 4]; 65_536]), 90);
        assert!(message.contains("never.jpg: ") && message.contains("65535"), "{message}");
        assert!(add(Picture::new(2, 1, vec![[0; 4]]), 90).contains("cannot be written from 1 pixel"));
        assert!(add(Picture::new(0, 0, vec![]), 90).contains("never.jpg"));
    }

    #[test]
    fn a_jps_has_the_right_view_on_the_left_and_says_so() {
        let bytes = written("jps", |batch, path| batch.add_jps(path, &two(), 95).unwrap());
        let read = decoded(&bytes);
        assert_eq!(read.dimensions(), (32, 8));
        assert!(read.get_pixel(3, 3)[0] > 200 && read.get_pixel(28, 3)[0] < 50);
        // Marker, length and descriptor follow the SOI marker and the JFIF segment of 18 bytes.
        assert_eq!(bytes[20..24], [0xff, 0xe3, 0, 18]);
        assert_eq!(&bytes[24..40], JPS_DESCRIPTOR);
    }

    #[test]
    fn an_mpo_is_two_files_and_says_where() {
        let bytes = written("mpo", |batch, path| batch.add_mpo(path, &two(), 95).unwrap());
        let word = |place: usize| u32::from_be_bytes(std::array::from_fn(|byte| bytes[place + byte])) as usize;
        assert_eq!(bytes[20..22], [0xff, 0xe2]);
        assert_eq!(&bytes[24..32], b"MPF\0MM\0\x2a");
        // Entries begin after the header's 8 bytes and a list of three fields.
        let (header, entries) = (28, 28 + 8 + 42);
        assert_eq!([word(entries), word(entries + 16)], [0x2002_0002, 0x0002_0002]);
        let [first, second, place] = [word(entries + 4), word(entries + 20), word(entries + 24)];
        assert_eq!((first + second, header + place), (bytes.len(), first));
        assert!(decoded(&bytes[..first]).get_pixel(3, 3)[0] < 50);
        assert!(decoded(&bytes[first..]).get_pixel(3, 3)[0] > 200);
        assert_eq!(bytes[first..first + 2], [0xff, 0xd8]);
    }
}
