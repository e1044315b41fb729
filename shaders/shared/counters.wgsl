// Counters of a thread's work and of a view's rows. src/kernel/layout.rs defines the same numbers, and a test compares
// them.

//! use frame, pixels

// Number of counters per picture row. Separate counters for each row reduce contention and keep the sums within 32
// bits.
const COUNTERS: u32 = 13u;
const SHADOW_RAYS: u32 = 0u;
const NODES_VISITED: u32 = 1u;
const PRIMITIVES_TESTED: u32 = 2u;
const BAD_PIXELS: u32 = 3u;
const MISSED_PIXELS: u32 = 4u;
const LOST_CANDIDATES: u32 = 5u;
const NEAREST_DEPTH: u32 = 6u;
const FARTHEST_DEPTH: u32 = 7u;
const CUT_SHORT: u32 = 8u;
const GAP_PIXELS: u32 = 9u;
const CHOSEN: u32 = 10u;
const SENT_RAYS: u32 = 11u;
const OWN_SHADOW_RAYS: u32 = 12u;   // shadow rays from mirrored surfaces, included in SHADOW_RAYS

override COUNT: bool = false;
// Whether a loop ended before its work was complete. llvmpipe silently ends a thread's loops after a total of 65,535
// rounds.
var<private> cut_short: bool;

//! if primitives is triangles or spheres or mixed
var<private> nodes_visited: u32;
var<private> primitives_tested: u32;

//! if primitives is none and planes is none
const nodes_visited: u32 = 0u;
const primitives_tested: u32 = 0u;

//! if planes is some and primitives is none
const nodes_visited: u32 = 0u;
var<private> primitives_tested: u32;

//! end
// Adds this thread's work to the counters of its row.
fn count_view(row: u32, shadow: u32, nodes: u32, primitives: u32) {
    let words = row * COUNTERS;
    if cut_short { atomicAdd(&counters[words + CUT_SHORT], 1u); }
    if shadow > 0u { atomicAdd(&counters[words + SHADOW_RAYS], shadow); }
    if COUNT {
        atomicAdd(&counters[words + NODES_VISITED], nodes);
        atomicAdd(&counters[words + PRIMITIVES_TESTED], primitives);
    }
}

override COST_MAP: bool = false;

// Adds this thread's work to its pixel of the cost map, which follows the counters. Pipelines with a cost map have one
// ray per lane.
fn count_pixel(pixel: vec2u) {
    if COST_MAP {
        atomicAdd(&counters[frame.band.size.y * COUNTERS + pixel_index(pixel)], nodes_visited + primitives_tested);
    }
}

// Adds the threads of a pixel's row that did not finish to the frame's, once for each row. Kernels that call this only
// read the counters, and bind `unfinished`.
fn count_unfinished(pixel: vec2u) {
    if pixel.x != 0u { return; }
    let ended = counters[pixel.y * COUNTERS + CUT_SHORT];
    if ended > 0u { atomicAdd(&unfinished[0], ended); }
}
