// The reuse methods: traced where right_source is marked so, else the left pixel that it names.
@group(1) @binding(3) var<storage, read> right_color: array<vec4f>;
@group(1) @binding(4) var<storage, read> right_source: array<u32>;

fn right_picture(pixel: vec2u, left: u32) -> u32 {
    let index = pixel_index(pixel);
    let mark = right_source[index];
    let traced = (mark & (BAD | MISSED)) != 0u;
    let taken = pixel_index(vec2u((mark & COLUMN) - 1u, pixel.y));
    // What is not wanted is read at a place that is there.
    return pack(select(left_color[select(taken, index, traced)], right_color[index], traced));
}
