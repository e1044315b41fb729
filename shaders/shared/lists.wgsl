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
    entries: array<u32>,        // a quarter for each list
}

fn place_in(list: u32, place: u32) -> u32 {
    return list * (arrayLength(&lists.entries) / 4u) + place;
}
