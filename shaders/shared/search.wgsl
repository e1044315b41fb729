// The search of a tile's frustum for primitives, for tiles of any size. It gathers leaves of the BVH, which the
// kernel's keep_primitive and list_kept process. The kernel's `steps` and MOST_STEPS limit the search.

//! use around, boxes, camera, counters, fetch, frame, in_steps, lane, lists, pixels, projection, tiles

// Factor on the depth bound. Between two samples, a surface may lie slightly deeper than both.
const BETWEEN: f32 = 1.001;
// Factor on the depth limit. Because of rounding, the search goes slightly deeper than the bound.
const DEEPER: f32 = 1.0001;
// Maximum number of leaves gathered before their primitives are tested.
const LEAVES: u32 = 32u;
// Index of the first leaf in `links`. Links to follow grow from index 0 upwards, leaves from this index downwards.
const FIRST_LEAF: u32 = STACK_SIZE + LEAVES - 1u;
// Maximum number of primitives kept before they are all listed in their blocks.
const KEPT: u32 = 64u;

// Side, in samples, of the square that search_wide_tiles searches at once: four tiles.
const WIDE_TILE: u32 = 16u;

// Returns the tile with this corner, which counts rows from the band's first.
fn tile_at(corner: vec2u, side: u32) -> Tile {
    let size = min(vec2u(side), vec2u(frame.band.size.x, frame.band.row_end) - corner);
    return Tile(corner + vec2u(0u, frame.band.first_row), size);
}

// Returns the packed sides of a range of a tile's pixels: first column and row, last column and row, 3 bits each.
fn packed_sides(covered: vec4i) -> u32 {
    let sides = vec4u(covered) << vec4u(0u, 3u, 6u, 9u);
    return (sides.x | sides.y) | (sides.z | sides.w);
}

// Stores a searched tile's bound and busy lights, and appends the tile to TO_RESOLVE or SKY.
fn hand_on(corner: vec2u, found: u32, bound: f32, anything: bool) {
    lists.entries[found] = bitcast<u32>(bound);
    lists.entries[found + BUSY_WORD] = bounds[bound_place(corner) + 1u];
    let list = select(SKY, TO_RESOLVE, anything);
    let tile_index = (corner.y - frame.band.row_begin) / TILE * tiles_across() + corner.x / TILE;
    append(list, reserve_for(list, 1u, LIST_WORKGROUP * RAYS / TILE_PIXELS), tile_index);
}

// A primitive that may cover a pixel's centre in a tile.
struct Covering {
    slot: u32,
    blocks: u32,   // one bit per block; from FIRST_SIDE_BIT on first column and row, last column and row, 3 bits each
}

const FIRST_SIDE_BIT: u32 = 16u;

var<private> kept: u32;

fn search(tile: Tile, found: u32, limit: f32) {
    let projection = projection_of(tile);
    let offsets = offsets_from(eye_point());
    var links: array<u32, STACK_SIZE + LEAVES>;
    links[0] = DONE;
    var top = 0u;
    var link = 0u;
    loop {
        // Leaves are gathered first, so that a subgroup's threads do the same work most of the time.
        var gathered = 0u;
        loop {
            if COUNT { nodes_visited += 1u; }
            steps += 1u;
            let place = pair_place(link);
            let a = child_at(place, 0u, offsets);
            let b = child_at(place, 1u, offsets);
            let met_a = meets_frustum(a, projection, limit);
            let met_b = meets_frustum(b, projection, limit);
            // Links are written even if their box is missed, since entries beyond the ends are ignored.
            let leaf_a = (a.link & LEAF) != 0u;
            links[select(top + 1u, FIRST_LEAF - gathered, leaf_a)] = a.link;
            top += select(0u, 1u, met_a & !leaf_a);
            gathered += select(0u, 1u, met_a & leaf_a);
            let leaf_b = (b.link & LEAF) != 0u;
            links[select(top + 1u, FIRST_LEAF - gathered, leaf_b)] = b.link;
            top += select(0u, 1u, met_b & !leaf_b);
            gathered += select(0u, 1u, met_b & leaf_b);
            link = links[top];
            top -= 1u;
            if link == DONE || gathered + 2u > LEAVES || steps > MOST_STEPS { break; }
        }
        var leaf = 0u;
        let first_leaf = links[FIRST_LEAF];
        var slot = first_leaf & FIRST_SLOT;
        var last = slot + ((first_leaf >> 28u) & 7u);
        loop {
            loop {
                if leaf >= gathered || kept >= KEPT { break; }
                keep_primitive(slot, tile, projection);
                steps += 1u;
                slot += 1u;
                if slot > last {
                    leaf += 1u;
                    let next = links[FIRST_LEAF - min(leaf, LEAVES - 1u)];
                    slot = next & FIRST_SLOT;
                    last = slot + ((next >> 28u) & 7u);
                }
            }
            if kept < KEPT { break; }
            list_kept(found);
        }
        if link == DONE || steps > MOST_STEPS { break; }
    }
    list_kept(found);
}

// Returns which of a block's pixels are covered, one bit each, row by row.
fn pixels_of_block(sides: u32, block: u32) -> u32 {
    let x = block % BLOCKS * 2u;
    let y = block / BLOCKS * 2u;
    let columns = select(0u, 1u, (sides & 7u) <= x) | select(0u, 2u, ((sides >> 6u) & 7u) > x);
    let rows = select(0u, 3u, ((sides >> 3u) & 7u) <= y) | select(0u, 12u, (sides >> 9u) > y);
    return (columns * 5u) & rows;
}
