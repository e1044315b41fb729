//! Pass 3 of the thesis's methods: checks reused pixels and traces bad and missing pixels (thesis, 3.1.3).

use super::{edges, soft, step};
use crate::{
    ask::method::Check,
    frame::plan::{Launch, Step},
    kernel::layout::TO_TRACE,
    kernel::wgsl::part,
    kernel::{Hits, Kernel, Resource::Lists, Role, Shading, kernel},
};

pub(crate) const RESOLVE_RIGHT: Kernel = kernel!("resolve", "resolve_right", Role::Hits(Hits::Checked));
/// [`RESOLVE_RIGHT`] without checks by rays. Gaps have been cleared by the sweep, or edges have been marked, or all
/// reused pixels are trusted.
pub(crate) const RESOLVE_TRUSTED: Kernel =
    Kernel { name: "resolve_trusted", role: Role::Hits(Hits::Trusted), ..RESOLVE_RIGHT };
pub(crate) const TRACE_LISTED: Kernel = kernel!("resolve", "trace_listed", Role::Hits(Hits::Listed));
/// Shades traced pixels.
pub(crate) const SHADE_TRACED: Kernel =
    Kernel { name: "shade_traced", role: Role::Shade(Shading::Listed), main: part!("resolve/shade_listed.wgsl") };

/// Copies reused pixels from the source.
pub(crate) const TAKE_OVER: Kernel = kernel!("resolve", "take_over", Role::LinearPixels);

pub(crate) fn of(view: usize, check: Check, soft: Option<usize>) -> Vec<Step> {
    let mut steps = if check == Check::Edges { edges::mark(view) } else { Vec::new() };
    let checked = match check {
        Check::All => step(&RESOLVE_RIGHT, view, Launch::Pixels),
        Check::Edges | Check::None => step(&RESOLVE_TRUSTED, view, Launch::Pixels),
    };
    steps.extend([
        Step::EmptyLists,
        checked.named(RESOLVE_RIGHT.name),
        step(&TRACE_LISTED, view, Launch::Listed(Lists, TO_TRACE)),
    ]);
    steps.extend(soft::listed(view, TO_TRACE, soft));
    steps.extend([step(&SHADE_TRACED, view, Launch::Listed(Lists, TO_TRACE)), step(&TAKE_OVER, view, Launch::Pixels)]);
    steps
}
