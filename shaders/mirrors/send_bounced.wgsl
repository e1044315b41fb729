// Shades the hit of each pixel of a round, whose direct light is known, and sends on the rays of its surface. Pixels
// with a ray that waits are listed for the next round; the others are finished.
//
// launch  one thread per list entry, dispatched indirectly
// reads   bounced    list of this round
// updates bounced    [height * width]
// appends bounced    list of the next round
// updates view       [height * width]      color

//! use bounced, frame, lane, pixels, sent_rays, view

var<storage, read_write> view: array<Pixel>;

@compute @workgroup_size(LIST_WORKGROUP)
fn send_bounced(@builtin(global_invocation_id) id: vec3u) {
    if !take_bounced(listed_thread(id)) { return; }
    let color = send_from_last_hit();
    if waiting == 0u {
        keep_colors(bounced_pixels(), true, all3(color));
    } else {
        bounced.each[bounced_index].color = color;
        bounced.each[bounced_index].waiting = waiting;
        list_bounced(frame.paths.ray + 1u);
    }
}
