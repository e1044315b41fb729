//! Traces and shades a whole view.

use super::{soft, step};
use crate::{
    frame::plan::{Launch, Step},
    kernel::layout::ALL_TRACED,
    kernel::{Dispatches, Kernel, Resource, Role, Shading, kernel},
};

pub(crate) const TRACE_LEFT: Kernel = kernel!("trace", "trace_left", Role::Shade(Shading::Traced(Dispatches::One)));
/// [`TRACE_LEFT`] in steps: threads continue in the next dispatch.
pub(crate) const TRACE_IN_STEPS: Kernel =
    kernel!("trace", "trace_in_steps", Role::Shade(Shading::Traced(Dispatches::Many)));

/// Returns the steps that make a source view.
pub(crate) fn source(view: usize, soft: Option<usize>) -> Vec<Step> {
    traced("trace_left", view, Launch::Pixels, soft)
}

/// Returns the steps that trace a view although it has a source.
pub(crate) fn target(view: usize, soft: Option<usize>) -> Vec<Step> {
    traced("trace_right", view, Launch::Pixels, soft)
}

/// Returns the step that traces a view in several dispatches.
pub(crate) fn in_steps(view: usize, source: usize) -> Step {
    step(&TRACE_IN_STEPS, view, Launch::Pixels).named(if view == source { "trace_left" } else { "trace_right" })
}

/// Returns the steps after [`in_steps`] that add soft light.
pub(crate) fn after_steps(view: usize, soft: Option<usize>) -> Vec<Step> {
    soft.map_or(Vec::new(), |parts| soft::behind_hits(view, Launch::Pixels, parts))
}

/// Returns the steps that trace a view in the bands for which the kernel `choose` selects tracing.
pub(crate) fn chosen(view: usize, soft: Option<usize>) -> Vec<Step> {
    traced("trace_right", view, Launch::Listed(Resource::Lists, ALL_TRACED), soft)
}

fn traced(name: &'static str, view: usize, launch: Launch, soft: Option<usize>) -> Vec<Step> {
    match soft {
        Some(parts) => soft::traced(view, launch, parts),
        None => vec![step(&TRACE_LEFT, view, launch).named(name)],
    }
}
