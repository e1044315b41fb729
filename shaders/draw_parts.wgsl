// T-buffer, both passes: parts of primitives that cover more pixels, tile by tile. Of a triangle only the blocks of 2x2 pixels are drawn that may lie within its
// edges.
//
// launch  GROUP threads per part, dispatched indirectly
// reads   drawing
// updates t_buffer   [height * width * 2]
// adds    counters   [height * COUNTERS], and a map of costs behind them, if one is asked for

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> t_buffer: array<atomic<u32>>;
@group(1) @binding(2) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> drawing: Drawing;

// A lane's turns at a block of 2x2 pixels.
const TURNS: u32 = 4u / RAYS;

@compute @workgroup_size(LIST_WORKGROUP)
fn draw_parts(@builtin(global_invocation_id) id: vec3u) {
    let entry = id.y * PARTS_IN_ROW + id.x / GROUP;
    if entry >= atomicLoad(&drawing.parts.count) { return; }
    names_primitives = drawing.pass_at_work == SECOND_PASS;
    let slot = drawing.entries[place_of_part(entry)];
    let part = drawing.entries[place_of_part(entry) + 1u];
    let primitive = primitive_at(slot);
    let over = drawn_over(primitive);
    if is_drawn_nowhere(over) { return; }
    let corner = vec2u(over.xy);
    let size = vec2u(over.zw) + 1u - corner;
    let tiles = (size + TILE - 1u) / TILE;
    // Shared out anew: where drawn_over rounded otherwise before, no tile is left out.
    let parts = part >> PARTS_BIT;
    let share = (tiles.x * tiles.y + parts - 1u) / parts;
    let begin = (part & ((1u << PARTS_BIT) - 1u)) * share;
    let end = min(begin + share, tiles.x * tiles.y);
    var tile = begin + id.x % GROUP;
    loop {
        // Its next tile with something to draw.
        var blocks = 0u;
        var first = vec2u(0u);
        loop {
            if tile >= end { break; }
            first = corner + vec2u(tile % tiles.x, tile / tiles.x) * TILE;
            blocks = blocks_to_draw(primitive, Tile(first, min(vec2u(TILE), corner + size - first)));
            tile += GROUP;
            if blocks != 0u { break; }
        }
        draw_blocks(primitive, slot, first, blocks, over.zw);
        if tile >= end { break; }
    }
    cut_short |= tile < end;
    count_view(counted_row(), 0u, 0u, 0u);
}

fn blocks_to_draw(primitive: Primitive, tile: Tile) -> u32 {
    let all = vec4i(vec2i(0), vec2i(tile.size) - 1);
    return covered_blocks(all) & blocks_within_edges(primitive, tile);
}

// Draws over some blocks of a tile, a bit each, row by row.
fn draw_blocks(primitive: Primitive, slot: u32, first: vec2u, blocks: u32, last: vec2i) {
    var left = blocks;
    var turn = 0u;
    loop {
        if left == 0u { break; }
        var pixels: Pixels;
        var later: Later;
        loop {
            let block = firstTrailingBit(left);
            let place = vec2u(block % BLOCKS, block / BLOCKS) * 2u + vec2u(turn & 1u, turn >> 1u);
            pixels = pixels_from(first + place);
            later = draw(primitive, slot, pixels, last);
            turn += 1u;
            if turn >= TURNS {
                turn = 0u;
                left &= left - 1u;
            }
            if !is_none(later) || left == 0u { break; }
        }
        draw_again(primitive, slot, pixels, later);
    }
    cut_short |= left != 0u;
}
