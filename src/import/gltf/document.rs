//! A glTF file: its JSON and the resources that it names.

use std::{
    borrow::Cow,
    cell::{Cell, OnceCell, RefCell},
    collections::HashMap,
    fmt::Display,
    ops::Range,
    path::{Path, PathBuf},
    rc::Rc,
};

use base64::{Engine, alphabet, engine};
use gltf_json::{Buffer, Index, Root, buffer::View};
use percent_encoding::percent_decode_str;

use super::{
    more::{self, MoreOfMaterial},
    nodes::{Shifts, shifts},
};
use crate::{Error, Limits, import::input::Files, import::warnings::Warnings, message::counted};

/// Extension for textures with WebP pictures.
#[cfg(feature = "more-textures")]
const WEBP: &str = "EXT_texture_webp";

/// Extensions that are read or have no effect here.
const EXTENSIONS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    #[cfg(feature = "more-textures")]
    WEBP,
];

/// Base64 with optional padding.
const BASE64: engine::GeneralPurpose = engine::GeneralPurpose::new(
    &alphabet::STANDARD,
    engine::GeneralPurposeConfig::new().with_decode_padding_mode(engine::DecodePaddingMode::Indifferent),
);

/// Prefix of a URI that contains its data.
const DATA: &str = "data:";

/// Maximum of decoded numbers of key frames, skins and morph targets per byte of the files. Files that do not share
/// bytes between accessors have at most one.
const NUMBERS_PER_BYTE: u64 = 4;

/// Minimum size in bytes that a JSON object counts. Two bytes of JSON may become a material of some 280 bytes.
const OBJECT_BYTES: u64 = 32;

/// A file's JSON with its resources.
pub(super) struct Document<'a> {
    pub(super) files: Files<'a>,
    pub(super) path: &'a Path,
    pub(super) root: Root,
    /// Transforms of each node in f64; `root` has them in f32.
    pub(super) shifts: Vec<Shifts>,
    /// Further parts of each material; empty if there are none.
    pub(super) more: Vec<MoreOfMaterial>,
    pub(super) limits: Limits,
    /// Image of each texture that uses the extension [`WEBP`].
    #[cfg(feature = "more-textures")]
    webp: Vec<Option<usize>>,
    /// Bytes of a binary file, and the range of its buffer.
    chunk: Option<(Cow<'a, [u8]>, Range<usize>)>,
    /// Buffers, read on first use.
    buffers: Vec<OnceCell<Rc<Cow<'a, [u8]>>>>,
    /// Buffers that are files, each read once.
    files_read: RefCell<HashMap<PathBuf, Rc<Cow<'a, [u8]>>>>,
    /// Size of the file itself.
    bytes: u64,
    /// Number of bytes that further files may have.
    bytes_left: Cell<u64>,
    /// Numbers of key frames, skins and morph targets that were decoded so far.
    decoded: Cell<u64>,
}

impl<'a> Document<'a> {
    pub(super) fn open(files: Files<'a>, path: &'a Path, limits: Limits) -> Result<Self, Error> {
        let bytes = files.read_bytes(path, limits.file_bytes, limits.option_names[0])?;
        let is_binary = bytes.starts_with(b"glTF");
        let fault = |reason: String| Error::parse(path, None, reason);
        let (json, chunk) = if is_binary { chunks(&bytes).map_err(fault)? } else { (0..bytes.len(), None) };
        let json = without_mark(&bytes[json]);
        // The parts of other versions differ, so that reading them fails with another reason.
        let root = parse(path, json, is_binary, &limits).map_err(|error| other_version(json).map_or(error, fault))?;
        let shifts = shifts(json).map_err(|error| fault(format!("invalid glTF JSON: {error}")))?;
        let more = more::materials(json, &root.extensions_used)
            .map_err(|error| Error::parse_from(path, None, format!("invalid glTF materials: {error}"), error))?;
        #[cfg(feature = "more-textures")]
        let webp = match root.extensions_used.iter().any(|name| name == WEBP) {
            true => webp_images(json)
                .map_err(|error| Error::parse_from(path, None, format!("invalid {WEBP} textures: {error}"), error))?,
            false => Vec::new(),
        };
        let buffers = root.buffers.iter().map(|_| OnceCell::new()).collect();
        let count = bytes.len() as u64;
        let chunk = chunk.map(|chunk| (bytes, chunk));
        let (files_read, bytes_left) = (RefCell::default(), Cell::new(limits.file_bytes));
        let document = Self {
            files,
            path,
            root,
            shifts,
            more,
            limits,
            #[cfg(feature = "more-textures")]
            webp,
            chunk,
            buffers,
            files_read,
            bytes: count,
            bytes_left,
            decoded: Cell::new(0),
        };
        match unsupported(&document.root.asset.version) {
            None => Ok(document),
            Some(reason) => Err(document.fault(reason)),
        }
    }

