// Pass 1 of 4: trace and shade one view, and keep what each pixel hit. `Naive` runs it a second time for the right.
//
// launch  one thread per pixel of the rows at work
// writes  color     [height * width]      linear RGB, 1
// writes  hits      [2 * height * width]  the eye's half: depth along the view axis, primitive id
// adds    counters  [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> color: array<vec4f>;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn trace_left(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let left = frame.eye == LEFT;
    let eye = select(frame.right_eye, frame.left_eye, left);
    let corner = select(frame.right_corner, frame.left_corner, left);
    let sample = trace_pixel(eye, pixel_direction(corner, pixel));
    color[pixel_index(pixel)] = sample.color;
    hits[select(right_index(pixel), pixel_index(pixel), left)] = sample.hit;
    count_view(pixel.y, frame.eye, shadow_rays, nodes_visited, primitives_tested);
}
