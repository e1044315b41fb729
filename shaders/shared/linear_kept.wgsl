// Linear colour is kept too, RGB and 1.
@group(1) @binding(13) var<storage, read_write> linear_color: array<vec4f>;

fn keep_linear(pixel: u32, color: vec3f) { linear_color[pixel] = vec4f(color, 1.0); }
