//! Orders scenes and methods as they are shown.

use super::Picture;
use crate::{common::looks, record::Record};

/// Scenes and methods in the order in which they are shown.
pub(super) struct Names {
    pub(super) scenes: Vec<String>,
    pub(super) methods: Vec<String>,
}

/// Methods that the thesis does not have, and methods that it names only as future work.
pub(super) const OWN: [&str; 4] = ["bracket", "verified", "bracket-rays", "auto"];
pub(super) const FUTURE_WORK: [&str; 2] = ["atomic-edges", "buffer-edges"];

impl Names {
    pub(super) fn of(records: &[Record], pictures: &[Picture]) -> Self {
        let pairs = records.iter().map(|r| (&r.scene, &r.method)).chain(pictures.iter().map(|p| (&p.scene, &p.method)));
        let methods = looks::METHODS.into_iter().chain(pairs.clone().map(|(_, method)| method.as_str()));
        Self { scenes: distinct(pairs.map(|(scene, _)| scene.clone())), methods: distinct(methods.map(String::from)) }
    }

    /// Returns the index of a scene. Unknown names are placed behind all others.
    pub(super) fn scene(&self, name: &str) -> usize {
        self.scenes.iter().position(|scene| scene == name).unwrap_or(self.scenes.len())
    }

    /// Returns the look of the method at this index.
    pub(super) fn look(&self, method: usize) -> usize {
        self.methods.get(method).map_or(method, |name| looks::of_method(name))
    }

    pub(super) fn method(&self, name: &str) -> usize {
        self.methods.iter().position(|method| method == name).unwrap_or(self.methods.len())
    }
}

/// Returns each value once, in order of first appearance.
pub(super) fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut kept = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    kept
}
