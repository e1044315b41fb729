// Pass 3 of 4, first half: check what was reprojected; list what is bad or missing, which trace_listed.wgsl then traces. A list
// keeps the few traced pixels of neighbouring threads together: traced here, they would hold up whole subgroups of reused
// ones. Of a good pixel nothing is copied: compose and the host follow right_source.
//
// launch  one thread per block of right pixels (a pixel, or 2x2) of the rows at work
// reads   hits          [2 * height * width]  left half: a point's depth is the same for both eyes
// updates right_source  [height * width]      left column + 1, or EMPTY; BAD and MISSED are marked in the top bits (BAD
//                                             may have been marked before, by mark_edges)
// adds    counters      [height * COUNTERS]
// appends lists

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> hits: array<PixelHit>;
@group(1) @binding(2) var<storage, read_write> right_source: array<u32>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> lists: Lists;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn resolve_right(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    let inside = inside_rows(pixels);
    if !any_ray(inside) { return; }
    var source: U;
    var marked: U;
    var depth: F;
    var ray = 0u;
    loop {
        if of_ray_b(inside, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            let mark = right_source[pixel_index(pixel)];
            let column = mark & COLUMN;
            source = with_ray_u(source, ray, column);
            marked = with_ray_u(marked, ray, mark & BAD);
            if column != EMPTY {
                depth = with_ray(depth, ray, hits[pixel_index(vec2u(column - 1u, pixel.y))].depth);
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let landed = inside & (source != U(EMPTY));
    let missed = inside & (source == U(EMPTY));
    let bad = (marked != U(0u)) | are_bad(Pixels(source - 1u, pixels.y), depth, landed);
    var place = reserve(TO_TRACE, count_rays(missed | bad));
    ray = 0u;
    loop {
        if of_ray_b(missed | bad, ray) {
            let index = pixel_index(pixel_of_ray(pixels, ray));
            let column = of_ray_u(source, ray);
            right_source[index] = select(column | BAD, MISSED, column == EMPTY);
            append(TO_TRACE, place, index);
            place += 1u;
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first = pixel_of_ray(pixels, 0u);
    let row = first.y * COUNTERS;
    if any_ray(missed) { atomicAdd(&counters[row + MISSED_PIXELS], count_rays(missed)); }
    if any_ray(bad) { atomicAdd(&counters[row + BAD_PIXELS], count_rays(bad)); }
    count_pixel(right_index(first));
    count_view(first.y, RIGHT, 0u, nodes_visited, primitives_tested);
}
