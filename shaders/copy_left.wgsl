// `Ideal`: the left view copied to the right, the bound on what reuse can save. Also every method's path where the
// interaxial is 0: right equals left.
//
// launch  one thread per pixel
// reads   left_color   [height * width]
// updates hits         [2 * height * width]
// writes  right_color  [height * width]

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> left_color: array<vec4f>;
@group(1) @binding(2) var<storage, read_write> hits: array<PixelHit>;
@group(1) @binding(3) var<storage, read_write> right_color: array<vec4f>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn copy_left(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    right_color[pixel_index(pixel)] = left_color[pixel_index(pixel)];
    if KEEP_HITS { hits[right_index(pixel)] = hits[pixel_index(pixel)]; }
}
