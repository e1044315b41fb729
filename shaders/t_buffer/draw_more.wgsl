// T-buffer, both passes, and the marks of a shadow-buffer: draws primitives that cover a few tiles, one thread each.
//
// launch  one thread per entry of the list `more`, dispatched indirectly
// reads   drawing
// updates t_buffer   [height * width * 2]; for the marks of a shadow-buffer [height * width * 4]
// adds    counters   [height * COUNTERS], and the cost map after them, if requested

//! use counters, pixels, primitive, shadow_canvas, t_buffer

var<storage, read_write> t_buffer: array<atomic<u32>>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> drawing: Drawing;

@compute @workgroup_size(LIST_WORKGROUP)
fn draw_more(@builtin(global_invocation_id) id: vec3u) {
    let entry = id.y * MORE_IN_ROW + id.x;
    if entry >= atomicLoad(&drawing.more.count) { return; }
    names_primitives = drawing.pass_at_work == SECOND_PASS;
    let slot = drawing.entries[place_of_more(entry)];
    let primitive = primitive_at(slot);
    let over = drawn_over(primitive, canvas_at_work());
    if is_drawn_nowhere(over) { return; }
    draw_tiles(primitive, slot, over, 0u, tiles_over(over), 1u);
    count_view(counted_row(), 0u, 0u, 0u);
}
