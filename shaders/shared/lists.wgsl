// Lists of target pixels and of tiles. The first three words of each head are the arguments of an indirect dispatch.
// Beyond MOST_ACROSS workgroups, a dispatch has several rows of so many.

//! use frame, lane, pixels, tiles, wanted

const TO_TRACE: u32 = 0u;     // pixels that need a primary ray
const TO_LIGHT: u32 = 1u;     // pixels that need shadow rays only
const TO_RESOLVE: u32 = 2u;   // tiles with a primitive or other work
const SKY: u32 = 3u;          // tiles without any primitive
// Heads of dispatches that the kernel `choose` enables or disables as a whole.
const TO_SEARCH: u32 = 4u;    // the tiles of a band
const ALL_TRACED: u32 = 5u;   // the pixels of a band

struct ListHead {
    workgroups_x: atomic<u32>,
    workgroups_y: atomic<u32>,
    workgroups_z: u32,
    count: atomic<u32>,
}

struct Lists {
    heads: array<ListHead, 6>,
    entries: array<u32>,
}

// Returns the index of an entry. Two lists share one range of entries: one grows from the range's begin, the other
// backwards from its end. Two lists of tiles fit, since a tile is in at most one of them. Two lists of pixels fit,
// since TO_TRACE has been traced before TO_LIGHT gets an entry.
fn place_in(list: u32, place: u32) -> u32 {
    let pixels = tiles_at_work() * TILE_PIXELS;
    let begin = select(0u, pixels, list >= TO_RESOLVE);
    let end = select(pixels, lists_end(), list >= TO_RESOLVE);
    return select(begin + place, end - 1u - place, (list & 1u) == 1u);
}

// Number of entries of the four lists of pixels and tiles.
fn lists_end() -> u32 {
    return tiles_at_work() * (TILE_PIXELS + 1u);
}

// Reserves consecutive entries for the pixels of a lane, so that neighbours are traced together. The order of the list
// depends on the threads. The picture does not depend on the order, since each entry writes its own pixel only.
fn reserve(list: u32, count: u32) -> u32 {
    return reserve_for(list, count, LIST_WORKGROUP * RAYS);
}

// Reserves entries like `reserve`, for workgroups that take `workgroup` entries each.
fn reserve_for(list: u32, count: u32, workgroup: u32) -> u32 {
    if count == 0u { return 0u; }
    let place = atomicAdd(&lists.heads[list].count, count);
    let begun = (place + count + workgroup - 1u) / workgroup;
    if begun > (place + workgroup - 1u) / workgroup {
        atomicMax(&lists.heads[list].workgroups_x, min(begun, MOST_ACROSS));
        if begun > MOST_ACROSS { atomicMax(&lists.heads[list].workgroups_y, rows_of_workgroups(begun)); }
    }
    return place;
}

fn append(list: u32, place: u32, entry: u32) {
    lists.entries[place_in(list, place)] = entry;
}

// The pixels that a thread handles in a dispatch over a list. Spare rays of the last thread repeat the last entry and
// are not wanted.
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
    let width = frame.band.size.x;
    return ListedPixels(Pixels(index % width, index / width), wanted == U(1u));
}

// Returns the pixels of a thread in a launch over a list of tiles: one block of one tile.
fn listed_tile_pixels(list: u32, thread: u32) -> ListedPixels {
    let threads = TILE_PIXELS / RAYS;
    let count = atomicLoad(&lists.heads[list].count);
    let place = thread / threads;
    let tile = lists.entries[place_in(list, min(place, max(count, 1u) - 1u))];
    let corner = vec2u(tile % tiles_across(), tile / tiles_across()) * TILE + vec2u(0u, frame.band.row_begin);
    let block = thread % threads;
    let across = TILE / BLOCK.x;
    let first = corner + vec2u(block % across, block / across) * BLOCK;
    let pixels = Pixels(RAY_X + U(first.x), RAY_Y + U(first.y));
    return ListedPixels(pixels, inside_rows(pixels) & (U(place) < U(count)));
}

// The results of search_tiles follow the lists. Each tile of the current rows has its bound, the lists of its blocks
// and its busy lights.

// Number of words of a block's list. The first word is the number of primitives. Each other word is a slot, with a bit
// for each of the four pixels that may show the primitive.
const LIST_WORDS: u32 = 40u;
const LIST_MOST: u32 = 39u;     // maximum number of primitives; a block with more is traced instead
const FIRST_PIXEL_BIT: u32 = 28u;
// Number of words of a tile: the bits of its bound, the lists of its blocks, and its busy lights.
const TILE_WORDS: u32 = 642u;
const BUSY_WORD: u32 = 641u;

// Returns the index in `lists.entries` at which the results of a pixel's tile begin.
fn found_in_tile(pixel: vec2u) -> u32 {
    let row = (pixel.y - frame.band.row_begin) / TILE;
    return lists_end() + (row * tiles_across() + pixel.x / TILE) * TILE_WORDS;
}

// Returns the index at which the list of one of the tile's blocks begins.
fn block_list(tile: u32, block: u32) -> u32 {
    return tile + 1u + block * LIST_WORDS;
}

fn block_of(pixel: vec2u) -> u32 {
    return pixel.y % TILE / 2u * BLOCKS + pixel.x % TILE / 2u;
}
