// Pass 3 of 3 of `bracket`, third part: trace the target's pixels that resolve_tiles left unfinished, from the depth on up to which nothing
// is, and shade them with the source's shadow bits, with shadow rays where these don't agree.
//
// launch  one thread per entry of the list, or per four, dispatched indirectly
// reads   lists        TO_TRACE
// updates view         [height * width]
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> lists: Lists;
@group(1) @binding(2) var<storage, read_write> view: array<Pixel>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_bounded(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_TRACE, id.x);
    if !any_ray(listed.wanted) { return; }
    let free = target_hits(listed.pixels, listed.wanted).t;
    let rays = Rays(frame.target_eye, pixel_directions(frame.target_corner, listed.pixels));
    let nearest = closest_hit(rays, free, select(F(NEVER), F(FAR), listed.wanted));
    let surfaces = surfaces_at(rays, nearest);
    taken = taken_bits(listed.pixels, nearest, surfaces);
    let samples = shade(rays, nearest, surfaces);
    let packed = packed_srgb(samples.color);
    var ray = 0u;
    loop {
        if of_ray_b(listed.wanted, ray) {
            let index = pixel_index(pixel_of_ray(listed.pixels, ray));
            var pixel = pixel_of(samples, packed, ray);
            pixel.marks = view[index].marks | select(0u, ASKED, of_ray_b(asked, ray));
            view[index] = pixel;
            keep_linear(index, of_ray3(samples.color, ray));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first = pixel_of_ray(listed.pixels, 0u);
    count_pixel(first);
    count_view(first.y, shadow_rays, nodes_visited, primitives_tested);
}
