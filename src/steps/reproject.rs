//! Pass 2: which of the source's samples each of the target's pixels gets (thesis, 3.1.2; Es & Isler 2007).

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

/// The nearest sample, by atomicMax.
pub(crate) fn atomic(view: usize) -> Vec<Step> {
    vec![step(&REPROJECT, view, Launch::Pixels)]
}

/// The last one of a sweep along each row.
pub(crate) fn scanline(view: usize) -> Vec<Step> {
    vec![step(&REPROJECT_SCANLINE, view, Launch::Rows)]
}

/// Nearest and farthest depth of each row, for a 3D buffer's size.
pub(crate) fn depth_range(view: usize) -> Vec<Step> {
    vec![step(&DEPTH_RANGE, view, Launch::Rows)]
}

/// The nearest of all that the 3D buffer holds.
pub(crate) fn slots(view: usize) -> Vec<Step> {
    vec![Step::EmptySlots, step(&REPROJECT_SLOTS, view, Launch::Pixels), step(&GATHER_SLOTS, view, Launch::Pixels)]
}
