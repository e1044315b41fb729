// Writes a view's depth to a texture on the device.
//
// launch  one thread per pixel of the current rows
// reads   view     [rows * width]
// writes  picture  [height, width]  depth, FAR for a miss

//! use frame, pixels

var<storage, read> view: array<Pixel>;
var picture: texture_storage_2d<r32float, write>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn show_depth(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let depth = view[pixel_index(pixel)].depth;
    textureStore(picture, pixel + vec2u(0u, frame.band.first_row), vec4f(depth, 0.0, 0.0, 1.0));
}
