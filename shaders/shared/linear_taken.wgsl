// Linear colour is taken over too.
@group(1) @binding(12) var<storage, read> source_linear: array<vec4f>;
@group(1) @binding(13) var<storage, read_write> linear_color: array<vec4f>;

fn take_linear(pixel: u32, place: u32) { linear_color[pixel] = source_linear[place]; }
