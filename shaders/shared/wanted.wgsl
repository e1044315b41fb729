// The pixels that a kernel processes: all pixels of the current rows, or only the pixels of a mask, as for adaptive
// samples (src/render/adaptive.rs).

//! use frame, lane, pixels, tiles

//! if wanted is all
fn inside_rows(pixels: Pixels) -> B {
    return in_picture(pixels);
}

fn is_any_wanted(corner: vec2u) -> bool { return true; }

fn is_left_out(depth: f32) -> bool { return false; }

//! if wanted is masked
// One bit per pixel of the current view. A texel holds 128 pixels of a row, the first one in the lowest bit.
var wanted_pixels: texture_2d<u32>;

// Depth of a source pixel that was not wanted. The pixel has no sample, not even a sky sample.
const LEFT_OUT: f32 = 0.0;

// Returns the mask's word that contains the bit of `pixel`, with the bits of 32 pixels of a row.
fn wanted_word(pixel: vec2u) -> u32 {
    return textureLoad(wanted_pixels, vec2u(pixel.x >> 7u, pixel.y), 0)[(pixel.x >> 5u) & 3u];
}

fn inside_rows(pixels: Pixels) -> B {
    var wanted = in_picture(pixels);
    var ray = 0u;
    loop {
        let pixel = pixel_of_ray(pixels, ray);
        if of_ray_b(wanted, ray) && ((wanted_word(pixel) >> (pixel.x & 31u)) & 1u) == 0u {
            wanted = without_ray(wanted, ray);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return wanted;
}

// Returns whether any pixel of the tile with this corner is wanted. A row of a tile lies in one word.
fn is_any_wanted(corner: vec2u) -> bool {
    var any_bits = 0u;
    var row = 0u;
    loop {
        if row >= TILE || corner.y + row >= frame.band.row_end { break; }
        any_bits |= wanted_word(corner + vec2u(0u, row)) >> (corner.x & 31u);
        row += 1u;
    }
    return (any_bits & 0xffu) != 0u;
}

fn is_left_out(depth: f32) -> bool { return depth == LEFT_OUT; }
