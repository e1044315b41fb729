//! Pass 2: assigns source samples to target pixels (thesis, 3.1.2; Es & Isler 2007).

use super::step;
use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target::{Counters, Slots, Source, View},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    wgsl::part,
};

pub(crate) const REPROJECT: Kernel = Kernel {
    name: "reproject",
    touches: Touches::Pixels,
    storage: &[(Source, Read), (View, Write)],
    main: part!("reproject.wgsl"),
};
pub(crate) const REPROJECT_SLOTS: Kernel = Kernel {
    name: "reproject_slots",
    touches: Touches::Pixels,
    storage: &[(Source, Read), (Slots, Write), (Counters, Write)],
    main: part!("reproject_slots.wgsl"),
};
pub(crate) const REPROJECT_SCANLINE: Kernel = Kernel {
    name: "reproject_scanline",
    touches: Touches::Pixels,
    storage: &[(Source, Read), (View, Write)],
    main: part!("reproject_scanline.wgsl"),
};
pub(crate) const GATHER_SLOTS: Kernel = Kernel {
    name: "gather_slots",
    touches: Touches::Pixels,
    storage: &[(Slots, Read), (View, Write)],
    main: part!("gather_slots.wgsl"),
};
pub(crate) const DEPTH_RANGE: Kernel = Kernel {
    name: "depth_range",
    touches: Touches::Pixels,
    storage: &[(View, Read), (Counters, Write)],
    main: part!("depth_range.wgsl"),
};

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