    /// Refuses unknown required extensions, and warns of unknown optional ones.
    pub(super) fn check_extensions(&self, warnings: &Warnings) -> Result<(), Error> {
        let unknown = |names: &'_ [String]| -> Vec<String> {
            names.iter().filter(|name| !EXTENSIONS.contains(&&***name)).cloned().collect()
        };
        let required = unknown(&self.root.extensions_required);
        if !required.is_empty() {
            let reason =
                format!("it requires {}; the supported extensions are {}", required.join(", "), EXTENSIONS.join(", "));
            return Err(self.fault(reason));
        }
        let used = unknown(&self.root.extensions_used);
        if !used.is_empty() {
            warnings.warn_once(format!("ignored extensions: {}", used.join(", ")));
        }
        Ok(())
    }

    pub(super) fn fault(&self, reason: String) -> Error {
        Error::parse(self.path, None, reason)
    }

    /// Returns an item of a list; `by` says in messages what refers to it.
    pub(super) fn item<'b, T>(
        &self,
        (list, items): (&str, &'b [T]),
        index: usize,
        by: impl Display,
    ) -> Result<&'b T, Error> {
        items.get(index).ok_or_else(|| {
            self.fault(format!("{by}: there is no {list}[{index}]; the list has length {}", items.len()))
        })
    }

    /// Returns the image that a texture has by a supported extension.
    pub(super) fn extended_image(&self, _texture: usize) -> Option<usize> {
        #[cfg(feature = "more-textures")]
        return self.webp.get(_texture).copied().flatten();
        #[cfg(not(feature = "more-textures"))]
        None
    }

    /// Returns a view and its bytes.
    pub(super) fn view(&self, index: Index<View>, by: impl Display) -> Result<(&View, &[u8]), Error> {
        let view = self.item(("bufferViews", &self.root.buffer_views), index.value(), by)?;
        let name = format!("bufferViews[{}]", index.value());
        let buffer = self.buffer(view.buffer, &name)?;
        let (start, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        let bytes = range(start, length).and_then(|range| buffer.get(range));
        let bytes = bytes.ok_or_else(|| {
            let size = counted(buffer.len(), "byte", "bytes");
            self.fault(format!("{name}: {length} bytes from byte {start} on exceed its buffer of {size}"))
        })?;
        Ok((view, bytes))
    }

    fn buffer(&self, index: Index<Buffer>, by: &str) -> Result<&[u8], Error> {
        let buffer = self.item(("buffers", &self.root.buffers), index.value(), by)?;
        let name = format!("buffers[{}]", index.value());
        let content = match (&buffer.uri, &self.chunk, index.value()) {
            (None, Some((bytes, chunk)), 0) => &bytes[chunk.clone()],
            (None, ..) => return Err(self.fault(format!("{name}: it has no URI and no binary chunk"))),
            (Some(uri), ..) => {
                let place = &self.buffers[index.value()];
                let bytes = match place.get() {
                    Some(bytes) => bytes,
                    None => {
                        let bytes = self.resource(uri, &name)?;
                        place.get_or_init(|| bytes)
                    }
                };
                &bytes[..]
            }
        };
        let length = buffer.byte_length.0;
        content.get(..usize::try_from(length).unwrap_or(usize::MAX)).ok_or_else(|| {
            let found = counted(content.len(), "byte", "bytes");
            self.fault(format!("{name}: its byteLength is {length}, but it has {found}"))
        })
    }

    /// Returns the size of all files read so far.
    pub(super) fn bytes_read(&self) -> u64 {
        self.bytes + (self.limits.file_bytes - self.bytes_left.get())
    }

    /// Counts decoded numbers of key frames, skins and morph targets. Many accessors may overlap in one buffer, so the
    /// sum has a limit of its own.
    pub(super) fn count_decoded(&self, numbers: usize, by: &str) -> Result<(), Error> {
        self.decoded.set(self.decoded.get() + numbers as u64);
        let (sum, bytes) = (self.decoded.get(), self.bytes_read());
        if sum <= NUMBERS_PER_BYTE * bytes {
            return Ok(());
        }
        let reason = "numbers of key frames, skins and morph targets; the maximum is";
        Err(self.fault(format!("{by}: {sum} {reason} {NUMBERS_PER_BYTE} per byte of the files, which have {bytes}")))
    }

    /// Returns the bytes of a URI, from its data or a file. All files together may be as large as the limit on the file
    /// itself.
    fn resource(&self, uri: &str, by: &str) -> Result<Rc<Cow<'a, [u8]>>, Error> {
        if let Some(bytes) = self.decoded(uri, by)? {
            return Ok(Rc::new(Cow::Owned(bytes)));
        }
        let path = self.located(uri, by)?;
        let real = self.files.real(&path);
        if let Some(bytes) = self.files_read.borrow().get(&real) {
            return Ok(bytes.clone());
        }
        let read = self.files.read_bytes(&path, self.bytes_left.get(), self.limits.option_names[0]);
        let bytes = read.map_err(|error| match error {
            Error::Io { .. } => Error::parse_from(self.path, None, format!("{by}: {error}"), error),
            other => other,
        })?;
        self.bytes_left.set(self.bytes_left.get() - bytes.len() as u64);
        let bytes = Rc::new(bytes);
        self.files_read.borrow_mut().insert(real, bytes.clone());
        Ok(bytes)
    }

    /// Returns whether a URI contains its data.
    #[cfg(feature = "textures")]
    pub(super) fn is_data(uri: &str) -> bool {
        uri.starts_with(DATA)
    }

    /// Decodes a data URI; `None` for other URIs.
    pub(super) fn decoded(&self, uri: &str, by: &str) -> Result<Option<Vec<u8>>, Error> {
        let Some(data) = uri.strip_prefix(DATA) else { return Ok(None) };
        let text = data.split_once(',').filter(|(kind, _)| kind.ends_with(";base64")).map(|(_, text)| text);
        let text = text.ok_or_else(|| self.fault(format!("{by}: its data URI is not base64")))?;
        let bytes = BASE64.decode(text).map_err(|error| {
            Error::parse_from(self.path, None, format!("{by}: its data URI is not valid base64: {error}"), error)
        })?;
        Ok(Some(bytes))
    }

    /// Returns the path of the file that a URI names, relative to this file.
    pub(super) fn located(&self, uri: &str, by: &str) -> Result<PathBuf, Error> {
        // A single letter is a drive, not a scheme.
        let scheme = uri.split_once(':').map(|(scheme, _)| scheme).filter(|scheme| {
            scheme.len() > 1 && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
        });
        if let Some(scheme) = scheme {
            return Err(self.fault(format!("{by}: '{scheme}:' URIs are not supported; use a file or base64 data")));
        }
        let name: Cow<'_, str> = percent_decode_str(uri).decode_utf8_lossy();
        let located = self.files.locate(self.path.parent().unwrap_or(Path::new("")), &name);
        located.map_err(|error| Error::parse_from(self.path, None, format!("{by}: {error}"), error))
    }
}

