// Tiles of right pixels, row by row, and their blocks of 2x2.
const TILE: u32 = 8u;
const TILE_PIXELS: u32 = 64u;
const BLOCKS: u32 = 4u;         // across a tile
const TILE_BLOCKS: u32 = 16u;
// Words of a block's list: a header and primitives' slots, with a bit for each of the four pixels that may show them.
const LIST_WORDS: u32 = 64u;
const LIST_HEADER: u32 = 2u;    // number of primitives, the bound's bits
const LIST_MOST: u32 = 62u;
const FIRST_PIXEL_BIT: u32 = 28u;

fn tiles_across() -> u32 {
    return (frame.image_size.x + TILE - 1u) / TILE;
}

// Where the lists of a pixel's tile begin.
fn tile_lists(pixel: vec2u) -> u32 {
    let row = (pixel.y - frame.row_begin) / TILE;
    return (row * tiles_across() + pixel.x / TILE) * (TILE_BLOCKS * LIST_WORDS);
}

fn block_of(pixel: vec2u) -> u32 {
    return pixel.y % TILE / 2u * BLOCKS + pixel.x % TILE / 2u;
}
