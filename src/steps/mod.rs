//! The steps that plans are made of: their kernels, what these read and write, and the host's part. A file each, beside
//! `shaders/`.

pub(crate) mod bracket;
pub(crate) mod compose;
pub(crate) mod edges;
pub(crate) mod host;
pub(crate) mod reproject;
pub(crate) mod resolve;
pub(crate) mod trace;

use crate::{
    frame::plan::{Eye, Launch, Step},
    kernels::Kernel,
    variant::{Part, part},
};

/// What many kernels count.
pub(crate) const COUNT: Part = part!("shared/count.wgsl");
const LIGHT_TRACED: Part = part!("shared/light_traced.wgsl");
const APPEND: Part = part!("shared/append.wgsl");
const LISTED_PIXELS: Part = part!("shared/listed_pixels.wgsl");
const PARALLAX: Part = part!("shared/parallax.wgsl");
pub(crate) const MARKS: Part = part!("shared/marks.wgsl");
pub(crate) const LISTS: Part = part!("shared/lists.wgsl");

/// A step of the right view, named like its kernel.
fn right(kernel: &'static Kernel, launch: Launch) -> Step {
    Step::Run { name: kernel.name, kernel, eye: Eye::Right, launch }
}

/// A step of the left view, named like its kernel.
fn left(kernel: &'static Kernel, launch: Launch) -> Step {
    Step::Run { name: kernel.name, kernel, eye: Eye::Left, launch }
}
