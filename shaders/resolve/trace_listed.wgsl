// Pass 3 of 3, after resolve_right or resolve_tiles: traces the target pixels that those kernels listed. Each ray
// begins at the depth up to which space is known to be empty. shade_listed or shade_tiles shades the hits.
//
// launch  one thread per list entry, or per four entries, dispatched indirectly
// reads   lists        TO_TRACE
// updates view         [height * width]      depth and slot; reads depth as the distance up to which space is empty
// adds    counters     [height * COUNTERS]

//! use bvh, camera, counters, lane, lists, pixels, planes, rays, stack, view

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_listed(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let listed = listed_pixels(TO_TRACE, listed_thread(id));
    if !any_ray(listed.wanted) { return; }
    let free = target_hits(listed.pixels, listed.wanted).t;
    let rays = rays_of(listed.pixels);
    let nearest = closest_hit(rays, free, select(F(NEVER), F(FAR), listed.wanted));
    keep_hits(listed.pixels, listed.wanted, nearest);
    let first = pixel_of_ray(listed.pixels, 0u);
    count_pixel(first);
    count_view(first.y, 0u, nodes_visited, primitives_tested);
}
