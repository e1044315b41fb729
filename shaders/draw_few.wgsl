// T-buffer, both passes: primitives that cover few pixels, each over all of these. One kernel serves both passes, so that a t of the second is that of the first.
//
// launch  one thread per entry of the few, dispatched indirectly
// reads   drawing
// updates t_buffer   [height * width * 2]
// adds    counters   [height * COUNTERS], and a map of costs behind them, if one is asked for

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> t_buffer: array<atomic<u32>>;
@group(1) @binding(2) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> drawing: Drawing;

@compute @workgroup_size(LIST_WORKGROUP)
fn draw_few(@builtin(global_invocation_id) id: vec3u) {
    let entry = id.y * FEW_IN_ROW + id.x;
    if entry >= atomicLoad(&drawing.few.count) { return; }
    names_primitives = drawing.pass_at_work == SECOND_PASS;
    let slot = drawing.entries[entry];
    let primitive = primitive_at(slot);
    let over = drawn_over(primitive);
    // Found elsewhere to cover something: by other rounding it may be nothing.
    if is_drawn_nowhere(over) { return; }
    let corner = vec2u(over.xy);
    let blocks = (vec2u(over.zw) + 1u - corner + BLOCK - 1u) / BLOCK;
    var block = vec2u(0u);
    loop {
        var pixels: Pixels;
        var later: Later;
        loop {
            pixels = pixels_from(corner + block * BLOCK);
            later = draw(primitive, slot, pixels, over.zw);
            block.x += 1u;
            if block.x >= blocks.x { block = vec2u(0u, block.y + 1u); }
            if !is_none(later) || block.y >= blocks.y { break; }
        }
        draw_again(primitive, slot, pixels, later);
        if block.y >= blocks.y { break; }
    }
    cut_short |= block.y < blocks.y;
    count_view(counted_row(), 0u, 0u, 0u);
}
