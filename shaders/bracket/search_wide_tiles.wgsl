// Searches the BVH like search_tiles.wgsl, for several samples per pixel. One query serves 16x16 samples, which are
// four tiles. Neighbouring samples usually see the same primitives. Each primitive is projected once and then narrowed
// to the blocks of each tile that it may cover.
//
// launch  one thread per four tiles
// reads   bounds    [tiles, BOUND_WORDS]  bits of a depth, and of the busy lights
// adds    counters  [height * COUNTERS]
// writes  lists     [tiles of the current rows, TILE_WORDS] after the lists
// appends lists     TO_RESOLVE, SKY: tiles of the current rows

//! use around, boxes, counters, frame, lists, pixels, planes, primitive, projection, search, tiles

var<storage, read> bounds: array<u32>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> lists: Lists;

const QUADRANTS: u32 = 4u;

// Maximum number of steps of four tiles together; if they need more, their pixels are traced. A listed block counts as
// an eighth of a step, since it takes a round.
const MOST_STEPS: u32 = 4096u;

// Number of boxes and primitives tested.
var<private> steps: u32;

// Number of primitives listed so far, for the blocks of each tile.
var<private> listed: array<u32, TILE_BLOCKS * QUADRANTS>;

// Primitives that may cover a sample of a tile, with the tile's number above the slot. Their blocks are determined
// later.
var<private> covering: array<Covering, KEPT + QUADRANTS>;

var<private> searched: vec2u;   // corner of the first tile, in the picture

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn search_wide_tiles(@builtin(global_invocation_id) id: vec3u) {
    let corner = pixel_in_tile(vec2u(id.x, launched_row(id))) * WIDE_TILE + vec2u(0u, frame.band.row_begin);
    if outside(corner) { return; }
    let tile = tile_at(corner, WIDE_TILE);
    searched = tile.corner;
    let bound = deepest_bound(corner);
    let found = found_in_tile(corner);
    search(tile, found, min(bound * DEEPER, FAR));
    let given_up = steps > MOST_STEPS;
    var quadrant = 0u;
    loop {
        let own = corner + corner_of(quadrant);
        if !outside(own) { finish(quadrant, own, found_in_quadrant(found, quadrant), bound, given_up); }
        quadrant += 1u;
        if quadrant >= QUADRANTS { break; }
    }
    count_pixel(corner);
    count_view(corner.y, 0u, nodes_visited, primitives_tested);
}

// Returns the offset of a tile's corner from the first tile's corner.
fn corner_of(quadrant: u32) -> vec2u {
    return vec2u(quadrant & 1u, quadrant >> 1u) * TILE;
}

// Returns the index at which a tile's results begin, given the index for the first tile.
fn found_in_quadrant(first: u32, quadrant: u32) -> u32 {
    return first + ((quadrant & 1u) + (quadrant >> 1u) * tiles_across()) * TILE_WORDS;
}

// Returns the largest of the four bounds. All four tiles are searched up to this depth.
fn deepest_bound(corner: vec2u) -> f32 {
    var deepest = 0.0;
    var quadrant = 0u;
    loop {
        let own = corner + corner_of(quadrant);
        if !outside(own) { deepest = max(deepest, bitcast<f32>(bounds[bound_place(own)])); }
        quadrant += 1u;
        if quadrant >= QUADRANTS { break; }
    }
    return min(deepest * BETWEEN, FAR);
}

// Finishes a tile's lists and appends the tile to TO_RESOLVE or SKY.
fn finish(quadrant: u32, corner: vec2u, found: u32, bound: f32, given_up: bool) {
    var anything = bound < FAR || given_up || meets_planes(Tile(corner + vec2u(0u, frame.band.first_row), vec2u(TILE)));
    var block = 0u;
    loop {
        let count = listed[quadrant * TILE_BLOCKS + block];
        anything |= count > 0u;
        lists.entries[block_list(found, block)] = select(count, LIST_MOST + 1u, given_up);
        block += 1u;
        if block >= TILE_BLOCKS { break; }
    }
    hand_on(corner, found, bound, anything);
}

