//! A file for each command: what it takes, what it does, and what it says at the end.

pub(crate) mod compare;
pub(crate) mod dataset;
pub(crate) mod info;
mod motion;
pub(crate) mod render;
mod report;
pub(crate) mod sequence;
pub(crate) mod views;
