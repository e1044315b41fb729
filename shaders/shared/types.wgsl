// Types shared by all kernels: structs, sentinels, the mapping of threads to pixels, and counters. src/layout.rs has
// the structs and the counters' indices too, and a test compares them.

// Depth of a ray that misses; WGSL has no infinity.
const FAR: f32 = 3.4e38;
// Primitive id and slot of a miss.
const MISS: u32 = 0xffffffffu;

//! if canvas is picture
// Two eyes of the rig and the rows at work, within a band of the picture. The source view exists, the target view is
// made. Where a view is traced, both eyes are its own. Directions have length 1 along the view axis, so a ray's t is
// the depth Z of its hit (DESIGN, section 2).
struct Frame {
    source_eye: vec3f,       // scene coordinates
    // Pixels: e_px = e w / W; f_px for parallel cameras; negative if the target is left of its source.
    parallax_px: f32,
    target_eye: vec3f,
    parallax_distance: f32,  // d, world units; e for parallel cameras: reprojection.wgsl
    source_corner: vec3f,    // direction from the source to the picture's top left corner
    shift: f32,              // from the source to the target along right_axis, world units
    target_corner: vec3f,
    same_parallax: f32,      // largest difference in parallax of a sample and a point on one surface, pixels
    step_x: vec3f,           // direction from a pixel to its right neighbour
    buffer_depth: u32,       // slots per right pixel in the 3D buffer
    step_y: vec3f,           // direction from a pixel to the one below
    row_begin: u32,          // rows of this dispatch: [row_begin, row_end), in buffer rows
    right_axis: vec3f,       // r, the image's right
    row_end: u32,
    image_size: vec2u,       // width, rows of the buffers that belong to the picture
    longest: f32,            // upper bound of the length of all pixel directions
    runs: u32,               // runs that rows of workgroups are dealt to (launched_row)
    forward: vec3f,          // f, unit
    wider: f32,              // guard band around projected bounds in a tile's search, pixels, far more than rounding
    first_row: u32,          // row of the picture that is the buffers' first row
    least_spared: f32,       // cost model of `choose`: least number of saved shadow rays a pixel
    cost_of_listed: f32,     // L, cost of a shadow ray by list
    cost_of_disagreed: f32,  // D, cost where samples disagree, per shadow ray
    second_parallax_px: f32,     // parallax_px and same_parallax from the second source, if any
    second_same_parallax: f32,
    bounces: u32,                // maximum number of reflections and refractions along a ray
    words_read: u32,             // words per pixel that the host reads back: pack.wgsl
    soft_light: u32,             // trace_soft: index of the current light
    soft_slot: u32,          // its slot among the sources that are not points
    soft_first: u32,         // the first of its rays in this dispatch
    soft_sources: u32,           // number of lights that are not points, plus 1 if ambient light is sampled
    seed: u32,                   // of random numbers
    occlusion_radius: f32,       // reach of ambient occlusion, world units
    share_tolerance: f32,        // standard deviations by which reused shares may differ
    exposure: f32,               // factor of linear colour in pictures
    filmic: u32,                 // 1: tone-mapped; 0: clamped
    jitter_seed: u32,            // of the offsets of rows of samples, the same in all views
    zero_b: u32,
    zero: u32,
    at_infinity: f32,            // 1; 0 for parallel cameras: reprojection.wgsl
    pixel_side: f32,             // side of a square with a pixel's area, in pixel widths
}

//! if canvas is middles or texels
// Takes the place of the other Frame: a light, the directions of its shadow-buffer's texels (src/cpu/shadow_buffer.rs
// has the same), and the rows at work.
struct Frame {
    target_eye: vec3f,       // the light, scene coordinates
    theta_begin: f32,        // of the first row, radians
    axis_x: vec3f,           // unit: where phi is 0 on the equator
    theta_step: f32,         // per row
    axis_y: vec3f,           // unit: where phi is pi / 2
    phi_begin: f32,          // of the first column
    axis_z: vec3f,           // unit: the pole at theta = 0
    phi_step: f32,           // per column
    image_size: vec2u,       // columns of the buffers, at least the table's; rows at work
    columns: u32,            // of the table
    first_row: u32,          // row of the table where the rows at work begin
    margin: f32,             // tolerated distance before a texel's surface, in widths of the texel there
}

//! end

// Threads of a workgroup in x and in y.
const WORKGROUP: u32 = 8u;
// Threads of a workgroup in a dispatch over a list.
const LIST_WORKGROUP: u32 = 64u;

// The stored record of a view's pixel.
struct Pixel {
    depth: f32,     // along the view axis; FAR: miss
    slot: u32,      // slot of the primitive that was hit; MISS: none
    marks: u32,     // of views that are not traced: reprojection.wgsl
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
    return (id.y / WORKGROUP * frame.runs + id.z) * WORKGROUP + id.y % WORKGROUP;
}

// Returns the pixel of a thread in a dispatch over pixels: columns from the left, rows from the first one of this
// dispatch.
fn thread_pixel(id: vec3u) -> vec2u {
    return pixel_in_tile(vec2u(id.x, launched_row(id))) + vec2u(0u, frame.row_begin);
}

// Returns whether a thread is past the right edge or the last row of this dispatch.
fn outside(pixel: vec2u) -> bool {
    return pixel.x >= frame.image_size.x || pixel.y >= frame.row_end;
}

// Returns the index of a pixel in a row-major buffer of one view's band. In all kernels rows count from the band's
// first one; only ray directions use the picture's rows.
fn pixel_index(pixel: vec2u) -> u32 {
    return pixel.y * frame.image_size.x + pixel.x;
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
        atomicAdd(&counters[frame.image_size.y * COUNTERS + pixel_index(pixel)], nodes_visited + primitives_tested);
    }
}
