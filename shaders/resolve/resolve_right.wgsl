// Pass 3 of 3, first half: checks reprojected pixels and lists bad or missed pixels for trace_listed.wgsl. The list
// groups the few traced pixels of neighbouring threads. If they were traced here, they would delay whole subgroups of
// reused pixels. take_over.wgsl copies good pixels later.
//
// launch  one thread per block of 1x1 or 2x2 target pixels of the current rows
// reads   source    [height * width]    the depth of a point is the same for both eyes
// updates view      [height * width]    marks: key, or EMPTY, and BAD if set by mark_edges; BAD and MISSED are added
//                                       depth of listed pixels
// adds    counters  [height * COUNTERS]
// appends lists     TO_TRACE

//! use camera, counters, lane, lists, marks, pixels, stack, verify, wanted

var<storage, read> source: array<Pixel>;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> lists: Lists;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn resolve_right(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let pixels = block_pixels(id);
    let inside = inside_rows(pixels);
    if !any_ray(inside) { return; }
    var columns: U;
    var keys: U;
    var marked: U;
    var depth: F;
    var ray = 0u;
    loop {
        if of_ray_b(inside, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            let marks = view[pixel_index(pixel)].marks;
            let key = marks & KEY;
            keys = with_ray_u(keys, ray, key);
            marked = with_ray_u(marked, ray, marks & BAD);
            if key != EMPTY {
                let column = column_of(key, pixel.x);
                columns = with_ray_u(columns, ray, column);
                depth = with_ray(depth, ray, source[pixel_index(vec2u(column, pixel.y))].depth);
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let landed = inside & (keys != U(EMPTY));
    let missed = inside & (keys == U(EMPTY));
    let bad = (marked != U(0u)) | are_bad(Pixels(columns, pixels.y), depth, landed);
    var place = reserve(TO_TRACE, count_rays(missed | bad));
    ray = 0u;
    loop {
        if of_ray_b(missed | bad, ray) {
            let index = pixel_index(pixel_of_ray(pixels, ray));
            let key = of_ray_u(keys, ray);
            view[index].marks = select(key | BAD, MISSED, key == EMPTY);
            // A depth of 0 means that the pixel's ray is traced from the eye.
            view[index].depth = 0.0;
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
    count_pixel(first);
    count_view(first.y, 0u, nodes_visited, primitives_tested);
}
