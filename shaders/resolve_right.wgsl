// Pass 3 of 4, first half: check what was reprojected and take over what is good; list the rest, which
// trace_listed.wgsl then traces. A list keeps the few traced pixels of neighbouring threads together: traced here,
// they would hold up whole subgroups of reused ones.
//
// launch  one thread per block of right pixels (a pixel, or 2x2) of the rows at work
// reads   left_color    [height * width]
// updates hits          [2 * height * width]  reads the left half, writes the right: a point's depth is the same
//                                             for both eyes
// updates right_source  [height * width]      left column + 1, or EMPTY; BAD and MISSED are marked in the top bits (BAD
//                                             may have been marked before, by mark_edges)
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
    let pixels = block_pixels(id);
    let inside = inside_rows(pixels);
    if !any_ray(inside) { return; }
    var source: U;
    var marked: U;
    var depth: F;
    var primitive: U;
    var ray = 0u;
    loop {
        if of_ray_b(inside, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            let mark = right_source[pixel_index(pixel)];
            let column = mark & COLUMN;
            source = with_ray_u(source, ray, column);
            marked = with_ray_u(marked, ray, mark & BAD);
            if column != EMPTY {
                let left = hits[pixel_index(vec2u(column - 1u, pixel.y))];
                depth = with_ray(depth, ray, left.depth);
                primitive = with_ray_u(primitive, ray, primitive_of(left));
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let landed = inside & (source != U(EMPTY));
    let bad = (marked != U(0u)) | are_bad(Pixels(source - 1u, pixels.y), depth, landed);
    ray = 0u;
    loop {
        if of_ray_b(inside, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            let index = pixel_index(pixel);
            let row = pixel.y * COUNTERS;
            let column = of_ray_u(source, ray);
            if column == EMPTY {
                right_source[index] = MISSED;
                atomicAdd(&counters[row + MISSED_PIXELS], 1u);
                append(index);
            } else if of_ray_b(bad, ray) {
                right_source[index] = column | BAD;
                atomicAdd(&counters[row + BAD_PIXELS], 1u);
                append(index);
            } else {
                right_color[index] = left_color[pixel_index(vec2u(column - 1u, pixel.y))];
                hits[right_index(pixel)] = pixel_hit(of_ray(depth, ray), of_ray_u(primitive, ray));
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first = pixel_of_ray(pixels, 0u);
    count_pixel(right_index(first));
    count_view(first.y, RIGHT, 0u, nodes_visited, primitives_tested);
}

// The order of the list depends on the threads; each entry writes only its own pixel, so the picture does not.
fn append(index: u32) {
    let place = atomicAdd(&to_trace.count, 1u);
    to_trace.pixels[place] = index;
    if place % (LIST_WORKGROUP * RAYS) == 0u { atomicAdd(&to_trace.workgroups_x, 1u); }
}
