//! Verification without rays: marks edges of the source view, to be traced (thesis, 6.2).

use super::step;
use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target::{Source, View},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    wgsl::part,
};

pub(crate) const MARK_EDGES: Kernel = Kernel {
    name: "mark_edges",
    touches: Touches::Objects,
    storage: &[(Source, Read), (View, Write)],
    main: part!("mark_edges.wgsl"),
};

pub(crate) fn mark(view: usize) -> Vec<Step> {
    vec![step(&MARK_EDGES, view, Launch::Pixels)]
}
