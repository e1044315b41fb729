//! Opens files to be read: regular ones only, no larger than a limit.

#[cfg(feature = "scene-files")]
mod files;

use std::{
    fs::{self, File, FileType},
    io::{self, ErrorKind},
    path::Path,
};

#[cfg(feature = "scene-files")]
pub(crate) use self::files::{Files, Given, SceneFolder};
use crate::{Error, Gpu, message::counted};

/// How large a file may be that the library reads. A larger one is an error, before it takes memory.
///
/// ```
/// use stereotrace::Limits;
///
/// let limits = Limits::default().file_bytes(8 << 30).sky_pixels(8192 * 4096);
/// # let _ = limits;
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    pub(crate) file_bytes: u64,
    pub(crate) json_bytes: u64,
    sky_pixels: u64,
    pub(crate) texture_pixels: u64,
    #[cfg_attr(not(feature = "scene-files"), allow(dead_code, reason = "no scene is read"))]
    pub(crate) triangles: u64,
    /// The most that the adapter can hold.
    adapter_pixels: u64,
    /// What messages say that the limits on files and on skies are raised by.
    pub(crate) option_names: [&'static str; 2],
    /// The same of the limit on textures.
    pub(crate) texture_option_name: &'static str,
    /// The same of the limit on triangles.
    #[cfg_attr(not(feature = "scene-files"), allow(dead_code, reason = "no scene is read"))]
    pub(crate) triangle_option_name: &'static str,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 1 << 30,
            json_bytes: 16 << 20,
            sky_pixels: (128 << 20) / SKY_PIXEL_BYTES,
            texture_pixels: (256 << 20) / TEXTURE_PIXEL_BYTES,
            triangles: 1 << 25,
            adapter_pixels: u64::MAX,
            option_names: ["Limits"; 2],
            texture_option_name: "Limits",
            triangle_option_name: "Limits",
        }
    }
}

/// What a sky's pixel takes on the adapter.
const SKY_PIXEL_BYTES: u64 = 16;
/// What a texture's pixel takes.
const TEXTURE_PIXEL_BYTES: u64 = 4;
/// Pixels that may be decoded for each that may be kept: some pictures are looked at alone, and some turn out to be
/// broken at their end.
#[cfg(all(feature = "textures", any(feature = "obj", feature = "gltf")))]
const DECODED_PER_KEPT: u64 = 4;

impl Limits {
    /// Largest OBJ, glTF or PLY file, and largest picture of a sky or of a texture as a file; all MTL files of one OBJ
    /// together have the same limit, and all buffers of one glTF file. 1 GiB where nothing is said.
    pub fn file_bytes(mut self, bytes: u64) -> Self {
        self.file_bytes = bytes;
        self
    }

    /// Largest JSON file, and what a glTF file may have of JSON beside its strings (a buffer may be a string). There an
    /// object counts as 32 bytes at least. 16 MiB where nothing is said.
    pub fn json_bytes(mut self, bytes: u64) -> Self {
        self.json_bytes = bytes;
        self
    }

    /// Largest sky, width times height, each pixel taking 12 bytes here and 16 on the adapter. 8,388,608 (4096x2048)
    /// where nothing is said: the 128 MiB that every WebGPU adapter can bind.
    pub fn sky_pixels(mut self, pixels: u64) -> Self {
        self.sky_pixels = pixels;
        self
    }

    /// Pixels that a texture may have at most, and those of an OBJ's MTL files or of a glTF file all together; each
    /// takes 4 bytes. Masks that are made of a picture, by its brightness or an alpha cut-off of its own, count
    /// like pictures. 67,108,864 (one of 8192x8192) where nothing is said: the 256 MiB that every WebGPU adapter
    /// can hold in a buffer. Four times as many may be decoded, with those of which only a mean is kept.
    pub fn texture_pixels(mut self, pixels: u64) -> Self {
        self.texture_pixels = pixels;
        self
    }

    /// Triangles that a scene file may become. In a glTF file a mesh counts as often as nodes show it. Each takes some
    /// 80 bytes here, and 24 or 36 more with texture coordinates or colours, and twice that while it is read; a
    /// glTF file's vertices may be three times as many. 33,554,432 where nothing is said.
    pub fn triangles(mut self, triangles: u64) -> Self {
        self.triangles = triangles;
        self
    }

    /// What messages say that [`Limits::triangles`] is raised by. `Limits` where nothing is said.
    pub fn triangle_option_name(mut self, name: &'static str) -> Self {
        self.triangle_option_name = name;
        self
    }

    /// What messages say that [`Limits::texture_pixels`] is raised by. `Limits` where nothing is said.
    pub fn texture_option_name(mut self, name: &'static str) -> Self {
        self.texture_option_name = name;
        self
    }