/// Returns why a file of this version can't be read, or `None` if it can.
fn unsupported(version: &str) -> Option<String> {
    let is_known = version.split('.').next() == Some("2");
    (!is_known).then(|| format!("it is glTF {version}; only version 2 is supported"))
}

/// Returns why a file whose JSON has another version can't be read.
fn other_version(json: &[u8]) -> Option<String> {
    #[derive(serde::Deserialize)]
    struct Head {
        asset: Asset,
    }
    #[derive(serde::Deserialize)]
    struct Asset {
        version: String,
    }
    unsupported(&serde_json::from_slice::<Head>(json).ok()?.asset.version)
}

fn range(start: u64, length: u64) -> Option<Range<usize>> {
    let end = start.checked_add(length)?;
    Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
}

/// Returns the ranges of the JSON and the buffer in a binary file.
fn chunks(bytes: &[u8]) -> Result<(Range<usize>, Option<Range<usize>>), String> {
    let word = |at: usize| bytes.get(at..at + 4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err("the file ends within its header".into());
    };
    if version != 2 {
        return Err(format!("it is binary glTF {version}; only version 2 is supported"));
    }
    if length as usize > bytes.len() {
        let found = counted(bytes.len(), "byte", "bytes");
        return Err(format!("it has {found}, but its header states {length}"));
    }
    let (mut at, mut json, mut buffer) = (12, None, None);
    while let (Some(size), Some(kind)) = (word(at), word(at + 4)) {
        let content = range(at as u64 + 8, size.into()).filter(|content| content.end <= length as usize);
        let content = content.ok_or_else(|| format!("the chunk at byte {at} has {size} bytes and exceeds the file"))?;
        at = content.end;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(content),
            b"BIN\0" if buffer.is_none() => buffer = Some(content),
            _ => {} // other chunks are ignored
        }
    }
    json.map(|json| (json, buffer)).ok_or_else(|| "it has no JSON chunk".into())
}

