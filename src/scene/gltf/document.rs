//! A glTF file taken apart: its JSON, and the bytes that this names.

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

use super::nodes::{Shifts, shifts};
use crate::{Error, Limits, input::Files, message::counted, scene::warnings::Warnings};

/// Textures have a WebP picture by this one.
#[cfg(feature = "more-textures")]
const WEBP: &str = "EXT_texture_webp";

/// What is read of extensions, or makes no difference to what is read.
const EXTENSIONS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    #[cfg(feature = "more-textures")]
    WEBP,
];

/// Padding may be missing.
const BASE64: engine::GeneralPurpose = engine::GeneralPurpose::new(
    &alphabet::STANDARD,
    engine::GeneralPurposeConfig::new().with_decode_padding_mode(engine::DecodePaddingMode::Indifferent),
);

/// How a URI begins that holds its bytes itself.
const DATA: &str = "data:";

/// What an object of the JSON counts as at least: two bytes may become a material of some 280.
const OBJECT_BYTES: u64 = 32;

/// A file's JSON and what belongs to it.
pub(super) struct Document<'a> {
    pub(super) files: Files<'a>,
    pub(super) path: &'a Path,
    pub(super) root: Root,
    /// Of each node, in f64; `root` has them in f32.
    pub(super) shifts: Vec<Shifts>,
    pub(super) limits: Limits,
    /// The images that textures have by [`WEBP`].
    #[cfg(feature = "more-textures")]
    webp: Vec<Option<usize>>,
    /// A binary file, and where its buffer is in it.
    chunk: Option<(Cow<'a, [u8]>, Range<usize>)>,
    /// Each is read when it is first asked for.
    buffers: Vec<OnceCell<Rc<Cow<'a, [u8]>>>>,
    /// Those that are files, each read once.
    files_read: RefCell<HashMap<PathBuf, Rc<Cow<'a, [u8]>>>>,
    /// Bytes of the file itself.
    bytes: u64,
    /// Bytes that further files may have.
    bytes_left: Cell<u64>,
}

impl<'a> Document<'a> {
    pub(super) fn open(files: Files<'a>, path: &'a Path, limits: Limits) -> Result<Self, Error> {
        let bytes = files.read_bytes(path, limits.file_bytes, limits.option_names[0])?;
        let is_binary = bytes.starts_with(b"glTF");
        let fault = |reason: String| Error::parse(path, None, reason);
        let (json, chunk) = if is_binary { chunks(&bytes).map_err(fault)? } else { (0..bytes.len(), None) };
        let json = without_mark(&bytes[json]);
        let root = parse(path, json, is_binary, &limits)?;
        let shifts = shifts(json).map_err(|error| fault(format!("no JSON of glTF: {error}")))?;
        #[cfg(feature = "more-textures")]
        let webp = match root.extensions_used.iter().any(|name| name == WEBP) {
            true => webp_images(json).map_err(|error| {
                Error::parse_from(path, None, format!("textures of {WEBP} are wrong: {error}"), error)
            })?,
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
            limits,
            #[cfg(feature = "more-textures")]
            webp,
            chunk,
            buffers,
            files_read,
            bytes: count,
            bytes_left,
        };
        match document.root.asset.version.split('.').next() {
            Some("2") => Ok(document),
            _ => Err(document.fault(format!("it is glTF {}; version 2 is read", document.root.asset.version))),
        }
    }

