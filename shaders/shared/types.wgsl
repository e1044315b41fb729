// What every kernel shares: structs, sentinels, which pixel is a thread's, and counters. The structs and the counters'
// places stand in src/layout.rs too, and a test compares them.

// Depth of a ray that hits nothing; WGSL has no infinity.
const FAR: f32 = 3.4e38;
// Primitive id, and place among the primitives, where a ray hits nothing.
const MISS: u32 = 0xffffffffu;

//! if canvas is picture
// Two of the rig's eyes and the rows at work, a band of the picture's: the source, whose view is there, and the target,
// whose view is made; where a view is traced, both are its own. Directions have length 1 along the view axis, so that a
// ray's t is the depth Z of the point it reaches (DESIGN, section 2).
struct Frame {
    source_eye: vec3f,       // world position
    parallax_px: f32,        // pixels: e_px = e w / W, f_px where cameras are parallel; negative where the target stands to the left of its source
    target_eye: vec3f,
    parallax_distance: f32,  // d, e where cameras are parallel, world units: reprojection.wgsl
    source_corner: vec3f,    // direction from the source through the picture's top left corner
    shift: f32,              // from the source to the target along right_axis, world units
    target_corner: vec3f,
    same_parallax: f32,      // a sample and a point whose parallaxes differ by more are of no one surface, pixels
    step_x: vec3f,           // direction from a pixel to its right neighbour
    buffer_depth: u32,       // slots a right pixel in the 3D buffer
    step_y: vec3f,           // direction from a pixel to the one below
    row_begin: u32,          // rows of this dispatch: [row_begin, row_end), counted as buffers do
    right_axis: vec3f,       // r, the image's right
    row_end: u32,
    image_size: vec2u,       // width, rows of the buffers that are of the picture
    longest: f32,            // at least the length of every pixel's direction
    runs: u32,               // runs that rows of workgroups are dealt to (launched_row)
    forward: vec3f,          // f, unit
    wider: f32,              // pixels that a tile's search adds around projected bounds, far more than rounding
    first_row: u32,          // row of the picture that the buffers' first one is
    least_spared: f32,       // what `choose` weighs: how many shadow rays a pixel pay for a search, what one of a list costs, and what
    cost_of_listed: f32,     // those cost that samples don't agree in, of all
    cost_of_disagreed: f32,
    second_parallax_px: f32,     // parallax_px and same_parallax from the source on the target's other side, where there is one
    second_same_parallax: f32,
    bounces: u32,                // surfaces that a ray may come from, one behind the other
    words_read: u32,             // of each pixel, by the host: pack.wgsl
    soft_light: u32,             // the light at work of trace_soft, its place among those that are not points, and the first of its rays
    soft_slot: u32,
    soft_first: u32,
    soft_sources: u32,           // how many lights are not points, and 1 for ambient light where it is asked for
    seed: u32,                   // of random numbers
    occlusion_radius: f32,       // how far surroundings keep ambient light off, world units
    share_tolerance: f32,        // standard deviations by which shares that are taken over may differ
    exposure: f32,               // what linear colour is multiplied by where it is shown
    filmic: u32,                 // 1: and then bent, in place of being cut off
    jitter_seed: u32,            // of the offsets of rows of samples, the same in all views
    zero_b: u32,
    zero: u32,
    at_infinity: f32,            // 1, 0 where cameras are parallel: reprojection.wgsl
    pixel_side: f32,             // side of a square as large as a pixel, in widths of one
}

//! if canvas is middles or texels
// In place of it a light and where directions stand in its shadow-buffer (src/cpu/shadow_buffer.rs has the same), and
// the rows at work.
struct Frame {
    target_eye: vec3f,       // the light, world position
    theta_begin: f32,        // of the first row, radians
    axis_x: vec3f,           // unit: where phi is 0 on the equator
    theta_step: f32,         // a row
    axis_y: vec3f,           // where phi is pi / 2
    phi_begin: f32,          // of the first column
    axis_z: vec3f,           // the pole at theta = 0
    phi_step: f32,           // a column
    image_size: vec2u,       // columns of the buffers, which are no fewer than the table's, and rows at work
    columns: u32,            // of the table
    first_row: u32,          // of the table, where the rows at work begin
    margin: f32,             // how much may stand before a texel's surface and be no matter, in widths of a texel there
}

//! end

// Threads of a workgroup in x and in y.
const WORKGROUP: u32 = 8u;
// Threads of a workgroup of a launch over a list.
const LIST_WORKGROUP: u32 = 64u;

// What is kept of each pixel of a view.
struct Pixel {
    depth: f32,     // along the view axis; FAR: nothing hit
    slot: u32,      // place among the primitives of what was hit; MISS: nothing
    marks: u32,     // of the views that are not traced: reprojection.wgsl
    color: u32,     // 8-bit sRGB, red in the low byte, alpha 255
}

// Where a thread of a workgroup of 8x8 works. Eight threads in a row of it, which software adapters run as one vector,
// take a block of 4x2: their rays stay closer together than those of eight in a line.
fn pixel_in_tile(id: vec2u) -> vec2u {
    let tile = id & vec2u(0xfffffff8u);
    let x = (id.x & 3u) | ((id.y & 1u) << 2u);
    let y = ((id.x >> 2u) & 1u) | (id.y & 6u);
    return tile + vec2u(x, y);
}

// The row of a thread of a launch over rows. A software adapter gives each of its threads one contiguous part of the
// workgroups, and where half a picture is sky a core would be idle: so rows of workgroups are dealt like cards, one to
// each part (z) in turn.
fn launched_row(id: vec3u) -> u32 {
    return (id.y / WORKGROUP * frame.runs + id.z) * WORKGROUP + id.y % WORKGROUP;
}

// The pixel of a thread of a launch over pixels: columns from the left, rows from the first one of this dispatch.
fn thread_pixel(id: vec3u) -> vec2u {
    return pixel_in_tile(vec2u(id.x, launched_row(id))) + vec2u(0u, frame.row_begin);
}

// A thread past the right edge or past the last row of this dispatch has no pixel.
fn outside(pixel: vec2u) -> bool {
    return pixel.x >= frame.image_size.x || pixel.y >= frame.row_end;
}

// Index of a pixel in a row-major list of one view's band. Rows of pixels count from the band's first one, here and in
// all kernels; only where rays point to does the picture's count.
fn pixel_index(pixel: vec2u) -> u32 {
    return pixel.y * frame.image_size.x + pixel.x;
}

// Words of a view's `counters` a picture row; one row of them a picture row keeps atomics apart and sums within 32
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
const OWN_SHADOW_RAYS: u32 = 12u;   // of the shadow rays those at what mirrors and the like show

// Adds what this thread did to its row's counters of the view.
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

// Adds what this thread did to its pixel; such a pipeline has one ray a lane. The map stands behind the rows' counters.
fn count_pixel(pixel: vec2u) {
    if COST_MAP {
        atomicAdd(&counters[frame.image_size.y * COUNTERS + pixel_index(pixel)], nodes_visited + primitives_tested);
    }
}
