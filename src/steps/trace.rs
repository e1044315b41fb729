//! A whole view, traced and shaded.

use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target,
    },
    kernels::{Access::Write, Kernel, Touches},
    layout::ALL_TRACED,
    wgsl::part,
};

pub(crate) const TRACE_LEFT: Kernel = Kernel {
    name: "trace_left",
    touches: Touches::Shading,
    storage: &[(Target::View, Write), (Target::Counters, Write)],
    main: part!("trace_left.wgsl"),
};
/// The same, its threads going on in the next dispatch.
pub(crate) const TRACE_IN_STEPS: Kernel =
    Kernel { name: "trace_in_steps", main: part!("trace_in_steps.wgsl"), ..TRACE_LEFT };

/// A view from which others are made.
pub(crate) fn source(view: usize) -> Vec<Step> {
    vec![Step::Run { name: "trace_left", kernel: &TRACE_LEFT, view, launch: Launch::Pixels }]
}

/// A view that is traced though it has a source.
pub(crate) fn target(view: usize) -> Vec<Step> {
    vec![Step::Run { name: "trace_right", kernel: &TRACE_LEFT, view, launch: Launch::Pixels }]
}

/// The same where `choose` wants it.
pub(crate) fn chosen(view: usize) -> Vec<Step> {
    vec![Step::Run {
        name: "trace_right",
        kernel: &TRACE_LEFT,
        view,
        launch: Launch::Listed(Target::Found, ALL_TRACED),
    }]
}
