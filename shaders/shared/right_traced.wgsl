// `Naive` and `bracket`: every right pixel was traced.
fn right_picture(pixel: vec2u, left: u32) -> u32 {
    return pack(right_color[pixel_index(pixel)]);
}