    /// Refuses what a reader must know and this one does not, and warns of what it need not know.
    pub(super) fn check_extensions(&self, warnings: &Warnings) -> Result<(), Error> {
        let unknown = |names: &'_ [String]| -> Vec<String> {
            names.iter().filter(|name| !EXTENSIONS.contains(&&***name)).cloned().collect()
        };
        let required = unknown(&self.root.extensions_required);
        if !required.is_empty() {
            let reason = format!("it requires {}; what is known is {}", required.join(", "), EXTENSIONS.join(", "));
            return Err(self.fault(reason));
        }
        let used = unknown(&self.root.extensions_used);
        if !used.is_empty() {
            warnings.warn_once(format!("extensions that are left out: {}", used.join(", ")));
        }
        Ok(())
    }

    pub(super) fn fault(&self, reason: String) -> Error {
        Error::parse(self.path, None, reason)
    }

    /// An item of a list; `by` says what names it.
    pub(super) fn item<'b, T>(
        &self,
        (list, items): (&str, &'b [T]),
        index: usize,
        by: impl Display,
    ) -> Result<&'b T, Error> {
        items.get(index).ok_or_else(|| self.fault(format!("{by}: there is no {list}[{index}], of {}", items.len())))
    }

    /// The image that a texture has by an extension that is read.
    pub(super) fn extended_image(&self, _texture: usize) -> Option<usize> {
        #[cfg(feature = "more-textures")]
        return self.webp.get(_texture).copied().flatten();
        #[cfg(not(feature = "more-textures"))]
        None
    }

    /// The bytes of a view.
    pub(super) fn view(&self, index: Index<View>, by: impl Display) -> Result<(&View, &[u8]), Error> {
        let view = self.item(("bufferViews", &self.root.buffer_views), index.value(), by)?;
        let name = format!("bufferViews[{}]", index.value());
        let buffer = self.buffer(view.buffer, &name)?;
        let (start, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        let bytes = range(start, length).and_then(|range| buffer.get(range));
        let bytes = bytes.ok_or_else(|| {
            let size = counted(buffer.len(), "byte", "bytes");
            self.fault(format!("{name}: {length} bytes from byte {start} on, in a buffer of {size}"))
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
            self.fault(format!("{name}: its byteLength is {length}, and it has {found}"))
        })
    }

    /// Bytes of the file and of those beside it that have been read.
    pub(super) fn bytes_read(&self) -> u64 {
        self.bytes + (self.limits.file_bytes - self.bytes_left.get())
    }

    /// The bytes that a URI holds or names. All files together may have as many as the file itself.
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

    /// Whether a URI holds its bytes itself.
    #[cfg(feature = "textures")]
    pub(super) fn is_data(uri: &str) -> bool {
        uri.starts_with(DATA)
    }

    /// The bytes of a data URI, if it is one.
    pub(super) fn decoded(&self, uri: &str, by: &str) -> Result<Option<Vec<u8>>, Error> {
        let Some(data) = uri.strip_prefix(DATA) else { return Ok(None) };
        let text = data.split_once(',').filter(|(kind, _)| kind.ends_with(";base64")).map(|(_, text)| text);
        let text = text.ok_or_else(|| self.fault(format!("{by}: its data URI is not base64")))?;
        let bytes = BASE64.decode(text).map_err(|error| {
            Error::parse_from(self.path, None, format!("{by}: its data URI is no base64: {error}"), error)
        })?;
        Ok(Some(bytes))
    }

    /// The file that a URI names, relative to this file.
    pub(super) fn located(&self, uri: &str, by: &str) -> Result<PathBuf, Error> {
        // A drive's letter is no scheme.
        let scheme = uri.split_once(':').map(|(scheme, _)| scheme).filter(|scheme| {
            scheme.len() > 1 && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
        });
        if let Some(scheme) = scheme {
            return Err(self.fault(format!("{by}: URIs of '{scheme}:' are not read; files and base64 data are")));
        }
        let name: Cow<'_, str> = percent_decode_str(uri).decode_utf8_lossy();
        let located = self.files.locate(self.path.parent().unwrap_or(Path::new("")), &name);
        located.map_err(|error| Error::parse_from(self.path, None, format!("{by}: {error}"), error))
    }
}

fn range(start: u64, length: u64) -> Option<Range<usize>> {
    let end = start.checked_add(length)?;
    Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
}

/// Where the JSON and the buffer of a binary file are.
fn chunks(bytes: &[u8]) -> Result<(Range<usize>, Option<Range<usize>>), String> {
    let word = |at: usize| bytes.get(at..at + 4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    let (Some(version), Some(length)) = (word(4), word(8)) else { return Err("the file ends in its header".into()) };
    if version != 2 {
        return Err(format!("it is binary glTF {version}; version 2 is read"));
    }
    if length as usize > bytes.len() {
        let found = counted(bytes.len(), "byte", "bytes");
        return Err(format!("it has {found} of the {length} that its header says"));
    }
    let (mut at, mut json, mut buffer) = (12, None, None);
    while let (Some(size), Some(kind)) = (word(at), word(at + 4)) {
        let content = range(at as u64 + 8, size.into()).filter(|content| content.end <= length as usize);
        let content =
            content.ok_or_else(|| format!("the chunk at byte {at} has {size} bytes, beyond the file's end"))?;
        at = content.end;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(content),
            b"BIN\0" if buffer.is_none() => buffer = Some(content),
            _ => {} // what other chunks hold is for those who know them
        }
    }
    json.map(|json| (json, buffer)).ok_or_else(|| "it has no JSON chunk".into())
}

/// JSON without a byte order mark.
fn without_mark(json: &[u8]) -> &[u8] {
    json.strip_prefix("\u{feff}".as_bytes()).unwrap_or(json)
}

fn parse(path: &Path, json: &[u8], is_binary: bool, limits: &Limits) -> Result<Root, Error> {
    let (bytes, objects) = structure(json);
    if bytes.max(OBJECT_BYTES * objects) > limits.json_bytes {
        let size = match bytes > limits.json_bytes {
            true => format!("its JSON has {} beside its strings", counted(bytes, "byte", "bytes")),
            false => format!(
                "its JSON has {objects} objects, which count as {OBJECT_BYTES} bytes each, {} in all",
                OBJECT_BYTES * objects
            ),
        };
        return Err(Error::TooLarge {
            path: path.into(),
            size,
            limit: limits.json_bytes,
            remedy: format!("raise it by {}, if it is right", limits.option_names[0]),
        });
    }
    Root::from_slice(json).map_err(|error| {
        let line = Some(error.line()).filter(|&line| line > 0 && !is_binary);
        Error::parse_from(path, line, format!("no JSON of glTF: {error}"), error)
    })
}

/// The image of each texture by [`WEBP`]: gltf-json has it only with all other extensions, as maps.
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

/// How many bytes stand beside strings, and how many of them begin an object: what takes more memory than it has bytes.
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
