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

// A tile is in one list at most, and of the pixels' two lists the first has been traced before the other gets its first
// entry: so the two lists of either share as many entries as there are, one from the first on, the other from the last
// one backwards.
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

// Places in a list of pixels for a lane's, side by side, so that neighbours are traced together. The order of the list
// depends on the threads; each entry writes only its own pixel, so the picture does not.
fn reserve(list: u32, count: u32) -> u32 {
    return reserve_for(list, count, LIST_WORKGROUP * RAYS);
}

// The same where a workgroup takes so many entries.
fn reserve_for(list: u32, count: u32, workgroup: u32) -> u32 {
    if count == 0u { return 0u; }
    let place = atomicAdd(&lists.heads[list].count, count);
    let begun = (place + count + workgroup - 1u) / workgroup - (place + workgroup - 1u) / workgroup;
    if begun > 0u { atomicAdd(&lists.heads[list].workgroups_x, begun); }
    return place;
}

fn append(list: u32, place: u32, entry: u32) {
    lists.entries[place_in(list, place)] = entry;
}

// The pixels of a thread of a launch over a list. The last thread's spare rays repeat the last entry and are not
// wanted.
struct ListedPixels {
    pixels: Pixels,
    wanted: B,
}

fn listed_pixels(list: u32, thread: u32) -> ListedPixels {
    let first = thread * RAYS;
    let count = atomicLoad(&lists.heads[list].count);
    var index: U;
    var wanted: U;
    var ray = 0u;
    loop {
        let place = min(first + ray, max(count, 1u) - 1u);
        index = with_ray_u(index, ray, lists.entries[place_in(list, place)]);
        wanted = with_ray_u(wanted, ray, select(0u, 1u, first + ray < count));
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let width = frame.image_size.x;
    return ListedPixels(Pixels(index % width, index / width), wanted == U(1u));
}

// The pixels of a thread of a launch over a list of tiles: its block of one of them.
fn listed_tile_pixels(list: u32, thread: u32) -> ListedPixels {
    let threads = TILE_PIXELS / RAYS;
    let count = atomicLoad(&lists.heads[list].count);
    let place = thread / threads;
    let tile = lists.entries[place_in(list, min(place, max(count, 1u) - 1u))];
    let corner = vec2u(tile % tiles_across(), tile / tiles_across()) * TILE + vec2u(0u, frame.row_begin);
    let block = thread % threads;
    let across = TILE / BLOCK.x;
    let first = corner + vec2u(block % across, block / across) * BLOCK;
    let pixels = Pixels(RAY_X + U(first.x), RAY_Y + U(first.y));
    return ListedPixels(pixels, inside_rows(pixels) & (U(place) < U(count)));
}

// Behind the lists stands what search_tiles finds: for each tile of the rows at work its bound and the lists of its
// blocks.

// Words of a block's list: the number of primitives, then their slots, each with a bit for each of the four pixels that
// may show it.
const LIST_WORDS: u32 = 40u;
const LIST_MOST: u32 = 39u;     // a block of which more is listed has no list: its pixels are traced
const FIRST_PIXEL_BIT: u32 = 28u;
// Words of a tile: the bits of its bound, its blocks' lists, and the lights that are busy in it.
const TILE_WORDS: u32 = 642u;
const BUSY_WORD: u32 = 641u;

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
