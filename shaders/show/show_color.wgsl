// Writes a view's picture to a texture on the device, and counts threads that did not finish.
//
// launch  one thread per pixel of the current rows
// reads   view        [rows * width]
// reads   counters    [rows * COUNTERS]  CUT_SHORT
// writes  picture     [height, width]    sRGB-encoded, alpha 1
// adds    unfinished  [1]                number of threads that an adapter ended early

//! use counters, frame, pixels

var<storage, read> view: array<Pixel>;
var<storage, read> counters: array<u32>;
var<storage, read_write> unfinished: array<atomic<u32>>;
var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn show_color(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    count_unfinished(pixel);
    let color = unpack4x8unorm(view[pixel_index(pixel)].color);
    textureStore(picture, pixel + vec2u(0u, frame.band.first_row), color);
}
