// Tiles of right pixels, row by row, and their blocks of 2x2.
const TILE: u32 = 8u;
const TILE_PIXELS: u32 = 64u;
const BLOCKS: u32 = 4u;         // across a tile
const TILE_BLOCKS: u32 = 16u;

fn tiles_across() -> u32 {
    return (frame.image_size.x + TILE - 1u) / TILE;
}

// Tiles of the rows at work.
fn tiles_at_work() -> u32 {
    return (frame.row_end - frame.row_begin + TILE - 1u) / TILE * tiles_across();
}
