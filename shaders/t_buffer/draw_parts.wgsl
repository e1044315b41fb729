// T-buffer, both passes, and the marks of a shadow-buffer: draws parts of primitives that cover many tiles. The threads
// of a group take the tiles in turn.
//
// launch  GROUP threads per part, dispatched indirectly
// reads   drawing
// updates t_buffer   [height * width * 2]; for the marks of a shadow-buffer [height * width * 4]
// adds    counters   [height * COUNTERS], and the cost map after them, if requested

//! use counters, pixels, primitive, shadow_canvas, t_buffer

var<storage, read_write> t_buffer: array<atomic<u32>>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> drawing: Drawing;

@compute @workgroup_size(LIST_WORKGROUP)
fn draw_parts(@builtin(global_invocation_id) id: vec3u) {
    let entry = id.y * PARTS_IN_ROW + id.x / GROUP;
    if entry >= atomicLoad(&drawing.parts.count) { return; }
    names_primitives = drawing.pass_at_work == SECOND_PASS;
    let slot = drawing.entries[place_of_part(entry)];
    let part = drawing.entries[place_of_part(entry) + 1u];
    let primitive = primitive_at(slot);
    let over = drawn_over(primitive, canvas_at_work());
    if is_drawn_nowhere(over) { return; }
    // Tiles are distributed again, so none is missed if drawn_over rounds differently than in project_primitives.
    let tiles = tiles_over(over);
    let parts = part >> PARTS_BIT;
    let share = (tiles + parts - 1u) / parts;
    let begin = (part & ((1u << PARTS_BIT) - 1u)) * share;
    draw_tiles(primitive, slot, over, begin + id.x % GROUP, min(begin + share, tiles), GROUP);
    count_view(counted_row(), 0u, 0u, 0u);
}
