//! Passes 2 and 3 of `bracket`: how deep each tile is searched, its search, and what that leaves (docs/BRACKET.md).

use super::{APPEND, COUNT, LIGHT_TRACED, LISTED_PIXELS, LISTS, MARKS, PARALLAX, SWEEP, TILES, step};
use crate::{
    frame::{
        plan::{Launch, Step},
        targets::Target::{Bounds, Counters, Found, Source, View},
    },
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    layout::{SKY, TO_LIGHT, TO_RESOLVE, TO_TRACE},
    variant::{Part, part},
};

const LIGHT_TAKEN: Part = part!("shared/light_taken.wgsl");
const LIGHT_TAKEN_OR_TRACED: Part = part!("shared/light_taken_or_traced.wgsl");
const TAKEN_BITS: Part = part!("shared/taken_bits.wgsl");
const LISTED_TILE: Part = part!("shared/listed_tile.wgsl");
const TARGET_HITS: Part = part!("shared/target_hits.wgsl");
const TILE: Part = part!("shared/tile.wgsl");
pub(crate) const FOUND: Part = part!("shared/found.wgsl");

pub(crate) const BOUND_TILES: Kernel = Kernel {
    name: "bound_tiles",
    touches: Touches::Pixels,
    storage: &[(Source, Read), (Bounds, Write), (Counters, Write)],
    extra: &[PARALLAX, SWEEP, TILES],
    main: part!("bound_tiles.wgsl"),
};
pub(crate) const SEARCH_TILES: Kernel = Kernel {
    name: "search_tiles",
    touches: Touches::Geometry,
    storage: &[(Bounds, Read), (Counters, Write), (Found, Write)],
    extra: &[COUNT, TILES, TILE, LISTS, FOUND, APPEND],
    main: part!("search_tiles.wgsl"),
};
pub(crate) const RESOLVE_TILES: Kernel = Kernel {
    name: "resolve_tiles",
    touches: Touches::Shading,
    storage: &[(View, Write), (Counters, Write), (Found, Write)],
    extra: &[COUNT, TILES, MARKS, LISTS, FOUND, APPEND, LISTED_PIXELS, LISTED_TILE, PARALLAX, TAKEN_BITS, LIGHT_TAKEN],
    main: part!("resolve_tiles.wgsl"),
};
pub(crate) const SHADE_SKY: Kernel = Kernel {
    name: "shade_sky",
    touches: Touches::Shading,
    storage: &[(Found, Write), (View, Write), (Counters, Write)],
    extra: &[COUNT, TILES, LISTS, LISTED_PIXELS, LISTED_TILE, LIGHT_TRACED],
    main: part!("shade_sky.wgsl"),
};
pub(crate) const TRACE_BOUNDED: Kernel = Kernel {
    name: "trace_bounded",
    touches: Touches::Shading,
    storage: &[(Found, Write), (View, Write), (Counters, Write)],
    extra: &[COUNT, MARKS, TILES, LISTS, LISTED_PIXELS, PARALLAX, TARGET_HITS, TAKEN_BITS, LIGHT_TAKEN_OR_TRACED],
    main: part!("trace_bounded.wgsl"),
};
pub(crate) const SHADE_LISTED: Kernel = Kernel {
    name: "shade_listed",
    touches: Touches::Shading,
    storage: &[(Found, Write), (View, Write), (Counters, Write)],
    extra: &[COUNT, TILES, LISTS, LISTED_PIXELS, PARALLAX, TARGET_HITS, TAKEN_BITS, LIGHT_TAKEN_OR_TRACED],
    main: part!("shade_listed.wgsl"),
};

/// How deep each tile must be searched.
pub(crate) fn bound(view: usize) -> Vec<Step> {
    vec![step(&BOUND_TILES, view, Launch::Runs)]
}

/// Primary visibility by tiles, the rest by rays; then shading, shadow rays where bits don't agree.
pub(crate) fn resolve(view: usize) -> Vec<Step> {
    vec![
        Step::EmptyLists,
        step(&SEARCH_TILES, view, Launch::Tiles),
        step(&RESOLVE_TILES, view, Launch::Listed(TO_RESOLVE)),
        step(&SHADE_SKY, view, Launch::Listed(SKY)),
        step(&TRACE_BOUNDED, view, Launch::Listed(TO_TRACE)),
        step(&SHADE_LISTED, view, Launch::Listed(TO_LIGHT)),
    ]
}
