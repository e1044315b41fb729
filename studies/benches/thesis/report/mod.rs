//! Writes the report: plots by question and scene, pictures and a table of all records, in one self-contained page.

mod accuracy;
mod axis;
mod drawing;
mod frame;
mod gallery;
mod line_plot;
mod names;
mod page;
mod questions;
mod scatter;
mod sections;
mod sources;
mod stability;
mod table;
#[cfg(test)]
mod tests;
mod text;

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use self::{names::Names, page::page, sections::sections};
pub(crate) use self::{sources::Sources, stability::Stability};
use crate::{common::files::save, record::Record};

/// Ranges of the speed-up over naive that the thesis states. An entry has a scene, or `*` for all scenes, a method, and
/// the lowest and highest value in percent. The ranges are drawn behind the speed-up against the picture's width.
///
/// The thesis averages each speed-up over the picture sizes. A range extends from the scene with the lowest average on
/// one machine to the scene with the highest average on the other (figures 27 and 35).
const BANDS: &[(&str, &str, f64, f64)] =
    &[("*", "ideal", 29.0, 92.0), ("*", "atomic", 14.0, 67.0), ("*", "buffer", 6.0, 58.0)];

/// A picture beside the plots.
pub(crate) struct Picture {
    pub(crate) scene: String,
    pub(crate) method: String,
    /// Content of the picture: left, right, anaglyph, difference x8, re-trace map, cost left, cost right.
    pub(crate) kind: String,
    pub(crate) caption: String,
    /// Contents of a PNG file.
    pub(crate) png: Vec<u8>,
}

/// Content of the page.
#[derive(Default)]
pub(crate) struct Content {
    pub(crate) records: Vec<Record>,
    pub(crate) pictures: Vec<Picture>,
    pub(crate) sources: Vec<Sources>,
    /// Results of the stability benchmark, or `None` if it has not run.
    pub(crate) stability: Option<Stability>,
    /// Whether it was a smoke run, whose figures are meaningless.
    pub(crate) smoke: bool,
}

/// Writes report.html and one SVG per plot into `folder`. Either all files are written, or none. Returns their paths,
/// with the page's path last. If a configuration was measured more than once, plots show its last record and the table
/// shows all.
pub(crate) fn write(content: &Content, folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let names = Names::of(&content.records, &content.pictures);
    let sections = sections(content, &names, BANDS)?;
    let page = page(content, &names, &sections);
    let figures = sections.into_iter().flat_map(|section| section.groups).flat_map(|group| group.figures);
    let mut files: Vec<(String, String)> = figures.map(|figure| (format!("{}.svg", figure.name), figure.svg)).collect();
    files.push(("report.html".into(), page));
    save(&files, folder)
}
