// Pass 4 of 4: encode both views as 8-bit sRGB. Reused right pixels take their colour from the left view here, by reference:
// nothing is copied before. Anaglyphs, packings and maps are made of the pair on the host (src/output/): a user tries several
// kinds on one pair, and none is worth a second render.
//
// launch  one thread per pixel
// writes  pictures                 [2 * height * width]  RGBA8, red in the low byte; left view, then right
// reads   left_color               [height * width]      linear RGB in 0..1
// reads   right_color              [height * width]      the same, where it was traced (right_*.wgsl)
// reads   right_source             [height * width]      where right pixels come from, by the reuse methods (right_marked.wgsl)

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> pictures: array<u32>;
@group(1) @binding(2) var<storage, read> left_color: array<vec4f>;

fn srgb(linear: vec3f) -> vec3f {
    let high = 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055;
    return select(high, 12.92 * linear, linear <= vec3f(0.0031308));
}

fn pack(color: vec4f) -> u32 {
    let c = vec3u(floor(srgb(color.xyz) * 255.0 + 0.5));
    return c.x | (c.y << 8u) | (c.z << 16u) | 0xff000000u;
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn compose(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let left = pack(left_color[pixel_index(pixel)]);
    pictures[pixel_index(pixel)] = left;
    pictures[right_index(pixel)] = right_picture(pixel, left);
}
