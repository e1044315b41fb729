// Traces and shades all rays of the pixels that are left after the last round. In turn, a thread does for a ray what
// the kernels of a round do.
//
// launch  one thread per list entry, dispatched indirectly
// reads   bounced    list after the last round
// updates bounced    [height * width]
// updates view       [height * width]      color
// adds    counters   [height * COUNTERS]

//! use bounced, bvh, counters, dice, lane, pixels, planes, sent_rays, stack, view

var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

const TRACE: u32 = 0u;
const LIGHT: u32 = 1u;
const SEND: u32 = 2u;

@compute @workgroup_size(LIST_WORKGROUP)
fn finish_bounced(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    if !take_bounced(listed_thread(id)) { return; }
    let pixels = bounced_pixels();
    let pixel = pixel_of_ray(pixels, 0u);
    var sent = 0u;
    var turn = TRACE;
    loop {
        if turn == TRACE {
            keep_hit(closest_hit(rays_of_sent(last_ray()), F(0.0), F(FAR)));
            sent += 1u;
            turn = LIGHT;
        } else if turn == LIGHT {
            throw_dice(pixels, bounced.each[bounced_index].sent + sent);
            light_last_hit();
            turn = SEND;
        } else {
            bounced.each[bounced_index].color = send_from_last_hit();
            turn = TRACE;
            if waiting == 0u || cut_short { break; }
        }
    }
    cut_short |= waiting > 0u;
    keep_colors(pixels, true, all3(bounced.each[bounced_index].color));
    count_pixel(pixel);
    count_view(pixel.y, rays_asked(), nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + SENT_RAYS], sent);
    atomicAdd(&counters[pixel.y * COUNTERS + OWN_SHADOW_RAYS], rays_asked());
}
