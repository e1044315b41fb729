// What search_tiles finds: behind the lists, for each tile of the rows at work its bound and the lists of its blocks.

// Words of a block's list: the number of primitives, then their slots, each with a bit for each of the four pixels that may show it.
const LIST_WORDS: u32 = 40u;
const LIST_MOST: u32 = 39u;     // a block of which more is listed has no list: its pixels are traced
const FIRST_PIXEL_BIT: u32 = 28u;
// Words of a tile: the bits of its bound, then its blocks' lists.
const TILE_WORDS: u32 = 641u;

// Where a pixel's tile begins, in the entries of `lists`.
fn found_in_tile(pixel: vec2u) -> u32 {
    let row = (pixel.y - frame.row_begin) / TILE;
    return lists_end() + (row * tiles_across() + pixel.x / TILE) * TILE_WORDS;
}

// Where the list of one of its blocks does.
fn block_list(tile: u32, block: u32) -> u32 {
    return tile + 1u + block * LIST_WORDS;
}

fn block_of(pixel: vec2u) -> u32 {
    return pixel.y % TILE / 2u * BLOCKS + pixel.x % TILE / 2u;
}
