// Shades pixels that show mirrors, glass or veils (partly transparent surfaces), in one dispatch, for CPU adapters.
// Their light comes from the first hits in the view and from the rays that these surfaces reflect and transmit. These
// rays are traced for each eye and are not reused.
//
// launch  one thread per list entry, dispatched indirectly
// reads   lists      TO_TRACE
// updates view       [height * width]      color
// adds    counters   [height * COUNTERS]

//! use bounced, bvh, camera, counters, dice, lane, lists, own_hits, pixels, planes, sent_rays, shade, stack, view

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

var<private> pending: array<SentRay, MOST_WAITING>;
var<private> waiting: u32;

fn hold(ray: SentRay) {
    pending[waiting] = ray;
    waiting += 1u;
}

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_mirrored(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let listed = listed_pixels(TO_TRACE, listed_thread(id));
    if !any_ray(listed.wanted) { return; }
    let first = pixel_of_ray(listed.pixels, 0u);
    let own = rays_of(listed.pixels);
    var ray = SentRay(own.origin, 0.0, of_ray3(own.direction, 0u), 0u, vec3f(1.0), 0.0);
    var hits = own_hits(listed.pixels, own);
    var color = vec3f(0.0);
    var sent_rays = 0u;
    loop {
        throw_dice(listed.pixels, sent_rays);
        let surfaces = surfaces_met(ray, hits);
        color += brought_by(ray, hits, surfaces, light_from(ray.origin, surfaces));
        if waiting == 0u { break; }
        waiting -= 1u;
        ray = pending[waiting];
        hits = closest_hit(rays_of_sent(ray), F(0.0), F(FAR));
        sent_rays += 1u;
        if cut_short { break; }
    }
    cut_short |= waiting > 0u;
    keep_colors(listed.pixels, listed.wanted, all3(color));
    count_pixel(first);
    count_view(first.y, rays_asked(), nodes_visited, primitives_tested);
    atomicAdd(&counters[first.y * COUNTERS + SENT_RAYS], sent_rays);
    atomicAdd(&counters[first.y * COUNTERS + OWN_SHADOW_RAYS], rays_asked());
}
