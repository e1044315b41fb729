// Finds the direct light at the hit of each pixel of a round.
//
// launch  one thread per list entry, dispatched indirectly
// reads   bounced    list of this round
// updates bounced    [height * width]      direct light
// adds    counters   [height * COUNTERS]

//! use bounced, counters, dice, lane, pixels, sent_rays, stack

var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn light_bounced(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    if !take_bounced(listed_thread(id)) { return; }
    let pixels = bounced_pixels();
    let pixel = pixel_of_ray(pixels, 0u);
    throw_dice(pixels, bounced.each[bounced_index].sent);
    light_last_hit();
    count_pixel(pixel);
    count_view(pixel.y, rays_asked(), nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + OWN_SHADOW_RAYS], rays_asked());
}
