// Pass 3 of 4, second half: trace and shade the right pixels that resolve_right listed.
//
// launch  one thread per entry of the list, or per four, dispatched indirectly
// reads   lists        pixel indices
// writes  hits         [2 * height * width]  right half
// writes  right_color  [height * width]
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> lists: Lists;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> right_color: array<vec4f>;
@group(1) @binding(4) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_listed(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_TRACE, id.x);
    if !any_ray(listed.wanted) { return; }
    let pixels = listed.pixels;
    let wanted = listed.wanted;
    let samples = trace_pixels(Rays(frame.right_eye, pixel_directions(frame.right_corner, pixels)), wanted);
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let pixel = pixel_of_ray(pixels, ray);
            right_color[pixel_index(pixel)] = vec4f(of_ray3(samples.color, ray), 1.0);
            let hit = sample_hit(samples, ray);
            if KEEP_HITS { hits[right_index(pixel)] = hit; }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first_pixel = pixel_of_ray(pixels, 0u);
    count_pixel(right_index(first_pixel));
    count_view(first_pixel.y, RIGHT, shadow_rays, nodes_visited, primitives_tested);
}
