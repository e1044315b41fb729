// Tiles of a view's pixels, row by row, and their blocks of 2x2.

//! use frame

const TILE: u32 = 8u;
const TILE_PIXELS: u32 = 64u;
const BLOCKS: u32 = 4u;         // number of blocks across a tile
const TILE_BLOCKS: u32 = 16u;

fn tiles_across() -> u32 {
    return (frame.band.size.x + TILE - 1u) / TILE;
}

// Number of pixels of a row that a thread of mark_busy tests. The thread reads four more samples.
const BUSY_RUN: u32 = 16u;

// Number of words per tile in the result of bound_tiles: the bits of the tile's bound, and its busy lights.
const BOUND_WORDS: u32 = 2u;

// Returns the index of the first of these words for a pixel's tile.
fn bound_place(pixel: vec2u) -> u32 {
    return BOUND_WORDS * (pixel.y / TILE * tiles_across() + pixel.x / TILE);
}

// Returns the number of tiles in the current rows.
fn tiles_at_work() -> u32 {
    return (frame.band.row_end - frame.band.row_begin + TILE - 1u) / TILE * tiles_across();
}

struct Tile {
    corner: vec2u,   // first pixel, in picture coordinates
    size: vec2u,
}

// Returns the blocks of 2x2 pixels that contain a range of a tile's pixels, one bit each, row by row.
fn covered_blocks(covered: vec4i) -> u32 {
    let first = vec2u(covered.xy) / 2u;
    let last = vec2u(covered.zw) / 2u;
    let columns = (2u << last.x) - (1u << first.x);
    let rows = (16u << (4u * last.y)) - (1u << (4u * first.y));
    return select(0u, (columns * 0x1111u) & rows, covered.y <= covered.w);
}

const ALL_BLOCKS: u32 = 0xffffu;
