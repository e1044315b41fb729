//! Textures from picture files.

mod picture;

use std::sync::Arc;

use super::input;
#[cfg(any(feature = "obj", feature = "gltf"))]
use super::input::Files;
use crate::{Error, Limits, Texture, TextureKind};

impl Texture {
    /// Reads a PNG or JPEG file as sRGB. With the feature `more-textures` it also reads BMP, GIF (the first picture),
    /// TGA (by its file name extension), TIFF and WebP. Pictures without alpha are opaque, and 16-bit channels are
    /// rounded to 8 bits.
    ///
    /// The size is checked before decoding. Decoding takes up to 16 bytes per pixel, besides the format's own memory.
    /// The texture keeps 4.
    ///
    /// # Errors
    /// - [`Error::Io`] if the file can't be read or is no regular file.
    /// - [`Error::TooLarge`] if the file or its number of pixels exceeds its limit in [`Limits`].
    /// - [`Error::Parse`] if the file is not a picture of these formats or has a side over
    ///   [`MAX_TEXTURE_SIDE`](crate::scene::MAX_TEXTURE_SIDE).
    pub fn open(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::open_within(path, &Limits::default())
    }

    /// Does the same as [`Texture::open`], with the given limits.
    ///
    /// # Errors
    /// Returns the errors of [`Texture::open`].
    pub fn open_within(path: impl AsRef<std::path::Path>, limits: &Limits) -> Result<Self, Error> {
        let path = path.as_ref();
        let (file, _) = input::open(path, limits.file_bytes, limits.option_names[0])?;
        Self::decode(path, std::io::BufReader::new(file), limits)
    }

    /// Decodes a picture file in memory, as [`Texture::open`] does from the disk. Messages name it `name`.
    ///
    /// # Errors
    /// Returns the errors of [`Texture::open`] except [`Error::Io`].
    pub fn from_bytes(name: impl AsRef<std::path::Path>, bytes: &[u8], limits: &Limits) -> Result<Self, Error> {
        let path = name.as_ref();
        input::check_size(path, bytes.len() as u64, limits.file_bytes, limits.option_names[0])?;
        Self::decode(path, std::io::Cursor::new(bytes), limits)
    }

    /// Reads a texture file that a scene file names.
    #[cfg(any(feature = "obj", feature = "gltf"))]
    pub(crate) fn open_from(
        files: Files,
        path: &std::path::Path,
        limits: &Limits,
        counted: &mut u64,
    ) -> Result<Self, Error> {
        match files.given(path)? {
            Some(bytes) => {
                input::check_size(path, bytes.len() as u64, limits.file_bytes, limits.option_names[0])?;
                Self::decode_counted(path, std::io::Cursor::new(bytes), limits, counted)
            }
            None => {
                let (file, _) = input::open(path, limits.file_bytes, limits.option_names[0])?;
                Self::decode_counted(path, std::io::BufReader::new(file), limits, counted)
            }
        }
    }

    fn decode(
        path: &std::path::Path,
        source: impl std::io::BufRead + std::io::Seek,
        limits: &Limits,
    ) -> Result<Self, Error> {
        Self::decode_counted(path, source, limits, &mut 0)
    }

    /// Decodes a picture that is, or is part of, the file `path`. `counted` becomes the number of decoded pixels, also
    /// for a broken picture.
    pub(crate) fn decode_counted(
        path: &std::path::Path,
        source: impl std::io::BufRead + std::io::Seek,
        limits: &Limits,
        counted: &mut u64,
    ) -> Result<Self, Error> {
        let (size, pixels) = picture::decode(path, source, limits, counted)?;
        Ok(Self::of(TextureKind::Image { size, pixels: Arc::new(pixels) }))
    }
}
