//! The steps that plans are made of: their kernels, what these read and write, and the host's part. A file each, beside
//! `shaders/`.

pub(crate) mod bracket;
pub(crate) mod edges;
pub(crate) mod host;
pub(crate) mod reproject;
pub(crate) mod resolve;
pub(crate) mod trace;

use crate::{
    frame::plan::{Launch, Step},
    kernels::Kernel,
    variant::{Part, part},
};

/// What many kernels count.
pub(crate) const COUNT: Part = part!("shared/count.wgsl");
const LIGHT_TRACED: Part = part!("shared/light_traced.wgsl");
const APPEND: Part = part!("shared/append.wgsl");
const LISTED_PIXELS: Part = part!("shared/listed_pixels.wgsl");
const PARALLAX: Part = part!("shared/parallax.wgsl");
const SWEEP: Part = part!("shared/sweep.wgsl");
pub(crate) const MARKS: Part = part!("shared/marks.wgsl");
pub(crate) const TILES: Part = part!("shared/tiles.wgsl");
pub(crate) const LISTS: Part = part!("shared/lists.wgsl");

/// A step of a view, named like its kernel.
fn step(kernel: &'static Kernel, view: usize, launch: Launch) -> Step {
    Step::Run { name: kernel.name, kernel, view, launch }
}
