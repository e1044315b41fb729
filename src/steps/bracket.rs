//! Passes 2 and 3 of `bracket`: the tiles' bounds, their search, and the pixels that it leaves (docs/BRACKET.md).

use super::{
    resolve::{SHADE_TRACED, TRACE_LISTED},
    soft, step, trace,
};
use crate::{
    ShadowReuse,
    frame::{
        plan::{Launch, Step},
        targets::Target::{Bounds, Counters, Found, Source, SourceCounters, View},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    layout::{BUSY_RUN, SKY, TILE, TO_LIGHT, TO_RESOLVE, TO_SEARCH, TO_TRACE},
    wgsl::part,
};

pub(crate) const BOUND_TILES: Kernel = Kernel {
    name: "bound_tiles",
    touches: Touches::Pixels,
    storage: &[(Source, Read), (Bounds, Write), (Counters, Write)],
    main: part!("bound_tiles.wgsl"),
};
/// Marks busy lights, if visibility bits are reused.
pub(crate) const MARK_BUSY: Kernel =
    Kernel { name: "mark_busy", touches: Touches::Pixels, storage: &[(Bounds, Write)], main: part!("mark_busy.wgsl") };
pub(crate) const SEARCH_TILES: Kernel = Kernel {
    name: "search_tiles",
    touches: Touches::Geometry,
    storage: &[(Bounds, Read), (Counters, Write), (Found, Write)],
    main: part!("search_tiles.wgsl"),
};
/// Searches four tiles at once, for several samples a pixel.
pub(crate) const SEARCH_WIDE_TILES: Kernel =
    Kernel { name: "search_wide_tiles", main: part!("search_wide_tiles.wgsl"), ..SEARCH_TILES };
pub(crate) const RESOLVE_TILES: Kernel = Kernel {
    name: "resolve_tiles",
    touches: Touches::Geometry,
    storage: &[(View, Write), (Counters, Write), (Found, Write)],
    main: part!("resolve_tiles.wgsl"),
};
pub(crate) const SHADE_SKY: Kernel = Kernel {
    name: "shade_sky",
    touches: Touches::Shading,
    storage: &[(Found, Write), (View, Write), (Counters, Write)],
    main: part!("shade_sky.wgsl"),
};
pub(crate) const TRACE_BOUNDED: Kernel =
    Kernel { name: "trace_bounded", storage: &[(Found, Write), (View, Write), (Counters, Write)], ..TRACE_LISTED };
pub(crate) const SHADE_TILES: Kernel = Kernel {
    name: "shade_tiles",
    touches: Touches::Shading,
    storage: &[(Found, Write), (View, Write), (Counters, Write)],
    main: part!("shade_tiles.wgsl"),
};
pub(crate) const SHADE_LISTED: Kernel =
    Kernel { name: "shade_listed", storage: &[(Found, Write), (View, Write), (Counters, Write)], ..SHADE_TRACED };

pub(crate) const CHOOSE: Kernel = Kernel {
    name: "choose",
    touches: Touches::Pixels,
    storage: &[(SourceCounters, Read), (Counters, Write), (Found, Write)],
    main: part!("choose.wgsl"),
};

/// Returns the steps that bound tiles and mark busy lights.
pub(crate) fn bound(view: usize, bits: ShadowReuse) -> Vec<Step> {
    let mut steps = vec![step(&BOUND_TILES, view, Launch::Runs(TILE))];
    if bits != ShadowReuse::Rays {
        steps.push(step(&MARK_BUSY, view, Launch::Runs(BUSY_RUN)));
    }
    steps
}

/// Returns the steps that find primary visibility, by tiles and rays, and shade the hits. Unknown bits take shadow
/// rays.
pub(crate) fn resolve(view: usize, soft: Option<usize>, wide: bool) -> Vec<Step> {
    let launch = if wide { Launch::WideTiles } else { Launch::Tiles };
    [vec![Step::EmptyLists(Found), step(search(wide), view, launch)], resolve_listed(view, soft)].concat()
}

fn search(wide: bool) -> &'static Kernel {
    if wide { &SEARCH_WIDE_TILES } else { &SEARCH_TILES }
}

fn resolve_listed(view: usize, soft: Option<usize>) -> Vec<Step> {
    let mut steps = vec![
        step(&RESOLVE_TILES, view, Launch::Listed(Found, TO_RESOLVE)),
        step(&SHADE_SKY, view, Launch::Listed(Found, SKY)),
        step(&TRACE_BOUNDED, view, Launch::Listed(Found, TO_TRACE)),
        step(&SHADE_TILES, view, Launch::Listed(Found, TO_RESOLVE)),
    ];
    steps.extend(soft::unknown(view, TO_LIGHT, soft));
    steps.push(step(&SHADE_LISTED, view, Launch::Listed(Found, TO_LIGHT)));
    steps
}

/// Returns the steps that either do the same or trace the whole view, whichever is predicted to cost less in each band.
/// Steps of the other choice launch nothing, or their lists are empty.
pub(crate) fn or_traced(view: usize, soft: Option<usize>, wide: bool) -> Vec<Step> {
    let choose = vec![Step::EmptyLists(Found), step(&CHOOSE, view, Launch::Once)];
    let search = vec![step(search(wide), view, Launch::Listed(Found, TO_SEARCH))];
    [bound(view, ShadowReuse::Two), choose, search, resolve_listed(view, soft), trace::chosen(view, soft)].concat()
}
