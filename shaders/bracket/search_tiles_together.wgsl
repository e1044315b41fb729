// Searches the BVH like search_tiles.wgsl, with a workgroup per tile: a tile's boxes and primitives are tested side by
// side. GPUs need the threads, since a picture has few tiles. The lists have the same entries in another order.
//
// launch  one workgroup per tile
// reads   bounds    [tiles, BOUND_WORDS]  bits of a depth, and of the busy lights
// adds    counters  [height * COUNTERS]
// writes  lists     [tiles of the current rows, TILE_WORDS] after the lists
// appends lists     TO_RESOLVE, SKY: tiles of the current rows

//! use around, boxes, camera, counters, fetch, frame, lists, pixels, planes, primitive, projection, search, tiles
//! use wanted

var<storage, read> bounds: array<u32>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> lists: Lists;

// Number of threads of a workgroup.
const TEAM: u32 = 32u;
// Maximum number of boxes and primitives that a tile tests, as in search_tiles.wgsl.
const MOST_STEPS: u32 = 1024u;
// Number of links that cannot be exceeded: each tested pair of boxes adds at most two.
const MOST_LINKS: u32 = MOST_STEPS + 2u * TEAM;
// Number of leaves after which their primitives are tested. A round adds at most two for each thread.
const ENOUGH_LEAVES: u32 = TEAM;
const MOST_LEAVES: u32 = ENOUGH_LEAVES + 2u * TEAM;

// Links to follow and leaves to test, each a stack.
var<workgroup> links: array<u32, MOST_LINKS>;
var<workgroup> leaves: array<u32, MOST_LEAVES>;
// Numbers of links and leaves that this round added, and of primitives tested so far.
var<workgroup> new_links: atomic<u32>;
var<workgroup> new_leaves: atomic<u32>;
var<workgroup> primitives: atomic<u32>;
// Numbers of links and leaves, and of boxes and primitives tested, at the begin of a round.
var<workgroup> begun: vec3u;
// Number of primitives listed so far, for each block.
var<workgroup> listed: array<atomic<u32>, TILE_BLOCKS>;

@compute @workgroup_size(TEAM)
fn search_tiles_together(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let corner = group.xy * TILE + vec2u(0u, frame.band.row_begin);
    if outside(corner) || !is_any_wanted(corner) { return; }
    let tile = tile_at(corner, TILE);
    let bound = min(bitcast<f32>(bounds[bound_place(corner)]) * BETWEEN, FAR);
    let found = found_in_tile(corner);
    let given_up = search_together(tile, found, min(bound * DEEPER, FAR), thread) > MOST_STEPS;
    if thread < TILE_BLOCKS {
        let count = atomicLoad(&listed[thread]);
        lists.entries[block_list(found, thread)] = select(count, LIST_MOST + 1u, given_up);
    }
    if thread == 0u {
        var anything = bound < FAR || given_up || meets_planes(tile);
        for (var block = 0u; block < TILE_BLOCKS; block += 1u) { anything |= atomicLoad(&listed[block]) > 0u; }
        hand_on(corner, found, bound, anything);
    }
    count_pixel(corner);
    count_view(corner.y, 0u, nodes_visited, primitives_tested);
}

// Lists the primitives that may cover a pixel's centre. Returns the number of boxes and primitives tested; if it
// exceeds MOST_STEPS, the search has ended early.
fn search_together(tile: Tile, found: u32, limit: f32, thread: u32) -> u32 {
    let projection = projection_of(tile);
    let offsets = offsets_from(eye_point());
    // The root has link 0, the initial value of links[0].
    var link_count = 1u;
    var leaf_count = 0u;
    var boxes = 0u;
    loop {
        if thread == 0u {
            begun = vec3u(
                link_count + atomicExchange(&new_links, 0u),
                leaf_count + atomicExchange(&new_leaves, 0u),
                boxes + atomicLoad(&primitives),
            );
        }
        let now = workgroupUniformLoad(&begun);
        link_count = now.x;
        leaf_count = now.y;
        if now.z > MOST_STEPS || link_count + leaf_count == 0u { break; }
        if link_count > 0u && leaf_count < ENOUGH_LEAVES {
            let taken = min(link_count, TEAM);
            link_count -= taken;
            boxes += taken;
            let link = links[link_count + min(thread, taken - 1u)];
            workgroupBarrier();
            if thread < taken { follow_link(link, projection, limit, offsets, link_count, leaf_count); }
        } else {
            let taken = min(leaf_count, TEAM);
            leaf_count -= taken;
            if thread < taken { test_leaf(leaves[leaf_count + thread], tile, projection, found); }
        }
        workgroupBarrier();
    }
    return begun.z;
}

// Tests a pair of boxes, and adds the links of those that meet the frustum.
fn follow_link(
    link: u32,
    projection: Projection,
    limit: f32,
    offsets: Offsets,
    link_count: u32,
    leaf_count: u32,
) {
    if COUNT { nodes_visited += 1u; }
    let pair = pair_place(link);
    for (var side = 0u; side < 2u; side += 1u) {
        let child = child_at(pair, side, offsets);
        if !meets_frustum(child, projection, limit) { continue; }
        if (child.link & LEAF) == 0u {
            links[link_count + atomicAdd(&new_links, 1u)] = child.link;
        } else {
            leaves[leaf_count + atomicAdd(&new_leaves, 1u)] = child.link;
        }
    }
}

// Lists a leaf's primitives in the blocks that they may cover.
fn test_leaf(leaf: u32, tile: Tile, projection: Projection, found: u32) {
    let first = leaf & FIRST_SLOT;
    let count = ((leaf >> 28u) & 7u) + 1u;
    atomicAdd(&primitives, count);
    if COUNT { primitives_tested += count; }
    for (var slot = first; slot < first + count; slot += 1u) {
        let primitive = primitive_at(slot);
        let covered = covered_pixels(primitive, projection, tile);
        var left = covered_blocks(covered) & blocks_within_edges(primitive, tile);
        let sides = packed_sides(covered);
        while left != 0u {
            let block = firstTrailingBit(left);
            left &= left - 1u;
            let place = atomicAdd(&listed[block], 1u);
            let pixels = pixels_of_block(sides, block);
            let entry = slot | (pixels << FIRST_PIXEL_BIT);
            if place < LIST_MOST { lists.entries[block_list(found, block) + 1u + place] = entry; }
        }
    }
}
