// T-buffer, first part: lists primitives that may cover the centre of a pixel of the current rows
// (shared/t_buffer.wgsl). For the marks of a shadow-buffer, it lists primitives that may cover any part of a texel.
// There are three lists: primitives that cover few pixels, primitives that cover a few tiles, and parts of larger
// primitives. This keeps the vectors of a software adapter full during drawing, and both passes use one projection.
//
// launch  one thread per primitive of the tree
// adds    counters   [height * COUNTERS]
// appends drawing

//! use counters, lane, pixels, primitive, shadow_canvas, t_buffer

var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> drawing: Drawing;

// Maximum number of pixels of a primitive in the first list, and maximum number of tiles that a thread draws alone. The
// rest of the thread's vector waits meanwhile.
const FEW_PIXELS: u32 = 32u;
const MORE_TILES: u32 = 8u;
// Number of tiles of a part. Each thread of a group draws an eighth of them.
const PART_TILES: u32 = 64u;
// Maximum number of parts of a primitive, so that the parts of all primitives can be counted.
const MOST_PARTS: u32 = 64u;

@compute @workgroup_size(LIST_WORKGROUP)
fn project_primitives(@builtin(global_invocation_id) id: vec3u) {
    let index = id.y * (PROJECTED_ACROSS * LIST_WORKGROUP) + id.x;
    if index >= primitives_in_tree() { return; }
    let slot = FIRST_IN_TREE + index;
    let primitive = primitive_at(slot);
    let canvas = canvas_at_work();
    let over = drawn_over(primitive, canvas);
    if !is_drawn_nowhere(over) && !is_out_of_sight(primitive, canvas) {
        let blocks = (vec2u(over.zw + 1 - over.xy) + BLOCK - 1u) / BLOCK;
        let tiles = tiles_over(over);
        if blocks.x * blocks.y * RAYS <= FEW_PIXELS {
            drawing.entries[atomicAdd(&drawing.few.count, 1u)] = slot;
        } else if tiles <= MORE_TILES {
            drawing.entries[place_of_more(atomicAdd(&drawing.more.count, 1u))] = slot;
        } else {
            list_parts(slot, tiles);
        }
    }
    count_view(counted_row(), 0u, 1u, 0u);
}

// Lists a primitive that covers this many tiles in parts, or as one part if there is no room. So no thread draws a very
// large primitive alone.
fn list_parts(slot: u32, tiles: u32) {
    var parts = clamp((tiles + PART_TILES - 1u) / PART_TILES, 1u, MOST_PARTS);
    if parts > 1u && atomicAdd(&drawing.further_parts, parts - 1u) + (parts - 1u) > FURTHER_PARTS { parts = 1u; }
    let first = atomicAdd(&drawing.parts.count, parts);
    var part = 0u;
    loop {
        let place = place_of_part(first + part);
        drawing.entries[place] = slot;
        drawing.entries[place + 1u] = part | (parts << PARTS_BIT);
        part += 1u;
        if part >= parts { break; }
    }
    cut_short |= part < parts;
}
