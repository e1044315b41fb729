// Pass 1 of 3 with soft light, last part: shades a view from its hits and writes its pixels.
//
// launch  one thread per block of 1x1 or 2x2 pixels of the current rows
// updates view          [height * width]
// writes  kept_samples  texture, for `bracket`
// adds    counters      [height * COUNTERS]; reads the masks after them

//! use camera, counters, dice, lane, pixels, shade, stack, surfaces, view, wanted

var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn shade_hits(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    leave_out(pixels, wanted);
    if !any_ray(wanted) { return; }
    throw_dice(pixels, 0u);
    let rays = rays_of(pixels);
    let found = target_hits(pixels, wanted);
    keep_view(pixels, wanted, shade(rays, found, surfaces_at(rays, found)));
    let first = pixel_of_ray(pixels, 0u);
    count_pixel(first);
    count_view(first.y, rays_asked(), nodes_visited, primitives_tested);
}
