//! Skies from picture files.

mod picture;

use super::input;
use crate::{Error, Limits, SkyMap};

impl SkyMap {
    /// Reads a picture: PNG or JPEG (as sRGB), or Radiance HDR (linear). With the feature `exr` it also reads `OpenEXR`
    /// (linear): one part with channels R, G and B, where negative light becomes 0. The size is checked before
    /// decoding. Decoding takes 12 bytes per pixel, besides the format's own memory.
    ///
    /// # Errors
    /// - [`Error::Io`] if the file can't be read or is no regular file.
    /// - [`Error::TooLarge`] if the file or its number of pixels exceeds its limit in [`Limits`].
    /// - [`Error::Parse`] if the file is not a picture of these formats or not a sky.
    pub fn open(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::open_within(path, &Limits::default())
    }

    /// Does the same as [`SkyMap::open`], with the given limits. [`Limits::gpu`] sets the limits of an adapter.
    ///
    /// # Errors
    /// Returns the errors of [`SkyMap::open`].
    pub fn open_within(path: impl AsRef<std::path::Path>, limits: &Limits) -> Result<Self, Error> {
        let path = path.as_ref();
        let (file, _) = input::open(path, limits.file_bytes, limits.option_names[0])?;
        Self::decode(path, std::io::BufReader::new(file), limits)
    }

    /// Decodes a picture file in memory, as [`SkyMap::open`] does from the disk. Messages name it `name`.
    ///
    /// # Errors
    /// Returns the errors of [`SkyMap::open`] except [`Error::Io`].
    pub fn from_bytes(name: impl AsRef<std::path::Path>, bytes: &[u8], limits: &Limits) -> Result<Self, Error> {
        let path = name.as_ref();
        input::check_size(path, bytes.len() as u64, limits.file_bytes, limits.option_names[0])?;
        Self::decode(path, std::io::Cursor::new(bytes), limits)
    }

    fn decode(
        path: &std::path::Path,
        source: impl std::io::BufRead + std::io::Seek,
        limits: &Limits,
    ) -> Result<Self, Error> {
        let (width, height, pixels) = picture::decode(path, source, limits)?;
        Self::new(width, height, pixels).map_err(|error| Error::parse_from(path, None, error.to_string(), error))
    }
}