// Returns the range of samples that a projection with these bounds may cover: first column, first row, last column,
// last row. Coordinates count from the corner. If a first value exceeds its last one, the range is empty.
fn covered_samples(projected: vec4f, tile: Tile) -> vec4i {
    let margin = guard_band();
    let corner = vec2f(tile.corner) + 0.5;
    let most = vec2f(tile.size) - 1.0;
    let first = ceil(clamp(projected.xy - margin - corner, vec2f(0.0), most + 1.0));
    let last = floor(clamp(projected.zw + margin - corner, vec2f(-1.0), most));
    return vec4i(vec2i(first), vec2i(last));
}

// Keeps a primitive once for each tile in which it may cover a sample.
fn keep_primitive(slot: u32, tile: Tile, projection: Projection) {
    if COUNT { primitives_tested += 1u; }
    let covered = covered_samples(projected_bounds(primitive_at(slot), projection), tile);
    var quadrant = 0u;
    loop {
        let begin = vec2i(corner_of(quadrant));
        let first = max(covered.xy - begin, vec2i(0));
        let last = min(covered.zw - begin, vec2i(i32(TILE) - 1));
        let sides = packed_sides(vec4i(first, last)) << FIRST_SIDE_BIT;
        // The entry is written even if the primitive is not kept, since entries beyond the end are ignored.
        covering[kept] = Covering(slot | (quadrant << FIRST_PIXEL_BIT), sides);
        kept += select(0u, 1u, all(first <= last));
        quadrant += 1u;
        if quadrant >= QUADRANTS { break; }
    }
}

// Reduces the kept primitives to those that may cover a block, and stores these blocks. keep_primitive has counted the
// tests.
fn narrow_kept() {
    var narrowed = 0u;
    var index = 0u;
    loop {
        if index >= kept { break; }
        let next = covering[index];
        let sides = next.blocks >> FIRST_SIDE_BIT;
        let covered = vec4i(vec4u(sides, sides >> 3u, sides >> 6u, sides >> 9u) & vec4u(7u));
        let tile = Tile(searched + corner_of(next.slot >> FIRST_PIXEL_BIT), vec2u(TILE));
        let blocks = covered_blocks(covered) & blocks_within_edges(primitive_at(next.slot & FIRST_SLOT), tile);
        covering[narrowed] = Covering(next.slot, next.blocks | blocks);
        narrowed += select(0u, 1u, blocks != 0u);
        steps += countOneBits(blocks) / 8u;
        index += 1u;
    }
    kept = narrowed;
}

// Lists the kept primitives, one block of one primitive per round, as search_tiles.wgsl does.
fn list_kept(found: u32) {
    narrow_kept();
    var index = 0u;
    var next = covering[0];
    var left = select(0u, next.blocks & ALL_BLOCKS, kept > 0u);
    loop {
        if left == 0u { break; }
        let block = firstTrailingBit(left);
        left &= left - 1u;
        let quadrant = next.slot >> FIRST_PIXEL_BIT;
        let list = block_list(found_in_quadrant(found, quadrant), block);
        let place = listed[quadrant * TILE_BLOCKS + block];
        listed[quadrant * TILE_BLOCKS + block] = place + 1u;
        let pixels = pixels_of_block(next.blocks >> FIRST_SIDE_BIT, block);
        let entry = (next.slot & FIRST_SLOT) | (pixels << FIRST_PIXEL_BIT);
        if place < LIST_MOST { lists.entries[list + 1u + place] = entry; }
        if left == 0u {
            index += 1u;
            next = covering[min(index, KEPT + QUADRANTS - 1u)];
            left = select(0u, next.blocks & ALL_BLOCKS, index < kept);
        }
    }
    kept = 0u;
}
