//! Pass 2: assigns source samples to target pixels (thesis, 3.1.2; Es & Isler 2007).

use super::step;
use crate::{
    frame::plan::{Launch, Step},
    kernel::{Kernel, Role, kernel},
};

pub(crate) const REPROJECT: Kernel = kernel!("reproject", "reproject", Role::Pixels);
pub(crate) const REPROJECT_SLOTS: Kernel = kernel!("reproject", "reproject_slots", Role::Pixels);
pub(crate) const REPROJECT_SCANLINE: Kernel = kernel!("reproject", "reproject_scanline", Role::Pixels);
pub(crate) const GATHER_SLOTS: Kernel = kernel!("reproject", "gather_slots", Role::Pixels);
pub(crate) const DEPTH_RANGE: Kernel = kernel!("reproject", "depth_range", Role::Pixels);

/// Returns the step that keeps each pixel's nearest sample, by atomicMax.
pub(crate) fn atomic(view: usize) -> Vec<Step> {
    vec![step(&REPROJECT, view, Launch::Pixels)]
}

/// Returns the step that keeps each pixel's last sample of a sweep along its row.
pub(crate) fn scanline(view: usize) -> Vec<Step> {
    vec![step(&REPROJECT_SCANLINE, view, Launch::Rows)]
}

/// Returns the step that finds the nearest and farthest depth of each row. They determine the size of a 3D buffer.
pub(crate) fn depth_range(view: usize) -> Vec<Step> {
    vec![step(&DEPTH_RANGE, view, Launch::Rows)]
}

/// Returns the steps that find each pixel's nearest sample in the 3D buffer.
pub(crate) fn slots(view: usize) -> Vec<Step> {
    vec![Step::EmptySlots, step(&REPROJECT_SLOTS, view, Launch::Pixels), step(&GATHER_SLOTS, view, Launch::Pixels)]
}
