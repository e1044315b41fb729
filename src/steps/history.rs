//! Finds the hits of a traced view by the samples of an earlier frame (docs/BRACKET.md, "Earlier frames").

use super::{bracket, soft, step};
use crate::{
    frame::plan::{Launch, Search, Step},
    kernel::layout::{QUAD, QUAD_RUN},
    kernel::{Kernel, Role, kernel},
};

pub(crate) const BOUND_BY_HISTORY: Kernel = kernel!("history", "bound_by_history", Role::Pixels);

/// Returns the step that bounds the tiles of a whole view, before its first band.
pub(crate) fn bound(view: usize) -> Vec<Step> {
    vec![step(&BOUND_BY_HISTORY, view, Launch::Picture([QUAD * QUAD_RUN, QUAD]))]
}

/// Returns the steps that make a source view within these bounds. All its shadow rays are traced.
pub(crate) fn source(view: usize, soft: Option<usize>, search: Search) -> Vec<Step> {
    let hits = bracket::hits(view, search);
    [vec![Step::CopyBounds(view)], hits, soft::behind_hits(view, Launch::Pixels, soft.unwrap_or(0))].concat()
}
