//! Scenes and methods by name, in the order in which they are shown.

use super::Picture;
use crate::record::Record;

/// Scenes and methods in the order in which they are shown. A method's place gives it its look, a scene's its colour.
pub(super) struct Names {
    pub(super) scenes: Vec<String>,
    pub(super) methods: Vec<String>,
}

/// The methods whose looks are the same in every report; others follow as they come.
const METHODS: [&str; 10] = [
    "naive",
    "ideal",
    "atomic",
    "buffer",
    "buffer-2e",
    "es-isler",
    "adelson-hodges",
    "atomic-edges",
    "bracket",
    "verified",
];
/// Those that the thesis does not have, and those that only its future work names.
pub(super) const OWN: [&str; 4] = ["bracket", "verified", "bracket-rays", "auto"];
pub(super) const FUTURE_WORK: [&str; 2] = ["atomic-edges", "buffer-edges"];

impl Names {
    pub(super) fn of(records: &[Record], pictures: &[Picture]) -> Self {
        let pairs = records.iter().map(|r| (&r.scene, &r.method)).chain(pictures.iter().map(|p| (&p.scene, &p.method)));
        let methods = METHODS.into_iter().chain(pairs.clone().map(|(_, method)| method.as_str()));
        Self { scenes: distinct(pairs.map(|(scene, _)| scene.clone())), methods: distinct(methods.map(String::from)) }
    }

    /// An unknown name's place is behind all others.
    pub(super) fn scene(&self, name: &str) -> usize {
        self.scenes.iter().position(|scene| scene == name).unwrap_or(self.scenes.len())
    }

    pub(super) fn method(&self, name: &str) -> usize {
        self.methods.iter().position(|method| method == name).unwrap_or(self.methods.len())
    }
}

/// Each value once, in order of its first appearance.
pub(super) fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut kept = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    kept
}
