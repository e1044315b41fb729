//! What a reader warns of in one file.

use std::{collections::BTreeMap, fmt::Display, path::Path};

use super::PRINTED_WARNINGS;
use crate::{Error, error::located, message::escaped};

/// The warnings of one file. What is counted is logged when they are dropped: once a file, also where reading it fails.
pub(super) struct Warnings<'a> {
    path: &'a Path,
    like: BTreeMap<&'static str, usize>,
    left_out: BTreeMap<&'static str, LeftOut>,
}

struct LeftOut {
    count: usize,
    first_line: usize,
}

impl<'a> Warnings<'a> {
    pub(super) fn new(path: &'a Path) -> Self {
        Self { path, like: BTreeMap::new(), left_out: BTreeMap::new() }
    }

    /// Warns of a line. Warnings of one `kind`, which is a heading for them, are alike.
    pub(super) fn warn(&mut self, kind: &'static str, line: usize, text: impl Display) {
        if self.is_printed(kind) {
            self.log(Some(line), text.to_string());
        }
    }

    /// Warns of another file that a line names, and of what follows from it.
    pub(super) fn warn_of(&mut self, kind: &'static str, line: usize, error: &Error, consequence: &str) {
        if self.is_printed(kind) {
            let name = escaped(&self.path.file_name().unwrap_or_default().to_string_lossy());
            log::warn!("{error}; {consequence} (line {line} of {name})");
        }
    }

    /// Counts a warning and says whether it is among the first of its kind.
    fn is_printed(&mut self, kind: &'static str) -> bool {
        let count = self.like.entry(kind).or_default();
        *count += 1;
        *count <= PRINTED_WARNINGS
    }

    /// Warns of the file as a whole.
    pub(super) fn warn_once(&self, text: impl Display) {
        self.log(None, text.to_string());
    }

    /// Counts something that the file has and pictures don't show; `what` names it in the plural.
    pub(super) fn left_out(&mut self, what: &'static str, line: usize) {
        self.left_out.entry(what).or_insert(LeftOut { count: 0, first_line: line }).count += 1;
    }

    /// As errors are written, so that both quote files alike.
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
        let item = |(what, LeftOut { count, first_line }): (&&str, &LeftOut)| match count {
            1 => format!("{what} on line {first_line}"),
            _ => format!("{count} {what} from line {first_line} on"),
        };
        let items: Vec<_> = self.left_out.iter().map(item).collect();
        if !items.is_empty() {
            self.log(None, format!("left out: {}", items.join("; ")));
        }
    }
}
