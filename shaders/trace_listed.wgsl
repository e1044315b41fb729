// Pass 3 of 3, behind resolve_right or resolve_tiles: trace the target's pixels that these listed, from the depth on up
// to which nothing is. shade_listed or shade_tiles shades what is hit.
//
// launch  one thread per entry of the list, or per four, dispatched indirectly
// reads   lists        TO_TRACE
// updates view         [height * width]      depth, up to which nothing is before; slot
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> lists: Lists;
@group(1) @binding(2) var<storage, read_write> view: array<Pixel>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_listed(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_TRACE, id.x);
    if !any_ray(listed.wanted) { return; }
    let free = target_hits(listed.pixels, listed.wanted).t;
    let rays = Rays(frame.target_eye, pixel_directions(frame.target_corner, listed.pixels));
    let nearest = closest_hit(rays, free, select(F(NEVER), F(FAR), listed.wanted));
    keep_hits(listed.pixels, listed.wanted, nearest);
    let first = pixel_of_ray(listed.pixels, 0u);
    count_pixel(first);
    count_view(first.y, 0u, nodes_visited, primitives_tested);
}
