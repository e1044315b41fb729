// Pass 3 of 4 of `bracket`, third part: trace the right pixels that resolve_tiles left unfinished, from the depth on up to which nothing
// is, and shade them with the left view's shadow bits, with shadow rays where these don't agree.
//
// launch  one thread per entry of the list, or per four, dispatched indirectly
// reads   lists        TO_TRACE
// updates hits         [2 * height * width]  right half
// writes  right_color  [height * width]      linear RGB, 1
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> lists: Lists;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> right_color: array<vec4f>;
@group(1) @binding(4) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_bounded(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_TRACE, id.x);
    if !any_ray(listed.wanted) { return; }
    let free = right_hits(listed.pixels, listed.wanted).t;
    let rays = Rays(frame.right_eye, pixel_directions(frame.right_corner, listed.pixels));
    let nearest = closest_hit(rays, free, select(F(NEVER), F(FAR), listed.wanted));
    let surfaces = surfaces_at(rays, nearest);
    taken = taken_bits(listed.pixels, nearest, surfaces);
    let samples = shade(rays, nearest, surfaces);
    var ray = 0u;
    loop {
        if of_ray_b(listed.wanted, ray) {
            let pixel = pixel_of_ray(listed.pixels, ray);
            right_color[pixel_index(pixel)] = vec4f(of_ray3(samples.color, ray), 1.0);
            var hit = sample_hit(samples, ray);
            hit.slot |= (hits[right_index(pixel)].slot & (BAD | MISSED)) | select(0u, ASKED, of_ray_b(asked, ray));
            hits[right_index(pixel)] = hit;
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first = pixel_of_ray(listed.pixels, 0u);
    count_pixel(right_index(first));
    count_view(first.y, RIGHT, shadow_rays, nodes_visited, primitives_tested);
}
