// The uniform of a view. It is one: with several, Mesa 22.3's software driver reads beyond its tables of loop ends.

// The rows at work, within a band of the picture.
struct Band {
    size: vec2u,         // width, rows of the buffers that belong to the picture
    row_begin: u32,      // rows of this dispatch: [row_begin, row_end), in buffer rows
    row_end: u32,
    first_row: u32,      // row of the picture that is the buffers' first row
    runs: u32,           // runs that rows of workgroups are dealt to (launched_row)
    buffer_depth: u32,   // slots per pixel of the target in the 3D buffer
    jitter_seed: u32,    // of the offsets of rows of samples, the same in all views
}

//! if canvas is picture
// Two eyes of the rig. The source view exists, the target view is made. Where a view is traced, both eyes are its own.
// Directions have length 1 along the view axis, so a ray's t is the depth Z of its hit (DESIGN, section 2).
struct Eyes {
    source_eye: vec3f,       // scene coordinates
    // Pixels: e_px = e w / W; f_px for parallel cameras; negative if the target is left of its source.
    parallax_px: f32,
    target_eye: vec3f,
    parallax_distance: f32,  // d, world units; e for parallel cameras
    source_corner: vec3f,    // direction from the source to the picture's top left corner
    shift: f32,              // from the source to the target along right_axis, world units
    target_corner: vec3f,
    same_parallax: f32,      // largest difference in parallax of a sample and a point on one surface, pixels
    step_x: vec3f,           // direction from a pixel to its right neighbour
    longest: f32,            // upper bound of the length of all pixel directions
    step_y: vec3f,           // direction from a pixel to the one below
    wider: f32,              // guard band around projected bounds in a tile's search, pixels, far more than rounding
    right_axis: vec3f,       // r, the image's right
    at_infinity: f32,        // 1; 0 for parallel cameras
    forward: vec3f,          // f, unit
    pixel_side: f32,         // side of a square with a pixel's area, in pixel widths
    second_parallax_px: f32,     // parallax_px and same_parallax from the second source, if any
    second_same_parallax: f32,
}

// Parameters of sampled light.
struct Lighting {
    light: u32,              // trace_soft: index of the current light
    slot: u32,               // its slot among the sources that are not points
    first_ray: u32,          // the first of its rays in this dispatch
    sources: u32,            // number of lights that are not points, plus 1 if ambient light is sampled
    seed: u32,               // of random numbers
    occlusion_radius: f32,   // reach of ambient occlusion, world units
    share_tolerance: f32,    // standard deviations by which reused shares may differ
    bounces: u32,            // maximum number of reflections and refractions along a ray
}

// Parameters of pictures.
struct Display {
    exposure: f32,     // factor of linear colour
    filmic: u32,       // 1: tone-mapped; 0: clamped
    words_read: u32,   // words per pixel that the host reads back: pack.wgsl
    _pad: u32,
}

// The cost model of `choose`.
struct Costs {
    least_spared: f32,   // least number of saved shadow rays a pixel
    listed: f32,         // L, cost of a shadow ray by list
    disagreed: f32,      // D, cost where samples disagree, per shadow ray
    _pad: u32,
}

struct Frame {
    eyes: Eyes,
    band: Band,
    lighting: Lighting,
    display: Display,
    costs: Costs,
}

//! if canvas is middles or texels
// A light takes the place of the eyes, and the directions of its shadow-buffer's texels that of the pixels.
// src/render/shadow_buffer/mapping.rs makes it.
struct Mapping {
    light: vec3f,        // scene coordinates
    theta_begin: f32,    // of the first row, radians
    axis_x: vec3f,       // unit: where phi is 0 on the equator
    theta_step: f32,     // per row
    axis_y: vec3f,       // unit: where phi is pi / 2
    phi_begin: f32,      // of the first column
    axis_z: vec3f,       // unit: the pole at theta = 0
    phi_step: f32,       // per column
    columns: u32,        // of the table
    margin: f32,         // tolerated distance before a texel's surface, in widths of the texel there
}

struct Frame {
    mapping: Mapping,
    band: Band,
}

//! end
var<uniform> frame: Frame;
