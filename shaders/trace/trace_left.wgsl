// Pass 1 of 3: traces and shades one view, and stores the hit of each pixel. `Naive` runs it for every view.
//
// launch  one thread per block of 1x1 or 2x2 pixels of the current rows
// writes  view          [height * width]
// writes  kept_samples  texture, for `bracket`
// adds    counters      [height * COUNTERS], and the cost map after them, if requested

//! use camera, counters, dice, lane, pixels, shade, stack, view, wanted

var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn trace_left(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    leave_out(pixels, wanted);
    if !any_ray(wanted) { return; }
    let samples = trace_pixels(rays_of(pixels), wanted);
    keep_view(pixels, wanted, samples);
    let first = pixel_of_ray(pixels, 0u);
    count_pixel(first);
    count_view(first.y, rays_asked(), nodes_visited, primitives_tested);
}
