// Pass 1 of 4: trace and shade one view, and keep what each pixel hit. `Naive` runs it a second time for the right.
//
// launch  one thread per block of pixels (a pixel, or 2x2) of the rows at work
// writes  color     [height * width]      linear RGB, 1
// writes  hits      [2 * height * width]  the eye's half: depth along the view axis, primitive id (by bracket its place instead)
// writes  left_samples                    texture, by bracket
// adds    counters  [height * COUNTERS]      and a map of costs behind them, if one is asked for

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> color: array<vec4f>;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn trace_left(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    if !any_ray(wanted) { return; }
    let left = frame.eye == LEFT;
    let eye = select(frame.right_eye, frame.left_eye, left);
    let corner = select(frame.right_corner, frame.left_corner, left);
    let samples = trace_pixels(Rays(eye, pixel_directions(corner, pixels)), wanted);
    keep_pixels(pixels, wanted, samples);
    let first = pixel_of_ray(pixels, 0u);
    count_pixel(select(right_index(first), pixel_index(first), left));
    count_view(first.y, frame.eye, shadow_rays, nodes_visited, primitives_tested);
}
