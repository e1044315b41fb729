//! Writes PNG files row by row, for pictures that are too large for memory.

use std::{
    io::{self, Write},
    path::Path,
};

use super::{
    Batch,
    file::{PngKind, check_count},
};
use crate::Error;

/// Number of file bytes in each write.
const CHUNK: usize = 1 << 16;

/// A PNG file that is being written.
pub struct PngRows<'a> {
    stream: &'a mut (dyn Write + Send),
    path: &'a Path,
    size: [u32; 2],
    /// Number of pixels written.
    written: usize,
}

impl PngRows<'_> {
    /// Writes the next pixels, row-major from the top, as sRGB with alpha. A call may end within a row.
    ///
    /// # Errors
    /// [`Error::Io`] if the file can't be written, or would exceed its number of pixels.
    pub fn write(&mut self, rgba8: &[[u8; 4]]) -> Result<(), Error> {
        self.written += rgba8.len();
        if self.written as u64 > u64::from(self.size[0]) * u64::from(self.size[1]) {
            self.check_whole()?;
        }
        self.stream.write_all(rgba8.as_flattened()).map_err(|error| Error::io(self.path, error))
    }

    /// # Errors
    /// [`Error::Io`] unless exactly all pixels have been written.
    fn check_whole(&self) -> Result<(), Error> {
        check_count(self.path, self.size[0], self.size[1], self.written)
    }
}

impl Batch {
    /// Adds a PNG file with 8 bits per channel whose pixels `write` provides as they arrive
    /// ([`FrameBuilder::rows`](crate::FrameBuilder::rows)). Only a few rows are kept in memory.
    ///
    /// # Errors
    /// Any error of `write`; [`Error::Io`], naming `path`, as [`Batch::add`], and if `write` provides fewer pixels than
    /// the picture has.
    pub fn add_png_rows(
        &mut self,
        path: impl AsRef<Path>,
        width: u32,
        height: u32,
        write: impl FnOnce(&mut PngRows<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let path = path.as_ref();
        let mut failed = None;
        let staged = self.add_with(path, |file| {
            let result = stream(path, file, [width, height], write);
            result.map_err(|error| {
                failed = Some(error);
                io::Error::other("not whole")
            })
        });
        match failed {
            Some(error) => Err(error),
            None => staged,
        }
    }
}

fn stream(
    path: &Path,
    file: &mut (dyn Write + Send),
    size: [u32; 2],
    write: impl FnOnce(&mut PngRows<'_>) -> Result<(), Error>,
) -> Result<(), Error> {
    let unwritable = |error: png::EncodingError| Error::unwritable(path, error);
    let kind = PngKind { color: png::ColorType::Rgba, depth: png::BitDepth::Eight, is_srgb: true };
    let mut writer = kind.encoder(file, size[0], size[1]).write_header().map_err(unwritable)?;
    let mut stream = writer.stream_writer_with_size(CHUNK).map_err(unwritable)?;
    let mut rows = PngRows { stream: &mut stream, path, size, written: 0 };
    write(&mut rows)?;
    rows.check_whole()?;
    stream.finish().map_err(unwritable)?;
    writer.finish().map_err(unwritable)
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
        let in_parts = |rows: &mut PngRows<'_>| pixels.chunks(1000).try_for_each(|part| rows.write(part));
        batch.add_png_rows(folder.file("a.png"), 7, 300, in_parts).unwrap();
        batch.commit().unwrap();
        let read = image::open(folder.file("a.png")).unwrap().into_rgba8();
        assert_eq!(read.dimensions(), (7, 300));
        assert!(read.as_raw() == pixels.as_flattened());
    }

    #[test]
    fn a_picture_that_is_not_whole_is_none() {
        let folder = Folder::new("png_rows_fault");
        let path = folder.file("a.png");
        let attempt = |pixels: usize, after: Result<(), Error>| {
            let write = |rows: &mut PngRows<'_>| rows.write(&vec![[0; 4]; pixels]).and(after);
            Batch::new().add_png_rows(&path, 4, 4, write).unwrap_err().to_string()
        };
        assert!(attempt(12, Ok(())).ends_with("a.png: a picture of 4x4 cannot be written from 12 pixels"));
        assert!(attempt(17, Ok(())).ends_with("a.png: a picture of 4x4 cannot be written from 17 pixels"));
        assert_eq!(attempt(12, Err(Error::Cancelled)), Error::Cancelled.to_string());
        assert!(Batch::new().add_png_rows(&path, 0, 4, |_| Ok(())).is_err());
        assert!(folder.names().is_empty(), "{:?}", folder.names());
    }
}
