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

/// Keeps the nearest sample, by atomicMax.
pub(crate) fn atomic(view: usize) -> Vec<Step> {
    vec![step(&REPROJECT, view, Launch::Pixels)]
}

/// Keeps the last sample of a sweep along each row.
pub(crate) fn scanline(view: usize) -> Vec<Step> {
    vec![step(&REPROJECT_SCANLINE, view, Launch::Rows)]
}

/// Finds the nearest and farthest depth of each row, for the size of a 3D buffer.
pub(crate) fn depth_range(view: usize) -> Vec<Step> {
    vec![step(&DEPTH_RANGE, view, Launch::Rows)]
}

/// Keeps the nearest sample in the 3D buffer.
pub(crate) fn slots(view: usize) -> Vec<Step> {
    vec![Step::EmptySlots, step(&REPROJECT_SLOTS, view, Launch::Pixels), step(&GATHER_SLOTS, view, Launch::Pixels)]
}
