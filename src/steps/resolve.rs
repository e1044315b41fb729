//! Pass 3 of the thesis's methods: what was carried over is checked, and what is bad or missing is traced (thesis, 3.1.3).

use super::{APPEND, COUNT, LIGHT_TRACED, LISTED_PIXELS, LISTS, MARKS, edges, right};
use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target::{Counters, Hits, Lists, RightColor, RightSource},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    layout::TO_TRACE,
    method::Check,
    variant::part,
};

pub(crate) const RESOLVE_RIGHT: Kernel = Kernel {
    name: "resolve_right",
    touches: Touches::Geometry,
    storage: &[(Hits, Read), (RightSource, Write), (Counters, Write), (Lists, Write)],
    extra: &[part!("shared/verify_all.wgsl"), COUNT, MARKS, LISTS, APPEND],
    main: part!("resolve_right.wgsl"),
};
/// The same without checks: gaps are no candidates any more, and edges have been marked.
pub(crate) const RESOLVE_TRUSTED: Kernel = Kernel {
    name: "resolve_trusted",
    extra: &[part!("shared/verify_none.wgsl"), COUNT, MARKS, LISTS, APPEND],
    ..RESOLVE_RIGHT
};
pub(crate) const TRACE_LISTED: Kernel = Kernel {
    name: "trace_listed",
    touches: Touches::Shading,
    storage: &[(Lists, Write), (Hits, Write), (RightColor, Write), (Counters, Write)],
    extra: &[COUNT, LISTS, LISTED_PIXELS, LIGHT_TRACED],
    main: part!("trace_listed.wgsl"),
};

pub(crate) fn of(check: Check) -> Vec<Step> {
    let mut steps = if check == Check::Edges { edges::mark() } else { Vec::new() };
    let checked = match check {
        Check::All => right(&RESOLVE_RIGHT, Launch::Pixels),
        Check::Edges | Check::None => right(&RESOLVE_TRUSTED, Launch::Pixels),
    };
    steps.extend([Step::EmptyLists, checked.named(RESOLVE_RIGHT.name), right(&TRACE_LISTED, Launch::Listed(TO_TRACE))]);
    steps
}
