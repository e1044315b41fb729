//! Passes 2 and 3 of `bracket`: they bound and search tiles, and trace the pixels that the search leaves unresolved
//! (docs/BRACKET.md).

use super::{
    resolve::{SHADE_TRACED, TRACE_LISTED},
    soft, step, trace,
};
use crate::{
    ShadowReuse,
    frame::plan::{Launch, Search, Step},
    kernel::layout::{BUSY_RUN, SKY, TILE, TO_LIGHT, TO_RESOLVE, TO_SEARCH, TO_TRACE},
    kernel::{Hits, Kernel, Resource::Lists, Role, Shading, kernel},
};

pub(crate) const BOUND_TILES: Kernel = kernel!("bracket", "bound_tiles", Role::Pixels);
/// Marks busy lights, if visibility bits are reused.
pub(crate) const MARK_BUSY: Kernel = kernel!("bracket", "mark_busy", Role::MarkBusy);
pub(crate) const SEARCH_TILES: Kernel = kernel!("bracket", "search_tiles", Role::Hits(Hits::Tiles));
/// Searches four tiles at once, for several samples per pixel.
pub(crate) const SEARCH_WIDE_TILES: Kernel = kernel!("bracket", "search_wide_tiles", Role::Hits(Hits::Tiles));
/// Searches each tile by a workgroup, on GPUs.
pub(crate) const SEARCH_TILES_TOGETHER: Kernel = kernel!("bracket", "search_tiles_together", Role::Hits(Hits::Tiles));
pub(crate) const RESOLVE_TILES: Kernel = kernel!("bracket", "resolve_tiles", Role::Hits(Hits::Tiles));
pub(crate) const SHADE_SKY: Kernel = kernel!("bracket", "shade_sky", Role::Shade(Shading::Sky));
pub(crate) const TRACE_BOUNDED: Kernel = Kernel { name: "trace_bounded", ..TRACE_LISTED };
pub(crate) const SHADE_TILES: Kernel = kernel!("bracket", "shade_tiles", Role::Shade(Shading::Reused));
pub(crate) const SHADE_LISTED: Kernel =
    Kernel { name: "shade_listed", role: Role::Shade(Shading::Unknown), ..SHADE_TRACED };

pub(crate) const CHOOSE: Kernel = kernel!("bracket", "choose", Role::Pixels);

/// Returns the steps that bound tiles and mark busy lights.
pub(crate) fn bound(view: usize, bits: ShadowReuse) -> Vec<Step> {
    let mut steps = vec![step(&BOUND_TILES, view, Launch::Runs(TILE))];
    if bits != ShadowReuse::Rays {
        steps.push(step(&MARK_BUSY, view, Launch::Runs(BUSY_RUN)));
    }
    steps
}

/// The kernels that shade a view's hits and reuse visibility bits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shaders {
    pub(crate) sky: &'static Kernel,
    pub(crate) tiles: &'static Kernel,
    pub(crate) soft: &'static Kernel,
    pub(crate) listed: &'static Kernel,
}

/// They reuse the bits of a source view.
const BY_SOURCE: Shaders =
    Shaders { sky: &SHADE_SKY, tiles: &SHADE_TILES, soft: &soft::TRACE_SOFT_ASKED, listed: &SHADE_LISTED };

/// Returns the steps that find primary visibility, by tiles and rays, and shade the hits. Shadow rays determine unknown
/// visibility bits.
pub(crate) fn resolve(view: usize, soft: Option<usize>, search: Search) -> Vec<Step> {
    resolve_by(&BY_SOURCE, view, soft, search)
}

/// Returns the steps of [`resolve`] with these kernels.
pub(crate) fn resolve_by(by: &Shaders, view: usize, soft: Option<usize>, search: Search) -> Vec<Step> {
    [hits(by, view, search), shade(by, view, soft)].concat()
}

fn kernel_of(search: Search) -> &'static Kernel {
    match search {
        Search::Alone => &SEARCH_TILES,
        Search::Wide => &SEARCH_WIDE_TILES,
        Search::Together => &SEARCH_TILES_TOGETHER,
    }
}

/// Returns the steps that find primary visibility within the bounds of tiles, by their search and by rays.
fn hits(by: &Shaders, view: usize, search: Search) -> Vec<Step> {
    let steps = vec![Step::EmptyLists, step(kernel_of(search), view, search.launch())];
    [steps, hits_of_listed(by, view)].concat()
}

/// Returns the steps that find a view's hits within the bounds of tiles, for a step that shades whole views.
pub(crate) fn unshaded(view: usize, search: Search) -> Vec<Step> {
    hits(&BY_SOURCE, view, search)
}

fn hits_of_listed(by: &Shaders, view: usize) -> Vec<Step> {
    vec![
        step(&RESOLVE_TILES, view, Launch::Listed(Lists, TO_RESOLVE)),
        step(by.sky, view, Launch::Listed(Lists, SKY)),
        step(&TRACE_BOUNDED, view, Launch::Listed(Lists, TO_TRACE)),
    ]
}

fn shade(by: &Shaders, view: usize, soft: Option<usize>) -> Vec<Step> {
    let mut steps = vec![step(by.tiles, view, Launch::Listed(Lists, TO_RESOLVE))];
    steps.extend(soft::unknown(by.soft, view, TO_LIGHT, soft));
    steps.push(step(by.listed, view, Launch::Listed(Lists, TO_LIGHT)));
    steps
}

/// Returns the steps of [`bound`] and [`resolve`], and the steps that trace the whole view. Each band runs the choice
/// that is predicted to cost less. Steps of the other choice launch nothing, or their lists are empty.
pub(crate) fn or_traced(view: usize, soft: Option<usize>, search: Search) -> Vec<Step> {
    let choose = vec![Step::EmptyLists, step(&CHOOSE, view, Launch::Once)];
    let search = vec![step(kernel_of(search), view, Launch::Listed(Lists, TO_SEARCH))];
    let resolve = [hits_of_listed(&BY_SOURCE, view), shade(&BY_SOURCE, view, soft)].concat();
    [bound(view, ShadowReuse::Two), choose, search, resolve, trace::chosen(view, soft)].concat()
}
