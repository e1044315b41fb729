// A tile's search, whatever its size: it gathers leaves of the BVH, which the kernel's own keep_primitive and list_kept
// take from there; its own `steps` and MOST_STEPS say when to give up.

// Between two samples a surface may lie a little deeper than both.
const BETWEEN: f32 = 1.001;
// The search goes a little deeper than the bound: rounding.
const DEEPER: f32 = 1.0001;
// Leaves that are gathered before their primitives are looked at.
const LEAVES: u32 = 32u;
// Links to open stand from 0 on, leaves from here down.
const FIRST_LEAF: u32 = STACK_SIZE + LEAVES - 1u;
// Primitives that are kept, to be listed in their blocks together.
const KEPT: u32 = 64u;

// Samples of the side of a tile that is searched for the four tiles in it.
const WIDE_TILE: u32 = 16u;

// A primitive that may cover a pixel's centre in a tile.
struct Covering {
    slot: u32,
    blocks: u32,   // a bit for each; from FIRST_SIDE_BIT on the first column and row and the last ones, 3 bits each
}

const FIRST_SIDE_BIT: u32 = 16u;

var<private> kept: u32;

fn search(tile: Tile, found: u32, limit: f32) {
    let projection = projection_of(tile);
    let offsets = offsets_from(frame.target_eye);
    var links: array<u32, STACK_SIZE + LEAVES>;
    links[0] = DONE;
    var top = 0u;
    var link = 0u;
    loop {
        // Leaves are gathered first: a subgroup's threads then do the same most of the time.
        var gathered = 0u;
        loop {
            if COUNT { nodes_visited += 1u; }
            steps += 1u;
            let place = pair_place(link);
            let a = child_at(place, 0u, offsets);
            let b = child_at(place, 1u, offsets);
            let met_a = meets_frustum(a, projection, limit);
            let met_b = meets_frustum(b, projection, limit);
            // Written whether met or not: what stands past the ends does not count.
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

// Which of a block's pixels are covered, a bit each, row by row.
fn pixels_of_block(sides: u32, block: u32) -> u32 {
    let x = block % BLOCKS * 2u;
    let y = block / BLOCKS * 2u;
    let columns = select(0u, 1u, (sides & 7u) <= x) | select(0u, 2u, ((sides >> 6u) & 7u) > x);
    let rows = select(0u, 3u, ((sides >> 3u) & 7u) <= y) | select(0u, 12u, (sides >> 9u) > y);
    return (columns * 5u) & rows;
}
