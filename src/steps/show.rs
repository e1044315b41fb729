//! Writes views to textures on the device, and packs them for reading back.

use crate::{
    frame::targets::Target::{Counters, Packed, Unfinished, View},
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    wgsl::part,
};

pub(crate) const PACK: Kernel = Kernel {
    name: "pack",
    touches: Touches::Pixels,
    storage: &[(View, Read), (Packed, Write)],
    main: part!("pack.wgsl"),
};
pub(crate) const SHOW_COLOR: Kernel = Kernel {
    name: "show_color",
    touches: Touches::Pixels,
    storage: &[(View, Read), (Counters, Read), (Unfinished, Write)],
    main: part!("show_color.wgsl"),
};
pub(crate) const SHOW_DEPTH: Kernel =
    Kernel { name: "show_depth", touches: Touches::Pixels, storage: &[(View, Read)], main: part!("show_depth.wgsl") };