    /// What messages say that the limits are raised by, those on files and the one on skies: a program's own options,
    /// where its user has some. `Limits` where nothing is said.
    pub fn option_names(mut self, files: &'static str, skies: &'static str) -> Self {
        self.option_names = [files, skies];
        self
    }

    /// The device that skies are for: one that it can't hold is refused before it is decoded, whatever
    /// [`Limits::sky_pixels`] says.
    pub fn gpu(mut self, gpu: &Gpu) -> Self {
        self.adapter_pixels = gpu.largest_table();
        self
    }

    /// Refuses more triangles than the limit, or of something else, named by `what`, more than the limit times
    /// `factor`.
    #[cfg(feature = "scene-files")]
    pub(crate) fn check_triangles(
        &self,
        path: &Path,
        (name, what): (&str, &str),
        count: u64,
        factor: u64,
    ) -> Result<(), Error> {
        let limit = self.triangles.saturating_mul(factor);
        match count <= limit {
            true => Ok(()),
            false => Err(Error::TooLarge {
                path: path.into(),
                size: format!("{name} has {count} {what}"),
                limit,
                remedy: format!("raise it by {}, if it is right", self.triangle_option_name),
            }),
        }
    }

    /// Pixels that may be decoded in all, whether they are kept or not.
    #[cfg(all(feature = "textures", any(feature = "obj", feature = "gltf")))]
    pub(crate) fn decodable_pixels(&self) -> u64 {
        self.texture_pixels.saturating_mul(DECODED_PER_KEPT)
    }

    /// The largest sky that both the caller and the adapter take.
    #[cfg(feature = "sky")]
    pub(crate) fn largest_sky(&self) -> u64 {
        self.sky_pixels.min(self.adapter_pixels)
    }
}

/// Opens a regular file of at most `limit` bytes, and says how many it has. A message says what raises the limit.
///
/// # Errors
/// [`Error::Io`] if it can't be opened, and for what is no regular file, which may have no end or wait for ever;
/// [`Error::TooLarge`] for a file over the limit.
pub(crate) fn open(path: &Path, limit: u64, raised_by: &str) -> Result<(File, u64), Error> {
    let io = |source| Error::io(path, source);
    // Before it is opened too: opening a pipe waits for one who writes into it.
    check_type(path, fs::metadata(path).map_err(io)?.file_type())?;
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    check_type(path, metadata.file_type())?;
    let bytes = metadata.len();
    check_size(path, bytes, limit, raised_by)?;
    Ok((file, bytes))
}

/// Refuses a file over the limit.
pub(crate) fn check_size(path: &Path, bytes: u64, limit: u64, raised_by: &str) -> Result<(), Error> {
    if bytes <= limit {
        return Ok(());
    }
    Err(Error::TooLarge {
        path: path.into(),
        size: format!("the file has {}", counted(bytes, "byte", "bytes")),
        limit,
        remedy: format!("raise it by {raised_by}, if it is right"),
    })
}

/// A file's bytes, as many of them as it said it had: what the system makes up as it is read (/proc) has no size.
#[cfg(any(feature = "scene-files", feature = "json"))]
pub(crate) fn read_bytes(path: &Path, limit: u64, raised_by: &str) -> Result<Vec<u8>, Error> {
    use std::io::Read;

    let (file, bytes) = open(path, limit, raised_by)?;
    let mut content = Vec::with_capacity(bytes as usize);
    file.take(bytes).read_to_end(&mut content).map_err(|source| Error::io(path, source))?;
    Ok(content)
}

/// A text's bytes. UTF-16 is an error.
#[cfg(feature = "json")]
pub(crate) fn read(path: &Path, limit: u64, raised_by: &str) -> Result<Vec<u8>, Error> {
    let content = read_bytes(path, limit, raised_by)?;
    check_text(path, &content)?;
    Ok(content)
}

/// Refuses UTF-16.
#[cfg(any(feature = "obj", feature = "json"))]
fn check_text(path: &Path, content: &[u8]) -> Result<(), Error> {
    let utf_16 = match content {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "UTF-16 text, by its byte order mark",
        [0, _, ..] | [_, 0, ..] => "UTF-16 text or none at all, by a byte of 0 at its beginning",
        _ => return Ok(()),
    };
    Err(Error::parse(path, None, format!("it is {utf_16}; save it as UTF-8")))
}

fn check_type(path: &Path, found: FileType) -> Result<(), Error> {
    if found.is_file() {
        return Ok(());
    }
    let (kind, what) = match found.is_dir() {
        true => (ErrorKind::IsADirectory, "a folder"),
        false => (ErrorKind::InvalidInput, "a pipe, a socket or a device"),
    };
    Err(Error::io(path, io::Error::new(kind, format!("it is {what}; only regular files are read"))))
}
