// T-buffer, both passes, and the marks of a shadow-buffer: draws primitives that cover few pixels. One thread draws all
// pixels of a primitive. One kernel serves both passes, so that both compute the same t.
//
// launch  one thread per FEW_EACH entries of the list `few`, dispatched indirectly
// reads   drawing
// updates t_buffer   [height * width * 2]; for the marks of a shadow-buffer [height * width * 4]
// adds    counters   [height * COUNTERS], and the cost map after them, if requested

//! use counters, lane, pixels, primitive, shadow_canvas, t_buffer

var<storage, read_write> t_buffer: array<atomic<u32>>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> drawing: Drawing;

@compute @workgroup_size(LIST_WORKGROUP)
fn draw_few(@builtin(global_invocation_id) id: vec3u) {
    // The threads of a workgroup first take neighbouring entries, then the next ones.
    let first = id.y * FEW_IN_ROW + id.x / LIST_WORKGROUP * (LIST_WORKGROUP * FEW_EACH) + id.x % LIST_WORKGROUP;
    let end = min(first + LIST_WORKGROUP * FEW_EACH, atomicLoad(&drawing.few.count));
    if first >= end { return; }
    names_primitives = drawing.pass_at_work == SECOND_PASS;
    let canvas = canvas_at_work();
    var entry = first;
    var block = vec2u(0u);
    loop {
        var slot: u32;
        var primitive: Primitive;
        var pixels: Pixels;
        var later: Later;
        loop {
            slot = drawing.entries[entry];
            primitive = primitive_at(slot);
            let over = drawn_over(primitive, canvas);
            let corner = vec2u(over.xy);
            let blocks = (vec2u(max(over.zw + 1 - over.xy, vec2i(0))) + BLOCK - 1u) / BLOCK;
            loop {
                // A primitive that touches a shadow-buffer's texels often covers no texel's centre. It may also cover
                // nothing now, if bounds are rounded differently than in project_primitives.
                if any(block >= blocks) { break; }
                pixels = pixels_from(corner + block * BLOCK);
                later = draw(primitive, slot, pixels, over.zw);
                block.x += 1u;
                if block.x >= blocks.x { block = vec2u(0u, block.y + 1u); }
                if !is_none(later) { break; }
            }
            if any(block >= blocks) {
                block = vec2u(0u);
                entry += LIST_WORKGROUP;
            }
            if !is_none(later) || entry >= end { break; }
        }
        draw_again(primitive, slot, pixels, later);
        if entry >= end { break; }
    }
    cut_short |= entry < end;
    count_view(counted_row(), 0u, 0u, 0u);
}
