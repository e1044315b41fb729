// Adds what this thread did to its row's counters of the view.
fn count_view(row: u32, shadow: u32, nodes: u32, primitives: u32) {
    let words = row * COUNTERS;
    if cut_short { atomicAdd(&counters[words + CUT_SHORT], 1u); }
    if shadow > 0u { atomicAdd(&counters[words + SHADOW_RAYS], shadow); }
    if COUNT {
        atomicAdd(&counters[words + NODES_VISITED], nodes);
        atomicAdd(&counters[words + PRIMITIVES_TESTED], primitives);
    }
}

override COST_MAP: bool = false;

// Adds what this thread did to its pixel; such a pipeline has one ray a lane. The map stands behind the rows' counters.
fn count_pixel(pixel: vec2u) {
    if COST_MAP {
        atomicAdd(&counters[frame.image_size.y * COUNTERS + pixel_index(pixel)], nodes_visited + primitives_tested);
    }
}
