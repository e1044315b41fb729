// Lists of right pixels and of tiles; the first three words of each one's head are an indirect dispatch.

const TO_TRACE: u32 = 0u;     // pixels that need a primary ray
const TO_LIGHT: u32 = 1u;     // pixels that need shadow rays only
const TO_RESOLVE: u32 = 2u;   // tiles in which something was found, or something else is left to do
const SKY: u32 = 3u;          // tiles in which there is nothing
// Heads of launches that are made whole or not at all, as `choose` says.
const TO_SEARCH: u32 = 4u;    // the tiles of a band
const ALL_TRACED: u32 = 5u;   // its pixels

struct ListHead {
    workgroups_x: atomic<u32>,
    workgroups_y: u32,
    workgroups_z: u32,
    count: atomic<u32>,
}

struct Lists {
    heads: array<ListHead, 6>,
    entries: array<u32>,
}

// A pixel is in one list at most, and so is a tile: the two lists of either share as many entries as there are, one from the first
// on, the other from the last one backwards.
fn place_in(list: u32, place: u32) -> u32 {
    let pixels = tiles_at_work() * TILE_PIXELS;
    let begin = select(0u, pixels, list >= TO_RESOLVE);
    let end = select(pixels, lists_end(), list >= TO_RESOLVE);
    return select(begin + place, end - 1u - place, (list & 1u) == 1u);
}

// Entries of all four.
fn lists_end() -> u32 {
    return tiles_at_work() * (TILE_PIXELS + 1u);
}
