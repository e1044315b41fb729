// Linear colour, stored in addition to 8-bit colour if requested.

//! if linear is kept
// Linear RGB, with 1 as the fourth component.
var<storage, read_write> linear_color: array<vec4f>;
var<storage, read> source_linear: array<vec4f>;

fn keep_linear(pixel: u32, color: vec3f) { linear_color[pixel] = vec4f(color, 1.0); }

fn take_linear(pixel: u32, place: u32) { linear_color[pixel] = source_linear[place]; }

//! if linear is none
fn keep_linear(pixel: u32, color: vec3f) {}

fn take_linear(pixel: u32, place: u32) {}
