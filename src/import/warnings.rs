//! Warnings of a reader about one file.

use std::{collections::BTreeMap, fmt::Display, path::Path};

use crate::error::located;
use crate::scene::{PRINTED_WARNINGS, Scene, mesh::dropped_text};
#[cfg(feature = "obj")]
use crate::{Error, message::escaped};

/// The warnings of one file. Counts are logged on drop: once per file, also if reading fails.
pub(crate) struct Warnings<'a> {
    path: &'a Path,
    like: BTreeMap<&'static str, usize>,
    left_out: BTreeMap<&'static str, LeftOut>,
}

struct LeftOut {
    count: usize,
    first: Place,
}

/// A place in a file.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    Line(usize),
    /// An item of a list in a glTF file, such as `nodes[3]`.
    #[cfg_attr(not(feature = "gltf"), allow(dead_code, reason = "the other formats have lines"))]
    Item(&'static str, usize),
    /// The file as a whole.
    #[cfg_attr(not(any(feature = "gltf", feature = "ply")), allow(dead_code, reason = "an OBJ has lines"))]
    File,
}

impl From<usize> for Place {
    fn from(line: usize) -> Self {
        Self::Line(line)
    }
}

impl LeftOut {
    fn text(&self, what: &str) -> String {
        match (self.count, self.first) {
            (1, Place::Line(line)) => format!("{what} on line {line}"),
            (count, Place::Line(line)) => format!("{count} {what} from line {line} on"),
            (1, Place::Item(list, index)) => format!("{what} in {list}[{index}]"),
            (count, Place::Item(list, index)) => format!("{count} {what} from {list}[{index}] on"),
            (1, Place::File) => what.into(),
            (count, Place::File) => format!("{count} {what}"),
        }
    }
}

impl<'a> Warnings<'a> {
    pub(crate) fn new(path: &'a Path) -> Self {
        Self { path, like: BTreeMap::new(), left_out: BTreeMap::new() }
    }

    /// Logs a warning about a line, or about the item that the text names. `kind` is the heading of similar warnings,
    /// of which only the first are logged.
    #[cfg(any(feature = "obj", feature = "gltf"))]
    pub(crate) fn warn(&mut self, kind: &'static str, line: impl Into<Option<usize>>, text: impl Display) {
        if self.is_printed(kind) {
            self.log(line.into(), text.to_string());
        }
    }

    /// Logs an error about another file that a line names, and its consequence.
    #[cfg(feature = "obj")]
    pub(crate) fn warn_of(&mut self, kind: &'static str, line: usize, error: &Error, consequence: &str) {
        if self.is_printed(kind) {
            let name = escaped(&self.path.file_name().unwrap_or_default().to_string_lossy());
            log::warn!("{error}; {consequence} (line {line} of {name})");
        }
    }

    /// Counts a warning and returns whether it is among the first of its kind.
    #[cfg(any(feature = "obj", feature = "gltf"))]
    fn is_printed(&mut self, kind: &'static str) -> bool {
        let count = self.like.entry(kind).or_default();
        *count += 1;
        *count <= PRINTED_WARNINGS
    }

    /// Logs a warning about the whole file.
    pub(crate) fn warn_once(&self, text: impl Display) {
        self.log(None, text.to_string());
    }

    /// Logs a warning about triangles without area.
    pub(crate) fn warn_of_dropped(&self, scene: &Scene) {
        if scene.dropped > 0 {
            self.warn_once(dropped_text(scene.dropped, &scene.triangles));
        }
    }

    /// Counts an unsupported item of the file; `what` names its kind in the plural.
    pub(crate) fn left_out(&mut self, what: &'static str, place: impl Into<Place>) {
        self.left_out.entry(what).or_insert(LeftOut { count: 0, first: place.into() }).count += 1;
    }

    /// Formats a warning as errors are formatted, so both quote files alike.
    fn log(&self, line: Option<usize>, text: String) {
        log::warn!("{}", located(self.path, line, &text));
    }
}

impl Drop for Warnings<'_> {
    fn drop(&mut self) {
        for (kind, count) in &self.like {
            if *count > PRINTED_WARNINGS {
                self.log(None, format!("{kind}: {} more", count - PRINTED_WARNINGS));
            }
        }
        let items: Vec<_> = self.left_out.iter().map(|(what, left_out)| left_out.text(what)).collect();
        if !items.is_empty() {
            self.log(None, format!("ignored: {}", items.join("; ")));
        }
    }
}
