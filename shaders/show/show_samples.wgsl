// Writes the linear colour of a view's samples to a texture on the device, and counts threads that did not finish.
//
// launch  one thread per sample of the current rows
// reads   linear_color  [rows * width]
// reads   counters      [rows * COUNTERS]  CUT_SHORT
// writes  picture       [height, width]    exposed linear colour, at most the largest f16
// adds    unfinished    [1]                number of threads that an adapter ended early

//! use counters, frame, pixels

var<storage, read> linear_color: array<vec4f>;
var<storage, read> counters: array<u32>;
var<storage, read_write> unfinished: array<atomic<u32>>;
var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn show_samples(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    count_unfinished(pixel);
    let color = min(linear_color[pixel_index(pixel)] * frame.display.exposure, vec4f(65504.0));
    textureStore(picture, pixel + vec2u(0u, frame.band.first_row), color);
}
