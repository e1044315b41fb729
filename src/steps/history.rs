//! Finds the hits of a traced view by the samples of an earlier frame (docs/BRACKET.md, "Earlier frames").

use super::{
    bracket::{self, Shaders},
    soft, step,
};
use crate::{
    frame::plan::{Launch, Search, Step},
    kernel::layout::{QUAD, QUAD_RUN, WORKGROUP},
    kernel::{Kernel, Role, Shading, kernel},
};

pub(crate) const BOUND_BY_HISTORY: Kernel = kernel!("history", "bound_by_history", Role::Pixels);
/// Marks busy lights, if visibility bits are recalled.
pub(crate) const MARK_BUSY_BY_HISTORY: Kernel = kernel!("history", "mark_busy_by_history", Role::MarkBusy);
pub(crate) const SHADE_RECALLED_SKY: Kernel =
    Kernel { name: "shade_recalled_sky", role: Role::Shade(Shading::RecalledSky), ..bracket::SHADE_SKY };
pub(crate) const SHADE_RECALLED: Kernel =
    Kernel { name: "shade_recalled", role: Role::Shade(Shading::Recalled), ..bracket::SHADE_TILES };
pub(crate) const TRACE_SOFT_RECALLED: Kernel =
    Kernel { name: "trace_soft_recalled", role: Role::Shade(Shading::RecalledSoft), ..soft::TRACE_SOFT_LISTED };
pub(crate) const SHADE_RECALLED_LISTED: Kernel =
    Kernel { name: "shade_recalled_listed", role: Role::Shade(Shading::RecalledUnknown), ..bracket::SHADE_LISTED };

/// The kernels that shade a traced view and reuse the bits of an earlier frame.
const BY_HISTORY: Shaders = Shaders {
    sky: &SHADE_RECALLED_SKY,
    tiles: &SHADE_RECALLED,
    soft: &TRACE_SOFT_RECALLED,
    listed: &SHADE_RECALLED_LISTED,
};

/// Returns the steps that bound the tiles of a whole view, before its first band. `bits` says whether busy lights are
/// marked too.
pub(crate) fn bound(view: usize, bits: bool) -> Vec<Step> {
    let mut steps = vec![step(&BOUND_BY_HISTORY, view, Launch::Picture([QUAD * QUAD_RUN, QUAD]))];
    steps.extend(bits.then(|| step(&MARK_BUSY_BY_HISTORY, view, Launch::Picture([WORKGROUP, 1]))));
    steps
}

/// Returns the steps that make a source view within these bounds. `bits` says whether visibility bits are recalled.
/// Otherwise all shadow rays are traced.
pub(crate) fn source(view: usize, soft: Option<usize>, search: Search, bits: bool) -> Vec<Step> {
    let made = if bits {
        bracket::resolve_by(&BY_HISTORY, view, soft, search)
    } else {
        let shade = soft::behind_hits(view, Launch::Pixels, soft.unwrap_or(0));
        [bracket::unshaded(view, search), shade].concat()
    };
    [vec![Step::CopyBounds(view)], made].concat()
}
