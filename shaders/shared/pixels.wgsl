// Pixels: sentinels, the stored record of a pixel, and the mapping of threads to pixels. src/kernel/layout.rs defines
// the same numbers, and a test compares them.

//! use frame, lane

// Depth of a ray that misses; WGSL has no infinity.
const FAR: f32 = 3.4e38;
// Primitive id and slot of a miss.
const MISS: u32 = 0xffffffffu;

// Threads of a workgroup in x and in y.
const WORKGROUP: u32 = 8u;
// Threads of a workgroup in a dispatch over a list.
const LIST_WORKGROUP: u32 = 64u;
// Maximum number of workgroups in a row of a dispatch over a list.
const MOST_ACROSS: u32 = 16384u;

fn rows_of_workgroups(count: u32) -> u32 { return (count + MOST_ACROSS - 1u) / MOST_ACROSS; }

// Returns the number of a thread in a dispatch over a list.
fn listed_thread(id: vec3u) -> u32 { return id.y * (MOST_ACROSS * LIST_WORKGROUP) + id.x; }

// The stored record of a view's pixel.
struct Pixel {
    depth: f32,     // along the view axis; FAR: miss
    slot: u32,      // slot of the primitive that was hit; MISS: none
    marks: u32,     // marks of target pixels (marks.wgsl)
    color: u32,     // 8-bit sRGB, red in the low byte, alpha 255
}

// Returns the position of a thread, permuted within its workgroup of 8x8. Software adapters run eight consecutive
// threads as one vector. These threads take a block of 4x2 pixels. Its rays are closer together than the rays of a line
// of eight pixels.
fn pixel_in_tile(id: vec2u) -> vec2u {
    let tile = id & vec2u(0xfffffff8u);
    let x = (id.x & 3u) | ((id.y & 1u) << 2u);
    let y = ((id.x >> 2u) & 1u) | (id.y & 6u);
    return tile + vec2u(x, y);
}

// Returns the row of a thread in a dispatch over rows. A software adapter gives each of its threads one contiguous part
// of the workgroups. If half the picture were sky, some cores would be idle. So rows of workgroups are distributed to
// the parts (z) in turn.
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
// first row; only ray directions use the picture's rows.
fn pixel_index(pixel: vec2u) -> u32 {
    return pixel.y * frame.band.size.x + pixel.x;
}

// Returns the pixels of a thread in a launch over blocks.
fn block_pixels(id: vec3u) -> Pixels {
    let first = pixel_in_tile(vec2u(id.x, launched_row(id))) * BLOCK + vec2u(0u, frame.band.row_begin);
    return Pixels(RAY_X + U(first.x), RAY_Y + U(first.y));
}

// Returns which pixels lie in the picture and in this dispatch's rows.
fn in_picture(pixels: Pixels) -> B {
    return (pixels.x < U(frame.band.size.x)) & (pixels.y < U(frame.band.row_end));
}
