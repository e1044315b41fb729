//! Verification without rays: edges of the left view are marked, to be traced (thesis, 6.2).

use super::{MARKS, PARALLAX, right};
use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target::{Hits, RightSource},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    variant::part,
};

pub(crate) const MARK_EDGES: Kernel = Kernel {
    name: "mark_edges",
    touches: Touches::Objects,
    storage: &[(Hits, Read), (RightSource, Write)],
    extra: &[PARALLAX, MARKS],
    main: part!("mark_edges.wgsl"),
};

pub(crate) fn mark() -> Vec<Step> {
    vec![right(&MARK_EDGES, Launch::Pixels)]
}
