// Pass 3 of 3, last part except take_over: shades listed target pixels from their hits, with shadow rays. For `bracket`
// these are the pixels with an unknown visibility bit. For the thesis's methods these are all pixels that trace_listed
// traced.
//
// launch  one thread per list entry, or per four entries, dispatched indirectly
// reads   lists        TO_SHADE
// updates view         [height * width]      color
// writes  kept_samples texture, for views that reuse an earlier frame's bits
// adds    counters     [height * COUNTERS]

//! use camera, counters, dice, kept_samples, lane, lists, pixels, shade, stack, surfaces, view, visibility

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn shade_listed(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let listed = listed_pixels(TO_SHADE, listed_thread(id));
    if !any_ray(listed.wanted) { return; }
    let rays = rays_of(listed.pixels);
    let found = target_hits(listed.pixels, listed.wanted);
    let surfaces = surfaces_at(rays, found);
    throw_dice(listed.pixels, 0u);
    ask_source(listed.pixels, found, surfaces);
    let shaded = shade(rays, found, surfaces);
    keep_colors(listed.pixels, listed.wanted, shaded.color);
    keep_samples(listed.pixels, listed.wanted, shaded);
    let first = pixel_of_ray(listed.pixels, 0u);
    count_pixel(first);
    count_view(first.y, rays_asked(), nodes_visited, primitives_tested);
}
