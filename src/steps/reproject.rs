//! Pass 2: which left sample each right pixel gets (thesis, 3.1.2; Es & Isler 2007).

use super::{PARALLAX, left, right};
use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target::{Counters, Hits, RightSource, Slots},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    variant::part,
};

pub(crate) const REPROJECT: Kernel = Kernel {
    name: "reproject",
    touches: Touches::Pixels,
    storage: &[(Hits, Read), (RightSource, Write)],
    extra: &[PARALLAX],
    main: part!("reproject.wgsl"),
};
pub(crate) const REPROJECT_SLOTS: Kernel = Kernel {
    name: "reproject_slots",
    touches: Touches::Pixels,
    storage: &[(Hits, Read), (Slots, Write), (Counters, Write)],
    extra: &[PARALLAX],
    main: part!("reproject_slots.wgsl"),
};
pub(crate) const REPROJECT_SCANLINE: Kernel = Kernel {
    name: "reproject_scanline",
    touches: Touches::Pixels,
    storage: &[(Hits, Read), (RightSource, Write)],
    extra: &[PARALLAX],
    main: part!("reproject_scanline.wgsl"),
};
pub(crate) const GATHER_SLOTS: Kernel = Kernel {
    name: "gather_slots",
    touches: Touches::Pixels,
    storage: &[(Slots, Read), (RightSource, Write)],
    extra: &[],
    main: part!("gather_slots.wgsl"),
};
pub(crate) const DEPTH_RANGE: Kernel = Kernel {
    name: "depth_range",
    touches: Touches::Pixels,
    storage: &[(Hits, Read), (Counters, Write)],
    extra: &[],
    main: part!("depth_range.wgsl"),
};

/// The nearest sample, by atomicMax.
pub(crate) fn atomic() -> Vec<Step> {
    vec![right(&REPROJECT, Launch::Pixels)]
}

/// The last one of a sweep along each row.
pub(crate) fn scanline() -> Vec<Step> {
    vec![right(&REPROJECT_SCANLINE, Launch::Rows)]
}

/// Nearest and farthest depth of each row, for a 3D buffer's size.
pub(crate) fn depth_range() -> Vec<Step> {
    vec![left(&DEPTH_RANGE, Launch::Rows)]
}

/// The nearest of all that the 3D buffer holds.
pub(crate) fn slots() -> Vec<Step> {
    vec![Step::EmptySlots, right(&REPROJECT_SLOTS, Launch::Pixels), right(&GATHER_SLOTS, Launch::Pixels)]
}
