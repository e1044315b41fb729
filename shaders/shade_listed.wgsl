// Pass 3 of 4 of `bracket`, fourth part: shade the right pixels for which some light needs a shadow ray.
//
// launch  one thread per entry of the list, or per four, dispatched indirectly
// reads   lists        pixel indices
// reads   hits         [2 * height * width]
// writes  right_color  [height * width]      linear RGB, 1
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> lists: Lists;
@group(1) @binding(2) var<storage, read> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> right_color: array<vec4f>;
@group(1) @binding(4) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn shade_listed(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_LIGHT, id.x);
    if !any_ray(listed.wanted) { return; }
    let rays = Rays(frame.right_eye, pixel_directions(frame.right_corner, listed.pixels));
    let found = right_hits(listed.pixels, listed.wanted);
    let surfaces = surfaces_at(rays, found);
    taken = taken_bits(listed.pixels, found, surfaces);
    let samples = shade(rays, found, surfaces);
    var ray = 0u;
    loop {
        if of_ray_b(listed.wanted, ray) {
            right_color[pixel_index(pixel_of_ray(listed.pixels, ray))] = vec4f(of_ray3(samples.color, ray), 1.0);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    let first = pixel_of_ray(listed.pixels, 0u);
    count_pixel(right_index(first));
    count_view(first.y, RIGHT, shadow_rays, nodes_visited, primitives_tested);
}
