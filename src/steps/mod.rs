//! The steps that plans are made of, and their kernels. Most files correspond to a folder of `shaders/`.

pub(crate) mod bracket;
pub(crate) mod edges;
pub(crate) mod history;
pub(crate) mod mirrors;
pub(crate) mod paths;
pub(crate) mod reproject;
pub(crate) mod resolve;
pub(crate) mod soft;
pub(crate) mod trace;

use crate::{
    frame::plan::{Launch, Step},
    kernel::Kernel,
};

/// Returns the step that runs a kernel for a view, under the kernel's name.
pub(crate) fn step(kernel: &'static Kernel, view: usize, launch: Launch) -> Step {
    Step::Run { name: kernel.name, kernel, view, launch, part: 0 }
}
