// Which pixels a kernel works on: all of the rows at work, or those of them that a mask says, as adaptive samples do
// (src/samples/adaptive.rs).

//! if wanted is all
fn inside_rows(pixels: Pixels) -> B {
    return in_picture(pixels);
}

fn is_any_wanted(corner: vec2u) -> bool { return true; }

fn leave_out(pixels: Pixels, wanted: B) {}

fn is_left_out(depth: f32) -> bool { return false; }

//! if wanted is masked
// A bit a pixel of the view at work: 128 pixels of a row in each texel, the first one in the lowest bit.
@group(1) @binding(9) var wanted_pixels: texture_2d<u32>;

// Depth of a source's pixel that is not wanted: nothing was seen there, not even sky.
const LEFT_OUT: f32 = 0.0;

// The bits of 32 pixels of a row, that of `pixel` in its place.
fn wanted_word(pixel: vec2u) -> u32 {
    return textureLoad(wanted_pixels, vec2u(pixel.x >> 7u, pixel.y), 0)[(pixel.x >> 5u) & 3u];
}

fn inside_rows(pixels: Pixels) -> B {
    var wanted = in_picture(pixels);
    var ray = 0u;
    loop {
        let pixel = pixel_of_ray(pixels, ray);
        if of_ray_b(wanted, ray) && ((wanted_word(pixel) >> (pixel.x & 31u)) & 1u) == 0u { wanted = without_ray(wanted, ray); }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return wanted;
}

// Whether one of the pixels of the tile with this corner is. (A row of a tile stands in one word.)
fn is_any_wanted(corner: vec2u) -> bool {
    var any_bits = 0u;
    var row = 0u;
    loop {
        if row >= TILE || corner.y + row >= frame.row_end { break; }
        any_bits |= wanted_word(corner + vec2u(0u, row)) >> (corner.x & 31u);
        row += 1u;
    }
    return (any_bits & 0xffu) != 0u;
}

// What other views must not take for something seen: pixels of a source that nobody asked for.
fn leave_out(pixels: Pixels, wanted: B) {
    let inside = in_picture(pixels);
    var ray = 0u;
    loop {
        if of_ray_b(inside, ray) && !of_ray_b(wanted, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            view[pixel_index(pixel)].depth = LEFT_OUT;
            keep_no_sample(pixel);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}

fn is_left_out(depth: f32) -> bool { return depth == LEFT_OUT; }

//! end
