// `Naive` and `bracket`: every right pixel was traced.
@group(1) @binding(3) var<storage, read> right_color: array<vec4f>;

fn right_picture(pixel: vec2u, left: u32) -> u32 {
    return pack(right_color[pixel_index(pixel)]);
}
