// Pass 3 of 3, second half: trace and shade the target's pixels that resolve_right listed.
//
// launch  one thread per entry of the list, or per four, dispatched indirectly
// reads   lists        pixel indices
// writes  view         [height * width]      all but marks
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> lists: Lists;
@group(1) @binding(2) var<storage, read_write> view: array<Pixel>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_listed(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_TRACE, id.x);
    if !any_ray(listed.wanted) { return; }
    let pixels = listed.pixels;
    let wanted = listed.wanted;
    let samples = trace_pixels(Rays(frame.target_eye, pixel_directions(frame.target_corner, pixels)), wanted);
    let packed = packed_srgb(samples.color);
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let index = pixel_index(pixel_of_ray(pixels, ray));
            var pixel = pixel_of(samples, packed, ray);
            pixel.marks = view[index].marks;
            view[index] = pixel;
            keep_linear(index, of_ray3(samples.color, ray));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first_pixel = pixel_of_ray(pixels, 0u);
    count_pixel(first_pixel);
    count_view(first_pixel.y, shadow_rays, nodes_visited, primitives_tested);
}
