// Pass 3 of 3 of `bracket`, first part: one BVH query for each tile of target pixels (docs/BRACKET.md). The tile's
// frustum is searched as deep as the source samples that land there. Each of its blocks of 2x2 pixels gets a list of
// the primitives that may cover one of its pixel centres.
//
// launch  one thread per tile
// reads   bounds    [tiles, BOUND_WORDS]  bits of a depth, and of the busy lights
// adds    counters  [height * COUNTERS]
// writes  lists     [tiles of the current rows, TILE_WORDS] after the lists
// appends lists     TO_RESOLVE, SKY: tiles of the current rows

//! use around, counters, frame, lists, pixels, planes, primitive, projection, search, tiles, wanted

var<storage, read> bounds: array<u32>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> lists: Lists;

// Maximum number of boxes and primitives that a tile tests. If a tile needs more, its pixels are traced. That is
// cheaper, since its lists would overflow anyway. The limit also keeps a thread far below the number of rounds after
// which a software adapter ends loops.
const MOST_STEPS: u32 = 1024u;

// Number of boxes and primitives tested.
var<private> steps: u32;

// Number of primitives listed so far, for each block.
var<private> listed: array<u32, TILE_BLOCKS>;

var<private> covering: array<Covering, KEPT + 1u>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn search_tiles(@builtin(global_invocation_id) id: vec3u) {
    let corner = pixel_in_tile(vec2u(id.x, launched_row(id))) * TILE + vec2u(0u, frame.band.row_begin);
    if outside(corner) || !is_any_wanted(corner) { return; }
    let tile = tile_at(corner, TILE);
    let bound = min(bitcast<f32>(bounds[bound_place(corner)]) * BETWEEN, FAR);
    let found = found_in_tile(corner);
    search(tile, found, min(bound * DEEPER, FAR));
    var anything = bound < FAR || meets_planes(tile);
    let given_up = steps > MOST_STEPS;
    anything |= given_up;
    var block = 0u;
    loop {
        anything |= listed[block] > 0u;
        lists.entries[block_list(found, block)] = select(listed[block], LIST_MOST + 1u, given_up);
        block += 1u;
        if block >= TILE_BLOCKS { break; }
    }
    hand_on(corner, found, bound, anything);
    count_pixel(corner);
    count_view(corner.y, 0u, nodes_visited, primitives_tested);
}

// Keeps a primitive that may cover a pixel's centre.
fn keep_primitive(slot: u32, tile: Tile, projection: Projection) {
    if COUNT { primitives_tested += 1u; }
    let primitive = primitive_at(slot);
    let covered = covered_pixels(primitive, projection, tile);
    let blocks = covered_blocks(covered) & blocks_within_edges(primitive, tile);
    // The entry is written even if the primitive is not kept, since entries beyond the end are ignored.
    covering[kept] = Covering(slot, blocks | (packed_sides(covered) << FIRST_SIDE_BIT));
    kept += select(0u, 1u, blocks != 0u);
}

// Lists the kept primitives, one block of one primitive per round. So the threads of a subgroup wait little for each
// other, whether their primitives cover few blocks or many.
fn list_kept(found: u32) {
    var index = 0u;
    var next = covering[0];
    var left = select(0u, next.blocks & ALL_BLOCKS, kept > 0u);
    loop {
        if left == 0u { break; }
        let block = firstTrailingBit(left);
        left &= left - 1u;
        let place = listed[block];
        listed[block] = place + 1u;
        let entry = next.slot | (pixels_of_block(next.blocks >> FIRST_SIDE_BIT, block) << FIRST_PIXEL_BIT);
        if place < LIST_MOST { lists.entries[block_list(found, block) + 1u + place] = entry; }
        if left == 0u {
            index += 1u;
            next = covering[min(index, KEPT - 1u)];
            left = select(0u, next.blocks & ALL_BLOCKS, index < kept);
        }
    }
    kept = 0u;
}
