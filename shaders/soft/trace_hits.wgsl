// Pass 1 of 3 with soft light, first part: finds the hit of each pixel of a view. trace_soft and shade_hits follow.
//
// launch  one thread per block of 1x1 or 2x2 pixels of the current rows
// writes  view      [height * width]      all fields except color
// adds    counters  [height * COUNTERS]

//! use bvh, camera, counters, lane, pixels, planes, rays, stack, view, wanted

var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn trace_hits(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    leave_out(pixels, wanted);
    if !any_ray(wanted) { return; }
    let rays = rays_of(pixels);
    let nearest = closest_hit(rays, F(0.0), select(F(NEVER), F(FAR), wanted));
    keep_hits(pixels, wanted, nearest);
    let first = pixel_of_ray(pixels, 0u);
    count_pixel(first);
    count_view(first.y, 0u, nodes_visited, primitives_tested);
}
