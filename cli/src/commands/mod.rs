//! Each file implements one command: its arguments, its work and its summary.

pub(crate) mod bench;
pub(crate) mod compare;
pub(crate) mod dataset;
mod ffmpeg;
pub(crate) mod info;
mod motion;
mod names;
mod quilt;
pub(crate) mod render;
mod report;
pub(crate) mod sequence;
pub(crate) mod verify;
pub(crate) mod views;
