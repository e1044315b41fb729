//! Steps after a view's last one, in scenes with mirrors, glass or veils: they trace the rays that such pixels send on.
//! First hits may be reused from another view, but these rays belong to each eye.

use super::step;
use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target::{Counters, Lists, View},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    layout::TO_TRACE,
    wgsl::part,
};

pub(crate) const LIST_MIRRORS: Kernel = Kernel {
    name: "list_mirrors",
    touches: Touches::Shading,
    storage: &[(View, Read), (Lists, Write)],
    main: part!("list_mirrors.wgsl"),
};
pub(crate) const TRACE_MIRRORED: Kernel = Kernel {
    name: "trace_mirrored",
    touches: Touches::Shading,
    storage: &[(Lists, Write), (View, Write), (Counters, Write)],
    main: part!("trace_mirrored.wgsl"),
};

pub(crate) fn of(view: usize) -> Vec<Step> {
    vec![
        Step::EmptyLists(Lists),
        step(&LIST_MIRRORS, view, Launch::Pixels),
        step(&TRACE_MIRRORED, view, Launch::Listed(Lists, TO_TRACE)),
    ]
}
