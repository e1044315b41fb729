// Finds the hit of the next ray of each pixel of a round.
//
// launch  one thread per list entry, dispatched indirectly
// reads   bounced    list of this round
// updates bounced    [height * width]      the ray's hit
// adds    counters   [height * COUNTERS]

//! use bounced, bvh, counters, lane, pixels, planes, rays, stack

var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_bounced(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    if !take_bounced(listed_thread(id)) { return; }
    let ray = last_ray();
    keep_hit(closest_hit(Rays(ray.origin, all3(ray.direction)), F(0.0), F(FAR)));
    bounced.each[bounced_index].sent += 1u;
    let pixel = pixel_of_ray(bounced_pixels(), 0u);
    count_pixel(pixel);
    count_view(pixel.y, 0u, nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + SENT_RAYS], 1u);
}
