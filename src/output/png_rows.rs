//! Writes PNG files row by row, for pictures that are too large for memory.

use std::{
    fs::File,
    io::{self, Write},
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use super::{
    Batch,
    batch::OpenFile,
    file::{PngKind, check_count},
    panorama,
};
use crate::{Error, Pose};

/// Number of file bytes in each write.
const CHUNK: usize = 1 << 16;

/// A PNG file with 8 bits per channel that is written as its pixels arrive
/// ([`FrameBuilder::rows`](crate::FrameBuilder::rows)). Only a few rows are kept in memory. The file has a temporary
/// name until it is added to a [`Batch`], and is removed if it is dropped before.
///
/// ```
/// use stereotrace::output::{Batch, PngRows};
///
/// let path = std::env::temp_dir().join("rows.png");
/// let mut file = PngRows::new(&path, 640, 480)?;
/// for _ in 0..480 {
///     file.write(&[[0, 0, 255, 255]; 640])?;
/// }
/// let mut batch = Batch::new();
/// batch.add_png_rows(file)?;
/// batch.commit()?;
/// # Ok::<(), stereotrace::Error>(())
/// ```
pub struct PngRows {
    stream: png::StreamWriter<'static, Output>,
    /// Whether a write has failed. The encoder drops the errors of its last writes.
    has_failed: Arc<AtomicBool>,
    open: OpenFile,
    size: [u32; 2],
    /// Number of pixels written.
    written: usize,
}

impl PngRows {
    /// Creates a file for a picture of this size, as sRGB with alpha.
    ///
    /// # Errors
    /// [`Error::Io`], naming `path`, if it can't be written, is read-only, or is a folder, or the picture has no
    /// pixels.
    pub fn new(path: impl AsRef<Path>, width: u32, height: u32) -> Result<Self, Error> {
        Self::with_xmp(path.as_ref(), [width, height], None)
    }

    /// Creates a file for a view of an equirectangular pair, which names its projection (XMP, `GPano`).
    ///
    /// # Errors
    /// As [`PngRows::new`], and [`Error::Camera`] for a planar pose.
    pub fn panorama(path: impl AsRef<Path>, pose: &Pose) -> Result<Self, Error> {
        Self::with_xmp(path.as_ref(), pose.size, Some(panorama::xmp(pose)?))
    }

    fn with_xmp(path: &Path, [width, height]: [u32; 2], xmp: Option<String>) -> Result<Self, Error> {
        let kind = PngKind { color: png::ColorType::Rgba, depth: png::BitDepth::Eight, is_srgb: true };
        let open = OpenFile::create(path)?;
        let file = open.file.try_clone().map_err(|error| Error::io(path, error))?;
        let has_failed = Arc::<AtomicBool>::default();
        let mut encoder = kind.encoder(Output { file, has_failed: has_failed.clone() }, width, height);
        let noted = xmp.map_or(Ok(()), |xmp| encoder.add_itxt_chunk("XML:com.adobe.xmp".into(), xmp));
        let stream = noted.and_then(|()| encoder.write_header()?.into_stream_writer_with_size(CHUNK));
        let stream = stream.map_err(|error| Error::unwritable(path, error))?;
        Ok(Self { stream, has_failed, open, size: [width, height], written: 0 })
    }

    /// Writes the next pixels, row-major from the top, as sRGB with alpha. A call may end within a row.
    ///
    /// # Errors
    /// [`Error::Io`] if the file can't be written, or would exceed its number of pixels.
    pub fn write(&mut self, rgba8: &[[u8; 4]]) -> Result<(), Error> {
        self.written += rgba8.len();
        if self.written as u64 > u64::from(self.size[0]) * u64::from(self.size[1]) {
            self.check_whole()?;
        }
        self.stream.write_all(rgba8.as_flattened()).map_err(|error| Error::io(&self.open.path, error))
    }

    /// # Errors
    /// [`Error::Io`] unless exactly all pixels have been written.
    fn check_whole(&self) -> Result<(), Error> {
        check_count(&self.open.path, self.size[0], self.size[1], self.written)
    }
}

impl std::fmt::Debug for PngRows {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { open, size, written, .. } = self;
        let mut shown = formatter.debug_struct("PngRows");
        shown.field("path", &open.path).field("size", size).field("written", written).finish_non_exhaustive()
    }
}

impl Batch {
    /// Adds a PNG file whose pixels have all been written.
    ///
    /// # Errors
    /// [`Error::Io`], naming its path, if it can't be written, or has fewer pixels than its size.
    pub fn add_png_rows(&mut self, rows: PngRows) -> Result<(), Error> {
        rows.check_whole()?;
        let PngRows { stream, has_failed, open, .. } = rows;
        stream.finish().map_err(|error| Error::unwritable(&open.path, error))?;
        if has_failed.load(Ordering::Relaxed) {
            return Err(Error::unwritable(&open.path, "its last bytes could not be written"));
        }
        self.close(open)
    }
}

/// A file that remembers whether a write has failed.
struct Output {
    file: File,
    has_failed: Arc<AtomicBool>,
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes);
        if written.as_ref().is_err_and(|error| error.kind() != io::ErrorKind::Interrupted) {
            self.has_failed.store(true, Ordering::Relaxed);
        }
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;

    #[test]
    fn rows_make_the_picture_that_is_written_at_once() {
        let folder = Folder::new("png_rows");
        let pixels: Vec<[u8; 4]> = (0..7 * 300_u32).map(|n| [n as u8, (n >> 3) as u8, (n % 251) as u8, 255]).collect();
        let mut batch = Batch::new();
        let mut rows = PngRows::new(folder.file("a.png"), 7, 300).unwrap();
        pixels.chunks(1000).for_each(|part| rows.write(part).unwrap());
        batch.add_png_rows(rows).unwrap();
        batch.commit().unwrap();
        let read = image::open(folder.file("a.png")).unwrap().into_rgba8();
        assert_eq!(read.dimensions(), (7, 300));
        assert!(read.as_raw() == pixels.as_flattened());
    }

    #[test]
    fn a_picture_that_is_not_whole_is_none() {
        let folder = Folder::new("png_rows_fault");
        let path = folder.file("a.png");
        let attempt = |pixels: usize| {
            let mut rows = PngRows::new(&path, 4, 4).unwrap();
            let written = rows.write(&vec![[0; 4]; pixels]);
            written.and_then(|()| Batch::new().add_png_rows(rows)).unwrap_err().to_string()
        };
        assert!(attempt(12).ends_with("a.png: a picture of 4x4 cannot be written from 12 pixels"));
        assert!(attempt(17).ends_with("a.png: a picture of 4x4 cannot be written from 17 pixels"));
        assert!(PngRows::new(&path, 0, 4).unwrap_err().to_string().contains("a.png"));
        assert!(folder.names().is_empty(), "{:?}", folder.names());
    }
}
