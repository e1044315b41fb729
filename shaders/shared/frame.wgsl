// The uniform buffer of a view. There is only one uniform buffer: with several, the software driver of Mesa 22.3 reads
// beyond its tables of loop ends.

// The band of the picture that the buffers hold, and the current rows: the rows that a dispatch processes.
struct Band {
    size: vec2u,         // picture width; number of buffer rows that belong to the picture
    row_begin: u32,      // current rows: [row_begin, row_end), in buffer rows
    row_end: u32,
    first_row: u32,      // picture row of the buffers' first row
    runs: u32,           // number of runs that rows of workgroups are distributed to (launched_row)
    buffer_depth: u32,   // slots per pixel of the target in the 3D buffer
    jitter_seed: u32,    // seed of the offsets of rows of samples, the same in all views
}

//! if canvas is picture and camera is around
// The target eye of a viewing circle; its source is on the other side. Each column's rays start at a point of the
// circle, and are tangents of it. Directions have length 1 along the ground, so a ray's t is the horizontal distance s
// of its hit (DESIGN, section 2).
struct Eyes {
    centre: vec3f,           // of the circle, scene coordinates
    target_radius: f32,      // radius of the circle, world units; negative for left eyes
    right_axis: vec3f,       // unit vector to the right, for azimuth 0
    most_elevation: f32,     // largest elevation of a ray, radians
    up_axis: vec3f,          // unit vector along the circle's axis
    column_step: f32,        // azimuth per column, radians
    forward: vec3f,          // unit vector ahead, at azimuth 0
    row_step: f32,           // elevation per row, radians
    middle: vec2f,           // column of azimuth 0, and row of elevation 0
    merge: vec2f,            // elevations between which the radius shrinks to 0, radians
    wider: f32,              // guard band around a tile's directions in its search, pixels, far more than rounding
    turn: u32,               // number of columns of a full turn; the picture's width if it shows only a part of it
    wraps: u32,              // 1 if the picture shows a full turn, so that its last column's neighbour is its first
    spare: u32,
    _pad: array<vec4f, 3>,
}

//! if canvas is picture and camera is lens
// An eye with a lens. Directions have length 1 along the view axis, so a ray's t is the depth Z of its hit (DESIGN,
// section 2). Without distortion, the lens shows what an eye with these directions shows.
struct Eyes {
    target_eye: vec3f,      // scene coordinates
    focal_x: f32,           // focal length along x, pixels
    target_corner: vec3f,   // direction to the picture's top left corner, without distortion
    focal_y: f32,           // focal length along y, pixels
    step_x: vec3f,          // direction from a pixel to its right neighbour, without distortion
    principal_x: f32,       // column of the principal point
    step_y: vec3f,          // direction from a pixel to the one below, without distortion
    principal_y: f32,       // row of the principal point
    radial: vec4f,          // coefficients of the radial part's powers, without the constant: lens.wgsl
    divisor: vec4f,         // the same of its divisor
    tangential: vec2f,      // p1 and p2
    spare: vec2f,
    _pad: array<vec4f, 2>,
}

//! if canvas is picture and camera is planar
// The source eye and the target eye. The target view is computed from the existing source view. If a view is traced
// instead, both eyes are that view's eye. Directions have length 1 along the view axis, so a ray's t is the depth Z of
// its hit (DESIGN, section 2).
struct Eyes {
    source_eye: vec3f,       // scene coordinates
    // Scale of the parallax, pixels: e_px = e w / W, or f_px for parallel cameras. It is negative if the target is left
    // of its source.
    parallax_px: f32,
    target_eye: vec3f,
    parallax_distance: f32,  // d, world units; e for parallel cameras
    source_corner: vec3f,    // direction from the source to the picture's top left corner
    shift: f32,              // signed distance from the source to the target along right_axis, world units
    target_corner: vec3f,
    same_parallax: f32,      // largest parallax difference between a sample and a point on one surface, pixels
    step_x: vec3f,           // direction from a pixel to its right neighbour
    longest: f32,            // upper bound of the length of all pixel directions
    step_y: vec3f,           // direction from a pixel to the one below
    wider: f32,              // guard band around projected bounds in a tile's search, pixels, far more than rounding
    right_axis: vec3f,       // r, direction to the image's right
    at_infinity: f32,        // factor of the parallax at infinity: 1, or 0 for parallel cameras
    forward: vec3f,          // f, unit view direction
    pixel_side: f32,         // side of a square with a pixel's area, in pixel widths
    second_parallax_px: f32,     // parallax_px and same_parallax relative to the second source, if any
    second_same_parallax: f32,
}

//! if canvas is picture
// Parameters of sampled light.
struct Lighting {
    light: u32,              // index of the current light (trace_soft)
    slot: u32,               // the light's slot among the sources that are not point lights
    first_ray: u32,          // the light's first ray in this dispatch
    sources: u32,            // number of lights that are not point lights, plus 1 if ambient light is sampled
    seed: u32,               // seed of random numbers
    occlusion_radius: f32,   // reach of ambient occlusion, world units
    share_tolerance: f32,    // largest difference between reused shares, in standard deviations
    bounces: u32,            // maximum number of reflections and refractions along a ray
}

// Parameters of the conversion to displayed colour.
struct Display {
    exposure: f32,     // factor of linear colour
    filmic: u32,       // 1: tone-mapped; 0: clamped
    words_read: u32,   // words per pixel that the host reads back: pack.wgsl
    filter_kind: u32,  // filter of several samples per pixel: 0 box, 1 tent, 2 Gauss
}

// Parameters of the cost model of the kernel `choose`.
struct Costs {
    least_spared: f32,   // minimum number of saved shadow rays per pixel
    listed: f32,         // L, cost of a shadow ray that is traced from a list
    disagreed: f32,      // D, cost where samples disagree, per shadow ray
    asked: f32,          // minimum number of shadow rays per pixel of the source, traced or recalled
}

// Parameters of paths of light.
struct PathRay {
    ray: u32,       // number of the rays that trace_paths traces, counted from 1, or the round of trace_bounced
    bounces: u32,   // maximum number of surfaces that scatter a path's light, after the first hit
    first: u32,     // number of the first path of each pixel
    tolerance: f32, // largest difference between samples whose light is shared, in standard deviations
}

struct Frame {
    eyes: Eyes,
    band: Band,
    lighting: Lighting,
    display: Display,
    costs: Costs,
    paths: PathRay,
}

//! if canvas is middles or texels
// The light replaces the eyes. The directions of the texels of its shadow-buffer replace the directions of pixels.
// src/shadow_buffer/mapping.rs fills this struct.
struct Mapping {
    light: vec3f,        // scene coordinates
    theta_begin: f32,    // theta of the first row, radians
    axis_x: vec3f,       // unit vector to phi = 0 on the equator
    theta_step: f32,     // theta per row, radians
    axis_y: vec3f,       // unit vector to phi = pi / 2 on the equator
    phi_begin: f32,      // phi of the first column, radians
    axis_z: vec3f,       // unit vector to the pole at theta = 0
    phi_step: f32,       // phi per column, radians
    columns: u32,        // number of columns of the table
    margin: f32,         // tolerated distance in front of a texel's surface, in widths of the texel there
}

struct Frame {
    mapping: Mapping,
    band: Band,
}

//! end
var<uniform> frame: Frame;
