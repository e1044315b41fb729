// Begins the rounds of pixels that show mirrors, glass or veils (partly transparent surfaces): the first round shades
// the hits in the view.
//
// launch  one thread per list entry, dispatched indirectly
// reads   lists      TO_TRACE
// reads   view       [height * width]
// writes  bounced    [height * width]
// appends bounced    list 0
// adds    counters   [height * COUNTERS]

//! use bounced, camera, counters, lane, lists, own_hits, pixels

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn begin_bounced(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_TRACE, listed_thread(id));
    if !any_ray(listed.wanted) { return; }
    let first = pixel_of_ray(listed.pixels, 0u);
    let own = rays_of(listed.pixels);
    let hits = own_hits(listed.pixels, own);
    bounced_index = pixel_index(first);
    hold(SentRay(own.origin, 0.0, of_ray3(own.direction, 0u), 0u, vec3f(1.0), 0.0));
    keep_hit(hits);
    bounced.each[bounced_index].color = vec3f(0.0);
    bounced.each[bounced_index].waiting = waiting;
    bounced.each[bounced_index].sent = 0u;
    list_bounced(0u);
    count_pixel(first);
    count_view(first.y, 0u, nodes_visited, primitives_tested);
}
