// Pass 3 of 4, second half: trace and shade the right pixels that resolve_right listed.
//
// launch  one thread per entry of the list, dispatched indirectly
// reads   to_trace     pixel indices
// writes  hits         [2 * height * width]  right half
// writes  right_color  [height * width]
// adds    counters     [height * COUNTERS]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> to_trace: TraceList;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> right_color: array<vec4f>;
@group(1) @binding(4) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_listed(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= atomicLoad(&to_trace.count) { return; }
    let index = to_trace.pixels[id.x];
    let width = frame.image_size.x;
    let pixel = vec2u(index % width, index / width);
    let sample = trace_pixel(frame.right_eye, pixel_direction(frame.right_corner, pixel));
    right_color[index] = sample.color;
    hits[right_index(pixel)] = sample.hit;
    count_view(pixel.y, RIGHT, shadow_rays, nodes_visited, primitives_tested);
}
