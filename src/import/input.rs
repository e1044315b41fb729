//! Opens regular files up to a size limit for reading.

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

/// Size limits of files that the library reads. A larger file is an error before it takes memory.
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
    /// Maximum that the adapter can hold.
    adapter_pixels: u64,
    /// Names, for messages, of the options that raise the file limit and the sky limit.
    pub(crate) option_names: [&'static str; 2],
    /// Name of the option that raises the texture limit.
    pub(crate) texture_option_name: &'static str,
    /// Name of the option that raises the triangle limit.
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

/// Number of bytes per sky pixel on the adapter.
const SKY_PIXEL_BYTES: u64 = 16;
/// Number of bytes per texture pixel on the adapter.
const TEXTURE_PIXEL_BYTES: u64 = 4;
/// Number of pixels that may be decoded per pixel that may be kept. Some pictures are only inspected, and some turn out
/// to be broken at their end.
#[cfg(all(feature = "textures", any(feature = "obj", feature = "gltf")))]
const DECODED_PER_KEPT: u64 = 4;

impl Limits {
    /// Sets the maximum size in bytes of an OBJ, glTF or PLY file, and of a sky or texture file. The MTL files of one
    /// OBJ share this limit, and so do the buffers of one glTF file. The default is 1 GiB.
    pub fn file_bytes(mut self, bytes: u64) -> Self {
        self.file_bytes = bytes;
        self
    }

    /// Sets the maximum size in bytes of a JSON file, and of a glTF file's JSON without its strings (a buffer may be a
    /// string). In glTF an object counts as at least 32 bytes. The default is 16 MiB.
    pub fn json_bytes(mut self, bytes: u64) -> Self {
        self.json_bytes = bytes;
        self
    }

    /// Sets the maximum pixels of a sky, width times height. A pixel takes 12 bytes on the host and 16 on the adapter.
    /// The default is 8,388,608 (4096x2048), which fits the 128 MiB that every WebGPU adapter can bind.
    pub fn sky_pixels(mut self, pixels: u64) -> Self {
        self.sky_pixels = pixels;
        self
    }

    /// Sets the maximum pixels of a texture, and of all textures of an OBJ's MTL files or of a glTF file together. A
    /// pixel takes 4 bytes. Masks made from a picture's brightness or its own alpha cut-off count too. The default is
    /// 67,108,864 (8192x8192), which fits the 256 MiB that every WebGPU adapter can hold in a buffer. Four times as
    /// many pixels may be decoded, including pixels of pictures of which only a mean is kept.
    pub fn texture_pixels(mut self, pixels: u64) -> Self {
        self.texture_pixels = pixels;
        self
    }

    /// Sets the maximum triangles of a scene file. A glTF mesh counts once per node that shows it. A triangle takes
    /// some 80 bytes on the host, and 24 or 36 more with texture coordinates or colours. Loading takes twice that. A
    /// glTF file may have three times as many vertices. The default is 33,554,432.
    pub fn triangles(mut self, triangles: u64) -> Self {
        self.triangles = triangles;
        self
    }

    /// Sets the name that messages use for the option that raises [`Limits::triangles`]. The default is `Limits`.
    pub fn triangle_option_name(mut self, name: &'static str) -> Self {
        self.triangle_option_name = name;
        self
    }

    /// Sets the name that messages use for the option that raises [`Limits::texture_pixels`]. The default is `Limits`.
    pub fn texture_option_name(mut self, name: &'static str) -> Self {
        self.texture_option_name = name;
        self
    }

    /// Sets the names that messages use for the options that raise the file limits and the sky limit, for example a
    /// program's own options. The default is `Limits`.
    pub fn option_names(mut self, files: &'static str, skies: &'static str) -> Self {
        self.option_names = [files, skies];
        self
    }

    /// Sets the device for skies. A sky that the device can't hold is refused before it is decoded, even within
    /// [`Limits::sky_pixels`].
    pub fn gpu(mut self, gpu: &Gpu) -> Self {
        self.adapter_pixels = gpu.largest_table();
        self
    }

    /// Checks a number of triangles against the limit, or a number of `what` against the limit times `factor`.
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
                remedy: format!("raise it with {} if the size is intended", self.triangle_option_name),
            }),
        }
    }

    /// Returns the maximum pixels that may be decoded in all, kept or not.
    #[cfg(all(feature = "textures", any(feature = "obj", feature = "gltf")))]
    pub(crate) fn decodable_pixels(&self) -> u64 {
        self.texture_pixels.saturating_mul(DECODED_PER_KEPT)
    }

    /// Returns the largest sky that both the caller and the adapter allow.
    #[cfg(feature = "sky")]
    pub(crate) fn largest_sky(&self) -> u64 {
        self.sky_pixels.min(self.adapter_pixels)
    }
}

/// Opens a regular file of at most `limit` bytes and returns its size. `raised_by` names the option that raises the
/// limit.
///
/// # Errors
/// Returns [`Error::Io`] if the file can't be opened or is not a regular file, which may never end or block. Returns
/// [`Error::TooLarge`] for a file over the limit.
pub(crate) fn open(path: &Path, limit: u64, raised_by: &str) -> Result<(File, u64), Error> {
    let io = |source| Error::io(path, source);
    // The type is checked before opening too: opening a pipe waits for a writer.
    check_type(path, fs::metadata(path).map_err(io)?.file_type())?;
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    check_type(path, metadata.file_type())?;
    let bytes = metadata.len();
    check_size(path, bytes, limit, raised_by)?;
    Ok((file, bytes))
}

/// Returns an error for a file over the limit.
pub(crate) fn check_size(path: &Path, bytes: u64, limit: u64, raised_by: &str) -> Result<(), Error> {
    if bytes <= limit {
        return Ok(());
    }
    Err(Error::TooLarge {
        path: path.into(),
        size: format!("the file has {}", counted(bytes, "byte", "bytes")),
        limit,
        remedy: format!("raise it with {raised_by} if the size is intended"),
    })
}

/// Returns a file's bytes, up to its reported size. Files that the system generates (/proc) report none.
#[cfg(any(feature = "scene-files", feature = "json"))]
pub(crate) fn read_bytes(path: &Path, limit: u64, raised_by: &str) -> Result<Vec<u8>, Error> {
    use std::io::Read;

    let (file, bytes) = open(path, limit, raised_by)?;
    let mut content = Vec::with_capacity(bytes as usize);
    file.take(bytes).read_to_end(&mut content).map_err(|source| Error::io(path, source))?;
    Ok(content)
}

/// Returns a text file's bytes. UTF-16 is an error.
#[cfg(feature = "json")]
pub(crate) fn read(path: &Path, limit: u64, raised_by: &str) -> Result<Vec<u8>, Error> {
    let content = read_bytes(path, limit, raised_by)?;
    check_text(path, &content)?;
    Ok(content)
}

/// Returns an error for UTF-16.
#[cfg(any(feature = "obj", feature = "json"))]
fn check_text(path: &Path, content: &[u8]) -> Result<(), Error> {
    let utf_16 = match content {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "UTF-16 text, judging by its byte order mark",
        [0, _, ..] | [_, 0, ..] => "UTF-16 text or binary data, judging by a zero byte at its start",
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
