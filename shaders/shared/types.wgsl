// Types shared by all kernels: structs, sentinels, the mapping of threads to pixels, and counters. src/layout.rs has
// the structs and the counters' indices too, and a test compares them.

// Depth of a ray that misses; WGSL has no infinity.
const FAR: f32 = 3.4e38;
// Primitive id and slot of a miss.
const MISS: u32 = 0xffffffffu;

// Threads of a workgroup in x and in y.
const WORKGROUP: u32 = 8u;
// Threads of a workgroup in a dispatch over a list.
const LIST_WORKGROUP: u32 = 64u;

// The stored record of a view's pixel.
struct Pixel {
    depth: f32,     // along the view axis; FAR: miss
    slot: u32,      // slot of the primitive that was hit; MISS: none
    marks: u32,     // of views that are not traced: marks.wgsl
    color: u32,     // 8-bit sRGB, red in the low byte, alpha 255
}

// Returns the position of a thread in a workgroup of 8x8. Eight consecutive threads, which software adapters run as one
// vector, take a block of 4x2: their rays stay closer together than in a line of eight.
fn pixel_in_tile(id: vec2u) -> vec2u {
    let tile = id & vec2u(0xfffffff8u);
    let x = (id.x & 3u) | ((id.y & 1u) << 2u);
    let y = ((id.x >> 2u) & 1u) | (id.y & 6u);
    return tile + vec2u(x, y);
}

// Returns the row of a thread in a dispatch over rows. A software adapter gives each of its threads one contiguous part
// of the workgroups, and a core would be idle if half the picture is sky. So rows of workgroups are dealt like cards,
// one to each part (z) in turn.
fn launched_row(id: vec3u) -> u32 {
    return (id.y / WORKGROUP * frame.band.runs + id.z) * WORKGROUP + id.y % WORKGROUP;
}

// Returns the pixel of a thread in a dispatch over pixels: columns from the left, rows from the first one of this
// dispatch.
fn thread_pixel(id: vec3u) -> vec2u {
    return pixel_in_tile(vec2u(id.x, launched_row(id))) + vec2u(0u, frame.band.row_begin);
}

// Returns whether a thread is past the right edge or the last row of this dispatch.
fn outside(pixel: vec2u) -> bool {
    return pixel.x >= frame.band.size.x || pixel.y >= frame.band.row_end;
}

// Returns the index of a pixel in a row-major buffer of one view's band. In all kernels rows count from the band's
// first one; only ray directions use the picture's rows.
fn pixel_index(pixel: vec2u) -> u32 {
    return pixel.y * frame.band.size.x + pixel.x;
}

// Words of a view's `counters` per picture row. A set for each row keeps atomics apart and sums within 32 bits.
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

// Adds this thread's work to its pixel of the cost map, which is stored behind the counters. Such a pipeline has one
// ray a lane.
fn count_pixel(pixel: vec2u) {
    if COST_MAP {
        atomicAdd(&counters[frame.band.size.y * COUNTERS + pixel_index(pixel)], nodes_visited + primitives_tested);
    }
}