/// Removes a byte order mark.
fn without_mark(json: &[u8]) -> &[u8] {
    json.strip_prefix("\u{feff}".as_bytes()).unwrap_or(json)
}

fn parse(path: &Path, json: &[u8], is_binary: bool, limits: &Limits) -> Result<Root, Error> {
    let (bytes, objects) = structure(json);
    if bytes.max(OBJECT_BYTES * objects) > limits.json_bytes {
        let size = match bytes > limits.json_bytes {
            true => format!("its JSON has {} outside strings", counted(bytes, "byte", "bytes")),
            false => format!(
                "its JSON has {objects} objects, which count as {OBJECT_BYTES} bytes each, {} in all",
                OBJECT_BYTES * objects
            ),
        };
        return Err(Error::TooLarge {
            path: path.into(),
            size,
            limit: limits.json_bytes,
            remedy: format!("raise it with {} if the size is intended", limits.option_names[0]),
        });
    }
    Root::from_slice(json).map_err(|error| {
        let line = Some(error.line()).filter(|&line| line > 0 && !is_binary);
        Error::parse_from(path, line, format!("invalid glTF JSON: {error}"), error)
    })
}

/// Returns the image of each texture by [`WEBP`]. gltf-json offers it only as a map, together with all other
/// extensions.
#[cfg(feature = "more-textures")]
fn webp_images(json: &[u8]) -> Result<Vec<Option<usize>>, serde_json::Error> {
    #[derive(serde::Deserialize)]
    struct Root {
        #[serde(default)]
        textures: Vec<Texture>,
    }
    #[derive(serde::Deserialize)]
    struct Texture {
        extensions: Option<Extensions>,
    }
    #[derive(serde::Deserialize)]
    struct Extensions {
        #[serde(rename = "EXT_texture_webp")]
        webp: Option<Webp>,
    }
    #[derive(serde::Deserialize)]
    struct Webp {
        source: usize,
    }

    let root: Root = serde_json::from_slice(json)?;
    Ok(root.textures.into_iter().map(|texture| Some(texture.extensions?.webp?.source)).collect())
}

/// Returns the number of bytes outside strings, and how many of them begin an object. These take more memory than their
/// size.
fn structure(json: &[u8]) -> (u64, u64) {
    let (mut bytes, mut objects, mut in_string, mut escaped) = (0, 0, false, false);
    for &byte in json {
        match byte {
            b'"' if !escaped => in_string = !in_string,
            _ => bytes += u64::from(!in_string),
        }
        objects += u64::from(!in_string && byte == b'{');
        escaped = in_string && byte == b'\\' && !escaped;
    }
    (bytes, objects)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_and_objects_beside_strings_are_counted() {
        for (json, expected) in
            [("", (0, 0)), ("{}", (2, 1)), (r#"{"a": "b{"}"#, (4, 1)), (r#"["\"[{", "\\", 1, {}]"#, (11, 1))]
        {
            assert_eq!(structure(json.as_bytes()), expected, "{json}");
        }
    }
}
