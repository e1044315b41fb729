// T-buffer, first part: the primitives that may cover the middle of a pixel of the rows at work are listed (shared/t_buffer.wgsl): those that cover few pixels,
// and the others in parts. So the vectors of a software adapter that draw them are full, and both passes draw what was projected once.
//
// launch  one thread per primitive of the tree
// adds    counters   [height * COUNTERS]
// appends drawing

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(2) var<storage, read_write> drawing: Drawing;

// Pixels that a thread draws over alone, the others of a vector waiting for it.
const FEW_PIXELS: u32 = 32u;
// Tiles of a part, of which each thread of a group has an eighth.
const PART_TILES: u32 = 64u;

@compute @workgroup_size(LIST_WORKGROUP)
fn project_primitives(@builtin(global_invocation_id) id: vec3u) {
    let index = id.y * (PROJECTED_ACROSS * LIST_WORKGROUP) + id.x;
    if index >= primitives_in_tree() { return; }
    let slot = FIRST_IN_TREE + index;
    let over = drawn_over(primitive_at(slot));
    if !is_drawn_nowhere(over) {
        let size = vec2u(over.zw - over.xy) + 1u;
        let blocks = (size + BLOCK - 1u) / BLOCK;
        if blocks.x * blocks.y * RAYS <= FEW_PIXELS {
            list_one(slot);
        } else {
            let tiles = (size + TILE - 1u) / TILE;
            list_parts(slot, tiles.x * tiles.y);
        }
    }
    count_view(counted_row(), 0u, 1u, 0u);
}

fn list_one(slot: u32) {
    let place = atomicAdd(&drawing.few.count, 1u);
    if rows_begun(place, 1u, FEW_IN_ROW) > 0u { atomicAdd(&drawing.few.workgroups_y, 1u); }
    drawing.entries[place] = slot;
}

// Lists a primitive that covers so many tiles in so many parts, or as one where there is no room for more: no thread draws a whole ground.
fn list_parts(slot: u32, tiles: u32) {
    var parts = (tiles + PART_TILES - 1u) / PART_TILES;
    if parts > 1u {
        // Looked at before it grows, so that it can't overflow.
        let is_full = atomicLoad(&drawing.further_parts) > FURTHER_PARTS;
        if is_full || atomicAdd(&drawing.further_parts, parts - 1u) + (parts - 1u) > FURTHER_PARTS { parts = 1u; }
    }
    let first = atomicAdd(&drawing.parts.count, parts);
    let begun = rows_begun(first, parts, PARTS_IN_ROW);
    if begun > 0u { atomicAdd(&drawing.parts.workgroups_y, begun); }
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
