// Pass 3 of 4, first half: check what was reprojected and take over what is good; list the rest, which
// trace_listed.wgsl then traces. A list keeps the few traced pixels of neighbouring threads together: traced here,
// they would hold up whole subgroups of reused ones.
//
// launch  one thread per right pixel of the rows at work
// reads   left_color    [height * width]
// updates hits          [2 * height * width]  reads the left half, writes the right: a point's depth is the same
//                                             for both eyes
// updates right_source  [height * width]      left column + 1, or EMPTY; BAD and MISSED are marked in the top bits
// writes  right_color   [height * width]
// adds    counters      [height * COUNTERS]
// appends to_trace

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> left_color: array<vec4f>;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> right_source: array<u32>;
@group(1) @binding(4) var<storage, read_write> right_color: array<vec4f>;
@group(1) @binding(5) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(6) var<storage, read_write> to_trace: TraceList;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn resolve_right(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let index = pixel_index(pixel);
    let source = right_source[index];
    let row = pixel.y * COUNTERS;
    if source == EMPTY {
        right_source[index] = MISSED;
        atomicAdd(&counters[row + MISSED_PIXELS], 1u);
        append(index);
        return;
    }
    let left_pixel = vec2u(source - 1u, pixel.y);
    let left = hits[pixel_index(left_pixel)];
    if is_bad(left_pixel, left) {
        right_source[index] = source | BAD;
        atomicAdd(&counters[row + BAD_PIXELS], 1u);
        append(index);
    } else {
        right_color[index] = left_color[pixel_index(left_pixel)];
        hits[right_index(pixel)] = left;
    }
    count_view(pixel.y, RIGHT, 0u, nodes_visited, primitives_tested);
}

// The order of the list depends on the threads; each entry writes only its own pixel, so the picture does not.
fn append(index: u32) {
    let place = atomicAdd(&to_trace.count, 1u);
    to_trace.pixels[place] = index;
    if place % LIST_WORKGROUP == 0u { atomicAdd(&to_trace.workgroups_x, 1u); }
}
